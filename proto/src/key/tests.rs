use proptest::prelude::*;

use super::*;

fn mission() -> Mission {
    "ice-cream_1".parse().unwrap()
}

fn participants() -> impl Strategy<Value = Participant> {
    prop_oneof![robots().prop_map(Participant::Robot), Just(Participant::Coordinator)]
}

fn robots() -> impl Strategy<Value = RobotId> {
    (1..=u16::MAX).prop_map(|number| RobotId::new(number).unwrap())
}

fn topics() -> impl Strategy<Value = Topic> {
    let pair = || (participants(), participants());
    prop_oneof![
        robots().prop_map(Topic::Observation),
        robots().prop_map(Topic::Intent),
        robots().prop_map(Topic::Heartbeat),
        (participants(), any::<u8>(), any::<u64>()).prop_map(|(participant, seniority, identity)| {
            Topic::Alive { participant, claim: Claim { seniority, identity } }
        }),
        (participants(), any::<[u32; 4]>()).prop_map(|(participant, [map, robots, prior, mission])| {
            Topic::Scenario { participant, digest: ScenarioDigest { map, robots, prior, mission } }
        }),
        pair().prop_map(|(from, to)| Topic::SyncRequest { from, to }),
        pair().prop_map(|(from, to)| Topic::SyncReply { from, to }),
        Just(Topic::Status),
        participants().prop_map(Topic::Verdicts),
        participants().prop_map(Topic::Orders),
        participants().prop_map(Topic::Zones),
        participants().prop_map(Topic::Marks),
        participants().prop_map(Topic::SimStep),
        robots().prop_map(Topic::SimSensed),
    ]
}

proptest! {
    #[test]
    fn a_key_is_read_as_it_was_written(mission in "[a-z0-9_-]{1,64}", topic in topics()) {
        let key = mission.parse::<Mission>().unwrap().key(topic);
        prop_assert_eq!(key.to_string().parse::<Key>().unwrap(), key);
    }

    #[test]
    fn a_text_that_is_a_key_is_the_only_one_of_it(
        text in "(dragnet|drag)/[a-z]{1,2}/(robots|coordinator|sim)(/(0?[0-9]{1,5}|[0-9a-f]{16}|observation|verdicts|orders|zones|marks|alive|sync_reply|step|coordinator)){0,4}",
    ) {
        if let Ok(key) = text.parse::<Key>() {
            prop_assert_eq!(key.to_string(), text);
        }
    }

    #[test]
    fn any_text_is_read_without_panic(text in ".*") {
        let _ = text.parse::<Key>();
    }

    #[test]
    fn a_message_travels_where_its_kind_and_sender_are_read(topic in topics()) {
        if let Some((kind, from)) = topic.speech() {
            let to = match topic {
                Topic::SyncRequest { to, .. } | Topic::SyncReply { to, .. } => Audience::One(to),
                _ => Audience::All,
            };
            prop_assert_eq!(Topic::of(kind, from, to), Some(topic));
        }
    }
}

#[test]
fn keys_are_spelled_as_documented() {
    let check = |topic, expected: &str| {
        assert_eq!(mission().key(topic).to_string(), format!("dragnet/ice-cream_1/{expected}"));
    };
    let (robot, three) = (RobotId::new(12).unwrap(), Participant::Robot(RobotId::new(3).unwrap()));
    check(Topic::Observation(robot), "robots/12/observation");
    let claim = Claim { seniority: 0, identity: 0xab };
    check(Topic::Alive { participant: three, claim }, "robots/3/alive/0/00000000000000ab");
    let claim = Claim { seniority: Claim::TAKES_OVER, identity: u64::MAX };
    let coordinator = Topic::Alive { participant: Participant::Coordinator, claim };
    check(coordinator, "coordinator/alive/255/ffffffffffffffff");
    let digest = ScenarioDigest { map: 1, robots: 2, prior: 3, mission: 0xab };
    let scenario = Topic::Scenario { participant: three, digest };
    check(scenario, "robots/3/scenario/00000001-00000002-00000003-000000ab");
    check(
        Topic::SyncRequest { from: three, to: Participant::Coordinator },
        "robots/3/sync_request/coordinator",
    );
    check(Topic::SyncReply { from: Participant::Coordinator, to: three }, "coordinator/sync_reply/3");
    check(Topic::Status, "coordinator/status");
    check(Topic::Verdicts(Participant::Coordinator), "coordinator/verdicts");
    check(Topic::Verdicts(three), "robots/3/verdicts");
    check(Topic::Orders(Participant::Coordinator), "coordinator/orders");
    check(Topic::Zones(Participant::Coordinator), "coordinator/zones");
    check(Topic::Marks(Participant::Coordinator), "coordinator/marks");
    check(Topic::Orders(three), "robots/3/orders");
    check(Topic::Zones(three), "robots/3/zones");
    check(Topic::Marks(three), "robots/3/marks");
    check(Topic::SimStep(Participant::Coordinator), "sim/step/coordinator");
    check(Topic::SimStep(three), "sim/step/3");
    check(Topic::SimSensed(robot), "sim/sensed/12");
}

#[test]
fn a_wrong_key_is_rejected_with_the_allowed_ones() {
    let check = |key: &str, expected: &str| {
        let error = key.parse::<Key>().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    check("dragnet/m/robots/03/observation", "robot \"03\"; allowed are 1 to 65535");
    check("dragnet/m/robots/0/intent", "robot \"0\"");
    check("dragnet/m/robots/65536/intent", "robot \"65536\"");
    check("dragnet/m/robots/+3/intent", "robot \"+3\"");
    check("dragnet/m/sim/step/nobody", "robot \"nobody\"");
    check("dragnet/A b/coordinator/alive", "mission \"A b\": allowed are 1 to 64 characters");
    check("dragnet//coordinator/alive", "mission \"\"");
    check("other/m/coordinator/alive", "allowed are keys like");
    check("dragnet/m/robots/3/observation/", "allowed are keys like");
    check("dragnet/m/robots/3", "allowed are keys like");
    for alive in
        ["0/AB", "00000000000000ab", "01/00000000000000ab", "256/00000000000000ab", "+1/00000000000000ab"]
    {
        check(&format!("dragnet/m/robots/3/alive/{alive}"), "allowed are keys like");
    }
    check("dragnet/m", "allowed are keys like");
    check("", "allowed are keys like");
}

#[test]
fn participants_publish_under_their_own_keys_only() {
    let robot = Participant::Robot(RobotId::FIRST);
    let of = |kind, from, to| Topic::of(kind, from, to);
    assert_eq!(of(MessageKind::Intent, Participant::Coordinator, Audience::All), None);
    assert_eq!(of(MessageKind::Observation, Participant::Coordinator, Audience::All), None);
    assert_eq!(of(MessageKind::MissionStatus, robot, Audience::All), None);
    assert_eq!(of(MessageKind::SyncReply, robot, Audience::All), None);
    assert_eq!(of(MessageKind::Intent, robot, Audience::One(robot)), None);
}

/// `*` is one chunk, `**` any number, as Zenoh says.
fn matches(expression: &[&str], key: &[&str]) -> bool {
    match (expression, key) {
        ([], []) => true,
        (["**", rest @ ..], _) => (0..=key.len()).any(|skipped| matches(rest, &key[skipped..])),
        (["*", rest @ ..], [_, key @ ..]) => matches(rest, key),
        ([chunk, rest @ ..], [first, key @ ..]) => chunk == first && matches(rest, key),
        _ => false,
    }
}

#[test]
fn a_selection_matches_its_keys_and_no_others() {
    let (three, four) =
        (Participant::Robot(RobotId::new(3).unwrap()), Participant::Robot(RobotId::new(4).unwrap()));
    let coordinator = Participant::Coordinator;
    let digest = ScenarioDigest { map: 1, robots: 2, prior: 3, mission: 4 };
    let topics = [
        Topic::Observation(RobotId::new(3).unwrap()),
        Topic::Intent(RobotId::new(4).unwrap()),
        Topic::Heartbeat(RobotId::new(3).unwrap()),
        Topic::Alive { participant: three, claim: Claim { seniority: 0, identity: 1 } },
        Topic::Alive { participant: coordinator, claim: Claim { seniority: 1, identity: 2 } },
        Topic::SyncRequest { from: coordinator, to: three },
        Topic::SyncRequest { from: four, to: three },
        Topic::SyncRequest { from: three, to: coordinator },
        Topic::SyncReply { from: four, to: three },
        Topic::SimSensed(RobotId::new(3).unwrap()),
        Topic::SimStep(three),
        Topic::Status,
        Topic::Verdicts(three),
        Topic::Verdicts(coordinator),
        Topic::Orders(three),
        Topic::Orders(coordinator),
        Topic::Zones(three),
        Topic::Zones(coordinator),
        Topic::Marks(three),
        Topic::Marks(coordinator),
        Topic::Scenario { participant: three, digest },
        Topic::Scenario { participant: coordinator, digest },
    ];
    let check = |selection, expected: &[Topic]| {
        let expression = mission().expression(selection);
        let selected = topics.iter().copied().filter(|&topic| {
            let key = mission().key(topic).to_string();
            let chunks: Vec<&str> = key.split('/').collect();
            matches(&expression.split('/').collect::<Vec<_>>(), &chunks)
        });
        assert_eq!(selected.collect::<Vec<_>>(), expected, "{expression}");
    };
    check(Selection::Observations, &topics[0..1]);
    check(Selection::Intents, &topics[1..2]);
    check(Selection::Heartbeats, &topics[2..3]);
    check(Selection::Alive, &topics[3..5]);
    check(Selection::Verdicts, &topics[12..14]);
    check(Selection::Orders, &topics[14..16]);
    check(Selection::Zones, &topics[16..18]);
    check(Selection::Marks, &topics[18..20]);
    check(Selection::Scenarios, &topics[20..22]);
    check(Selection::SyncRequestsTo(three), &topics[5..7]);
    check(Selection::SyncRequestsTo(coordinator), &topics[7..8]);
    check(Selection::SyncRepliesTo(three), &topics[8..9]);
}
