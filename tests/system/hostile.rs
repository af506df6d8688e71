//! Whatever bytes come, nobody falls over, and nothing counts that cannot be.

use std::sync::Arc;

use dragnet_agent::agent::{Agent, Event, Orders};
use dragnet_coordinator::mission::{self, Mission, MissionOrders};
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::directive::Directive;
use dragnet_proto::inbox::Inbox;
use dragnet_proto::message::{
    Activity, Heartbeat, Intent, LogReply, LogRequest, Message, MessageKind, Participant,
};
use dragnet_proto::plausible::Limits;
use dragnet_proto::scenario::Scenario;
use dragnet_proto::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::{Observation, Origin, RobotId, Version};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::scenario;

const MATE: Origin = Origin::first(RobotId(2));
const NOW: MissionTime = MissionTime(3_600_000_000_000);

fn small() -> Scenario {
    scenario(
        "name = 'hostile'\nmap = { shape = 'all_traversable', rows = 6, columns = 6 }\nsensor.radius = 1\n\
         objects.count = 1\nrobots.count = 3\nmission.budget_seconds = 7200.0\n",
    )
}

/// What an honest robot says that goes to and fro in the first row: a look a minute.
fn look(scenario: &Scenario, sequence: u64) -> Arc<Observation> {
    let column = u32::try_from(sequence % 10).unwrap();
    let from =
        scenario.terrain().grid().cell_numbered(if column < 6 { column } else { 10 - column }).unwrap();
    let readings = vec![Reading { cell: from, value: 0.1, variance: scenario.sensor().variance(0) }];
    Arc::new(Observation { origin: MATE, sequence, time_ns: sequence * 60_000_000_000, from, readings })
}

fn cell(scenario: &Scenario) -> Cell {
    scenario.terrain().grid().cells().next().unwrap()
}

/// A message that an honest robot says.
fn honest(scenario: &Scenario, kind: u8, sequence: u64) -> Message {
    let intent = Intent { origin: MATE, decision: sequence, time_ns: 0, path: vec![cell(scenario)] };
    match kind % 5 {
        0 => Message::Observation(look(scenario, sequence)),
        1 => Message::LogReply(LogReply {
            observations: (0..=sequence).map(|at| look(scenario, at)).collect(),
        }),
        2 => Message::Heartbeat(Heartbeat {
            robot: MATE.robot,
            time_ns: NOW.0,
            activity: Activity::Searching,
            cell: cell(scenario),
            path_meters: 1.0,
            intent,
            versions: vec![Version { origin: MATE, next: sequence }],
            digest: Digest(1),
            directive: Directive::default(),
        }),
        3 => Message::LogRequest(LogRequest {
            from: Participant::Robot(MATE.robot),
            of: MATE,
            first: sequence,
        }),
        _ => Message::Intent(intent),
    }
}

/// An honest message, some bytes of which were changed on the way, or none.
type Mutated = (u8, u64, Vec<(usize, u8)>, u8);

fn mutated() -> impl Strategy<Value = Mutated> {
    (any::<u8>(), 0..12_u64, vec((0..400_usize, any::<u8>()), 0..4), 0..5_u8)
}

fn arrive(scenario: &Scenario, codec: Codec, (kind, sequence, changes, _): &Mutated) -> Option<Message> {
    let message = honest(scenario, *kind, *sequence);
    let mut bytes = convert::encode(&message);
    for &(place, byte) in changes {
        let length = bytes.len();
        bytes[place % length] = byte;
    }
    codec.decode(message.kind(), &bytes).ok()
}

/// The evidence is that of what is known, and all of that can be.
fn check(inbox: &Inbox, belief: &Belief, scenario: &Scenario, limits: &Limits) {
    let mut expected = scenario.prior().clone();
    for version in inbox.log().versions() {
        let known = inbox.log().of(version.origin);
        for (place, observation) in known.iter().enumerate() {
            assert_eq!(limits.check(observation, &known[..place]), Ok(()));
            observation.readings.iter().for_each(|reading| expected.add(reading));
        }
    }
    assert_eq!(belief.digest(), expected.digest());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn mutated_messages_never_bring_evidence_that_cannot_be(messages in vec(mutated(), 1..30)) {
        let scenario = small();
        let (codec, limits) = (Codec::new(scenario.terrain().grid()), Limits::of(&scenario));
        let mut agent = Agent::new(Orders::of_team(&scenario, 1).remove(0));
        let mut mission = Mission::new(MissionOrders::of(&scenario));
        for mutated in &messages {
            let Some(message) = arrive(&scenario, codec, mutated) else { continue };
            let from = Participant::Robot(RobotId(mutated.3.into()));
            agent.handle(NOW, Event::Received { from, message: message.clone() });
            mission.handle(NOW, mission::Event::Received { from, message });
            check(agent.inbox(), agent.belief(), &scenario, &limits);
            check(mission.inbox(), mission.belief(), &scenario, &limits);
        }
    }

    #[test]
    fn arbitrary_bytes_are_refused_or_understood(
        bytes in vec(any::<u8>(), 0..300), kind in 0..MessageKind::ALL.len(), header in any::<bool>(),
    ) {
        let scenario = small();
        let bytes = if header { [&[0, 1, 0, 0, 2][..], &bytes].concat() } else { bytes };
        let codec = Codec::new(scenario.terrain().grid());
        if let Ok(message) = codec.decode(MessageKind::ALL[kind], &bytes) {
            let mut agent = Agent::new(Orders::of_team(&scenario, 1).remove(0));
            let from = Participant::Robot(MATE.robot);
            agent.handle(NOW, Event::Received { from, message });
            check(agent.inbox(), agent.belief(), &scenario, &Limits::of(&scenario));
        }
    }
}

#[test]
fn the_honest_of_these_messages_count() {
    let scenario = small();
    let mut mission = Mission::new(MissionOrders::of(&scenario));
    let from = Participant::Robot(MATE.robot);
    for sequence in [3, 11] {
        let message = honest(&scenario, 1, sequence);
        mission.handle(NOW, mission::Event::Received { from, message });
    }
    assert_eq!(mission.inbox().log().len(), 12);
    assert_ne!(mission.belief().digest(), scenario.prior().digest());
    assert!(mission.inbox().refused().is_empty());
}
