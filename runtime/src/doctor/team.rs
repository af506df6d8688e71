//! Checks of the team's network: participants, duplicate numbers, and clocks.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_proto::clock;
use dragnet_proto::convert::Codec;
use dragnet_proto::key::Mission;
use dragnet_proto::scenario_digest::{Difference, ScenarioDigest};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;
use tokio::time::Instant;

use super::Finding;
use super::clocks::{Clocks, Expected};
use crate::clock::Clock;
use crate::link::{Incoming, Link, ReceiveOnly};
use crate::session::{Endpoints, open};

/// The robot of the settings.
pub(super) struct Member<'a> {
    pub(super) mission: Mission,
    pub(super) robot: RobotId,
    pub(super) scenario: &'a Scenario,
    /// Whether the robot itself runs on this computer.
    pub(super) runs_here: bool,
    /// The clock by which it would continue, if it has one.
    pub(super) resumed: Option<Clock>,
    /// Mission seconds per second.
    pub(super) real_time_factor: f64,
}

/// The participants and messages received in a while.
#[derive(Default)]
struct Roll {
    present: BTreeSet<Participant>,
    clocks: Clocks,
    refused: BTreeMap<String, String>,
    /// Participants with several processes.
    doubled: BTreeSet<Participant>,
    /// Participants with another scenario.
    others: BTreeMap<Participant, Difference>,
}

pub(super) async fn examine(
    endpoints: &Endpoints,
    member: &Member<'_>,
    listen: Duration,
    tell: &mut dyn FnMut(Finding),
) {
    let session = match open(endpoints).await {
        Ok(session) => session,
        Err(error) => {
            let advice = "see that `zenoh` names what Zenoh takes, and files that are there";
            return tell(Finding::fail("network", error.to_string(), advice));
        }
    };
    let codec = Codec::new(member.scenario.terrain().grid());
    let joined = Link::join(session, member.mission.clone(), ReceiveOnly, codec).await;
    let resumed = member.resumed.map(|clock| clock.now());
    let roll = match joined {
        Ok(mut link) => {
            link.set_scenario(ScenarioDigest::of(member.scenario));
            call(&mut link, listen).await
        }
        Err(error) => return tell(Finding::fail("network", error.to_string(), "")),
    };
    tell(mates(&roll, endpoints, member, listen));
    number(&roll, member).into_iter().for_each(&mut *tell);
    for (key, reason) in &roll.refused {
        let advice =
            "another version, map or mission is running there: give all the same scenario and program";
        tell(Finding::fail("team", format!("what came under {key} was refused: {reason}"), advice));
    }
    for participant in
        roll.doubled.iter().filter(|participant| **participant != Participant::Robot(member.robot))
    {
        let advice = "give each robot a number of its own, and start it once; participant was started again after its computer \
                      had died is there twice for ten seconds";
        tell(Finding::fail("team", format!("{participant} is there twice"), advice));
    }
    for (participant, difference) in &roll.others {
        let found = format!("{participant} has another scenario than these settings: {difference}");
        let advice = "give all the same scenario, with the files that it names, and start them again";
        tell(Finding::fail("team", found, advice));
    }
    let (me, mission) = (Participant::Robot(member.robot), member.scenario.mission());
    let expected = Expected {
        me,
        resumed,
        real_time_factor: member.real_time_factor,
        tolerance: mission.clock_tolerance,
    };
    roll.clocks.findings(expected).into_iter().for_each(&mut *tell);
    if roll.clocks.is_empty() && roll.present.iter().any(|participant| *participant != me) {
        let (seconds, heartbeat) =
            (listen.as_secs_f64(), mission.heartbeat.as_secs_f64() / member.real_time_factor);
        tell(Finding::pass(
            "clocks",
            format!(
                "nobody told the mission's time within {seconds:.0} s: it has not begun, or `--listen` is to be longer than \
                 the {heartbeat:.0} s from one sign of life to the next"
            ),
        ));
    }
}

async fn call(link: &mut Link<ReceiveOnly>, listen: Duration) -> Roll {
    let (mut roll, started) = (Roll::default(), Instant::now());
    while let Ok(Some(received)) = tokio::time::timeout_at(started + listen, link.receive()).await {
        match received {
            Incoming::Message { from, message, .. } => {
                if let Some(time) = clock::dated(from, &message) {
                    roll.clocks.receive(from, started.elapsed(), time);
                }
            }
            Incoming::Rejected { key, reason, .. } => {
                roll.refused.insert(key, reason);
            }
            Incoming::OtherScenario(participant, difference) => {
                roll.others.insert(participant, difference);
            }
            Incoming::Came(..) | Incoming::Left(..) => {}
        }
    }
    roll.present.clone_from(link.present());
    roll.doubled = link.doubled();
    roll
}

fn mates(roll: &Roll, endpoints: &Endpoints, member: &Member<'_>, listen: Duration) -> Finding {
    let me = Participant::Robot(member.robot);
    let names: Vec<String> =
        roll.present.iter().filter(|participant| **participant != me).map(ToString::to_string).collect();
    if !names.is_empty() {
        return Finding::pass(
            "team",
            format!("{} of the mission are there: {}", names.len(), names.join(", ")),
        );
    }
    if member.scenario.robots().len() == 1 {
        return Finding::pass("team", "it searches alone, and no coordinator is there");
    }
    let (called, received) = (endpoints.connect.join(", "), endpoints.listen.join(", "));
    let seconds = listen.as_secs_f64();
    let found = format!(
        "no participant is there within {seconds:.0} s; it connects to [{called}] and listens at [{received}]"
    );
    let advice = "start the others; see that addresses, ports, mission and certificates are theirs";
    Finding::fail("team", found, advice)
}

/// Two robots with one number drive to the same cells, and each takes the other's messages for its own.
fn number(roll: &Roll, member: &Member<'_>) -> Option<Finding> {
    let robot = member.robot;
    let advice = format!(
        "give each robot a number of its own; stop the other robot {robot}, whose settings were copied"
    );
    if roll.doubled.contains(&Participant::Robot(robot)) {
        let found = format!("2 robots have number {robot}");
        return Some(Finding::fail("number", found, advice));
    }
    let is_there = roll.present.contains(&Participant::Robot(robot));
    if !is_there {
        return None;
    }
    Some(if member.runs_here {
        Finding::pass("number", format!("robot {robot} is there, as this computer runs it"))
    } else {
        let found =
            format!("a robot {robot} is there already, and does not run on this computer by these settings");
        Finding::fail("number", found, advice)
    })
}
