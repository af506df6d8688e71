//! Settings of Zenoh for each participant: mutual TLS, and access control.
//!
//! Zenoh judges a message by the certificate of the connection that it came over, at the receiver. In a mesh every pair
//! has a connection, so that messages over robot 2's connection can be checked against robot 2's keys. Messages that a
//! router forwards come over the router's certificate: in a star the robots must trust the coordinator completely.
//!
//! Everything that is not listed is denied. All participants may receive everything: messages are not secret within a
//! mission.

use dragnet_proto::key::{Mission, Selection, Topic};
use dragnet_scenario::participant::Participant;
use serde_json::{Value, json};

use crate::name::Name;
use crate::register::{Entry, Register, Topology};

/// All message types of Zenoh's access control.
const ALL: [&str; 9] = [
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "declare_queryable",
    "reply",
    "liveliness_token",
    "declare_liveliness_subscriber",
    "liveliness_query",
];
/// Those that subscribe.
const LISTENING: [&str; 3] = ["declare_subscriber", "declare_liveliness_subscriber", "liveliness_query"];
/// Those that publish.
const SPEAKING: [&str; 2] = ["put", "liveliness_token"];
/// Those that answer queries.
const ANSWERING: [&str; 2] = ["declare_queryable", "reply"];

/// The Zenoh settings of a certificate's owner, JSON, to be placed in the folder of the certificate's files.
#[must_use]
pub fn settings(register: &Register, mission: &Mission, owner: Name) -> Value {
    let [certificate, key] = [format!("{owner}.pem"), format!("{owner}.key")];
    let mode = match (register.topology, owner) {
        (Topology::Mesh, _) => "peer",
        (Topology::Star, Name::COORDINATOR) => "router",
        (Topology::Star, _) => "client",
    };
    json!({
        "mode": mode,
        "listen": { "endpoints": [], "exit_on_failure": true },
        "connect": { "timeout_ms": -1, "exit_on_failure": false },
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "transport": { "link": { "protocols": ["tls"], "tls": {
            "root_ca_certificate": "authority.pem",
            "listen_certificate": certificate, "listen_private_key": key,
            "connect_certificate": certificate, "connect_private_key": key,
            "enable_mtls": true,
            "verify_name_on_connect": are_hosts_known(register),
            "close_link_on_expiration": true,
        } } },
        "access_control": access_control(register, mission),
    })
}

/// Host names are verified once every certificate has hosts. Until then only the certificate identifies a peer, as
/// access control does anyway.
fn are_hosts_known(register: &Register) -> bool {
    register.holders().iter().all(|entry| !entry.hosts.is_empty())
}

/// The same for every process of a participant: two robots with the same number, from one folder of keys on two
/// computers, must receive each other to detect this.
fn access_control(register: &Register, mission: &Mission) -> Value {
    let everything = [mission.expression(Selection::Everything)];
    let mut rules = vec![
        rule("told to all", "egress", "allow", &ALL, &everything),
        rule("asked by all", "ingress", "allow", &LISTENING, &everything),
    ];
    let mut subjects = Vec::new();
    let mut policies = Vec::new();
    for entry in register.holders() {
        let name = entry.common_name();
        let mut applied = vec!["told to all".to_owned(), "asked by all".to_owned()];
        for (what, messages, keys) in spoken(register.topology, mission, entry.name) {
            let id = format!("{what} {name}");
            rules.push(rule(&id, "ingress", "allow", messages, &keys));
            applied.push(id);
        }
        policies.push(json!({ "id": name, "rules": applied, "subjects": [name] }));
        subjects.push(json!({ "id": name, "cert_common_names": [name] }));
    }
    let revoked: Vec<String> = register.revoked().map(Entry::common_name).collect();
    if !revoked.is_empty() {
        // Without a rule nothing is allowed either; with one, attempts are logged by name.
        let keys = ["**".to_owned()];
        rules.push(rule("nothing from", "ingress", "deny", &ALL, &keys));
        rules.push(rule("nothing to", "egress", "deny", &ALL, &keys));
        subjects.push(json!({ "id": "revoked", "cert_common_names": revoked }));
        policies.push(
            json!({ "id": "revoked", "rules": ["nothing from", "nothing to"], "subjects": ["revoked"] }),
        );
    }
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules, "subjects": subjects, "policies": policies,
    })
}

fn rule(id: &str, flow: &str, permission: &str, messages: &[&str], keys: &[String]) -> Value {
    json!({ "id": id, "flows": [flow], "permission": permission, "messages": messages, "key_exprs": keys })
}

type Spoken = (&'static str, &'static [&'static str], Vec<String>);

/// Which messages, under which keys, may come over a participant's connection.
fn spoken(topology: Topology, mission: &Mission, name: Name) -> Vec<Spoken> {
    let simulator = mission.expression(Selection::Simulator);
    match name {
        Name::COORDINATOR if topology == Topology::Star => {
            vec![("passed on by", &ALL, vec![mission.expression(Selection::Everything)])]
        }
        Name::Participant(participant) => {
            let mut spoken: Vec<Spoken> = vec![
                ("said by", &SPEAKING, vec![mission.expression(Selection::PublishedBy(participant))]),
                ("answered by", &ANSWERING, answers(mission, participant)),
            ];
            if participant == Participant::Coordinator {
                spoken.push(("asked by", &["query"], vec![mission.expression(Selection::Pictures)]));
            }
            spoken
        }
        Name::Simulator => vec![("shown by", &["put", "query"], vec![simulator])],
    }
}

/// Where a participant answers the simulator, and a robot the coordinator.
fn answers(mission: &Mission, participant: Participant) -> Vec<String> {
    let picture = match participant {
        Participant::Robot(robot) => Some(Topic::Picture(robot)),
        Participant::Coordinator => None,
    };
    let topics = [Topic::SimStep(participant)].into_iter().chain(picture);
    topics.map(|topic| mission.key(topic).to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn register(topology: Topology) -> Register {
        let entry =
            |name, serial, revoked| Entry { name, serial, valid_until: 0, revoked, hosts: Vec::new() };
        let mut register = Register::new(&"valley".parse().unwrap(), topology);
        register.certificates = vec![
            entry(Name::robot(1).unwrap(), 2, false),
            entry(Name::robot(2).unwrap(), 3, true),
            entry(Name::robot(2).unwrap(), 4, false),
            entry(Name::COORDINATOR, 5, false),
        ];
        register
    }

    /// Keys under which `owner` accepts a message of this kind from a certificate.
    fn accepted(topology: Topology, owner: Name, from: &str, message: &str) -> Vec<String> {
        let register = register(topology);
        let settings = settings(&register, &register.mission().unwrap(), owner);
        let access = &settings["access_control"];
        let list = |value: &Value| -> Vec<Value> { value.as_array().unwrap().clone() };
        let mut keys = Vec::new();
        for policy in list(&access["policies"]) {
            let subjects = list(&access["subjects"]);
            let is_meant = subjects.iter().any(|subject| {
                policy["subjects"].as_array().unwrap().contains(&subject["id"])
                    && subject["cert_common_names"].as_array().unwrap().contains(&json!(from))
            });
            for rule in list(&access["rules"]) {
                let applies = policy["rules"].as_array().unwrap().contains(&rule["id"])
                    && rule["flows"] == json!(["ingress"])
                    && rule["permission"] == "allow"
                    && rule["messages"].as_array().unwrap().contains(&json!(message));
                if is_meant && applies {
                    keys.extend(list(&rule["key_exprs"]).iter().map(|key| key.as_str().unwrap().to_owned()));
                }
            }
        }
        keys
    }

    #[test]
    fn each_publishes_under_its_own_keys_and_a_revoked_certificate_nowhere() {
        let check = |from: &str, message: &str, expected: &[&str]| {
            assert_eq!(
                accepted(Topology::Mesh, Name::robot(1).unwrap(), from, message),
                expected,
                "{message} of {from}"
            );
        };
        check("robot-2#4", "put", &["dragnet/valley/robots/2/**"]);
        check("robot-2#4", "liveliness_token", &["dragnet/valley/robots/2/**"]);
        check("robot-2#4", "reply", &["dragnet/valley/sim/step/2", "dragnet/valley/robots/2/picture"]);
        check("robot-2#4", "query", &[]);
        check("coordinator#5", "query", &["dragnet/valley/robots/*/picture"]);
        check("coordinator#5", "reply", &["dragnet/valley/sim/step/coordinator"]);
        check("robot-2#4", "declare_subscriber", &["dragnet/valley/**"]);
        check("robot-2#4", "delete", &[]);
        check("robot-2#3", "put", &[]);
        check("robot-2#3", "declare_subscriber", &[]);
        check("coordinator#5", "put", &["dragnet/valley/coordinator/**"]);
        // Its own number, on another computer.
        check("robot-1#2", "liveliness_token", &["dragnet/valley/robots/1/**"]);
        check("stranger", "put", &[]);
    }

    #[test]
    fn in_a_star_robots_trust_the_coordinator_and_it_trusts_each_under_its_own_keys() {
        let robot = Name::robot(1).unwrap();
        assert_eq!(accepted(Topology::Star, robot, "coordinator#5", "put"), ["dragnet/valley/**"]);
        let received = accepted(Topology::Star, Name::COORDINATOR, "robot-1#2", "put");
        assert_eq!(received, ["dragnet/valley/robots/1/**"]);
    }
}
