//! The team's network: who is there, and do their clocks agree?

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_proto::convert::Codec;
use dragnet_proto::key::Mission;
use dragnet_proto::message::{Message, Participant};
use dragnet_proto::scenario::Scenario;
use dragnet_search::observation::RobotId;
use tokio::time::Instant;

use super::Finding;
use crate::link::{Heard, Link};
use crate::session::{Endpoints, open};

/// What was heard in a while.
#[derive(Default)]
struct Roll {
    present: BTreeSet<Participant>,
    /// Seconds by which each robot's mission time was ahead of the first that was heard of.
    ahead: BTreeMap<RobotId, f64>,
    refused: BTreeMap<String, String>,
}

pub(super) async fn examine(
    endpoints: &Endpoints,
    mission: Mission,
    robot: RobotId,
    scenario: &Scenario,
    listen: Duration,
    tell: &mut dyn FnMut(Finding),
) {
    let team = scenario.robots().len();
    let session = match open(endpoints).await {
        Ok(session) => session,
        Err(error) => {
            let advice =
                "name an address of this computer, and a port that nobody uses (the robot itself may)";
            return tell(Finding::fail("network", error.to_string(), advice));
        }
    };
    let codec = Codec::new(scenario.terrain().grid());
    let roll = match Link::join(session, mission, Participant::Robot(robot), codec).await {
        Ok(mut link) => call(&mut link, listen).await,
        Err(error) => return tell(Finding::fail("network", error.to_string(), "")),
    };
    let names: Vec<String> = roll.present.iter().map(ToString::to_string).collect();
    let seconds = listen.as_secs_f64();
    if team == 1 && names.is_empty() {
        tell(Finding::pass("team", "it searches alone, and no coordinator is there"));
    } else if names.is_empty() {
        let (called, heard) = (endpoints.connect.join(", "), endpoints.listen.join(", "));
        let found =
            format!("nobody is there within {seconds:.0} s; it calls [{called}] and listens at [{heard}]");
        let advice = "start the others; see that addresses, ports, mission and certificates are theirs";
        tell(Finding::fail("team", found, advice));
    } else {
        tell(Finding::pass(
            "team",
            format!("{} of the mission are there: {}", names.len(), names.join(", ")),
        ));
    }
    for (key, reason) in &roll.refused {
        let advice = "another version, map or mission speaks there: give all the same scenario and program";
        tell(Finding::fail("team", format!("what came under {key} was refused: {reason}"), advice));
    }
    clocks(&roll, scenario, tell);
}

async fn call(link: &mut Link, listen: Duration) -> Roll {
    let (mut roll, started) = (Roll::default(), Instant::now());
    let mut first = None;
    while let Ok(Some(heard)) = tokio::time::timeout_at(started + listen, link.hear()).await {
        match heard {
            Heard::Message { message: Message::Heartbeat(heartbeat), .. } => {
                let ahead = heartbeat.time_ns as f64 / 1e9 - started.elapsed().as_secs_f64();
                let first = *first.get_or_insert(ahead);
                roll.ahead.insert(heartbeat.robot, ahead - first);
            }
            Heard::Refused { key, reason } => {
                roll.refused.insert(key, reason);
            }
            Heard::Message { .. } | Heard::Came(_) | Heard::Left(_) => {}
        }
    }
    roll.present.clone_from(link.present());
    roll
}

/// Robots count their mission's time by themselves; what one dates in another's future is not taken yet.
fn clocks(roll: &Roll, scenario: &Scenario, tell: &mut dyn FnMut(Finding)) {
    if roll.ahead.len() < 2 {
        return;
    }
    let ends = roll.ahead.values().fold((0.0_f64, 0.0_f64), |(low, high), &it| (low.min(it), high.max(it)));
    let apart = ends.1 - ends.0;
    let tolerance = scenario.mission().clock_tolerance.as_secs_f64();
    let found =
        format!("those of {} robots are {apart:.1} s apart; {tolerance:.0} s will do", roll.ahead.len());
    if apart <= tolerance {
        tell(Finding::pass("clocks", found));
    } else {
        let advice = "start robots together, keep their clocks together (chrony), or raise mission.clock_tolerance_seconds";
        tell(Finding::fail("clocks", found, advice));
    }
}
