//! With any bytes, neither a robot nor the coordinator panics, and nothing impossible counts.

use std::sync::Arc;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::directive::Directive;
use dragnet_proto::dragnet_msgs as wire;
use dragnet_proto::message::{Activity, Heartbeat, Intent, Message, MessageKind, SyncReply, SyncRequest};
use dragnet_proto::state_machine::Event;
use dragnet_proto::validation::Limits;
use dragnet_ros2::cdr::{self, MAX_BYTES};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::{Observation, Origin, RobotId, Version};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::alone::{alone, begin};
use crate::spoil_bytes::BEGINNING;
use crate::world::{Tally, World};
use crate::{check, scenario};

/// Number of worlds and of spoiled messages in each: a million together.
const WORLDS: u64 = 10;
const MESSAGES_A_WORLD: u64 = 125_000;
/// Number of messages after which all evidence is summed again.
const CHECK_EVERY: u64 = 5000;
/// Memory limit of robot, coordinator and page, bytes: four times the program and its final state.
const WORLD_BYTES: u64 = 64 << 20;
/// Memory limit for rejecting a message of maximum length, bytes. Its smallest parts are twice as long in memory, and a
/// growing list takes one and a half times: with the message itself, four to five times its length.
const LONGEST_BYTES: u64 = 8 * MAX_BYTES as u64;

const MATE: RobotId = RobotId::new(2).unwrap();
const NOW: MissionTime = MissionTime(3_600_000_000_000);

fn small() -> Scenario {
    scenario(
        "name = 'hostile'\nmap = { shape = 'all_traversable', rows = 6, columns = 6 }\nsensor.radius = 1\n\
         objects.count = 1\nrobots.count = 3\nmission.budget_seconds = 7200.0\n",
    )
}

/// An observation of an honest robot that drives to and fro in the first row: one per minute.
fn observed(scenario: &Scenario, sequence: u64) -> Arc<Observation> {
    let column = u32::try_from(sequence % 10).unwrap();
    let from =
        scenario.terrain().grid().cell_numbered(if column < 6 { column } else { 10 - column }).unwrap();
    let readings = vec![Reading { cell: from, value: 0.1, variance: scenario.sensor().variance(0) }];
    Arc::new(Observation {
        origin: Origin::first(MATE),
        sequence,
        time_ns: sequence * 60_000_000_000,
        from,
        readings,
        positions: Box::default(),
    })
}

fn cell(scenario: &Scenario) -> Cell {
    scenario.terrain().grid().cells().next().unwrap()
}

/// A message of an honest robot.
fn honest(scenario: &Scenario, kind: u8, sequence: u64) -> Message {
    let intent = Intent {
        robot: MATE,
        incarnation: 0,
        decision: sequence,
        time_ns: 0,
        path: vec![cell(scenario)].into(),
    };
    match kind % 5 {
        0 => Message::Observation(observed(scenario, sequence)),
        1 => Message::SyncReply(SyncReply {
            observations: (0..=sequence).map(|at| observed(scenario, at)).collect(),
        }),
        2 => Message::Heartbeat(Heartbeat {
            robot: MATE,
            time_ns: NOW.0,
            activity: Activity::Searching,
            cell: cell(scenario),
            path_meters: 1.0,
            intent,
            versions: vec![Version { origin: Origin::first(MATE), next: sequence }].into(),
            digest: Digest(1),
            directive: Directive::default(),
        }),
        3 => Message::SyncRequest(SyncRequest {
            from: Participant::Robot(MATE),
            of: Origin::first(MATE),
            first: sequence,
        }),
        _ => Message::Intent(intent),
    }
}

/// An honest message, some bytes of which may be changed.
type Mutated = (u8, u64, Vec<(usize, u8)>, u8);

fn mutated() -> impl Strategy<Value = Mutated> {
    (any::<u8>(), 0..12_u64, vec((0..400_usize, any::<u8>()), 0..4), 1..5_u8)
}

fn arrive(scenario: &Scenario, codec: &Codec, (kind, sequence, changes, _): &Mutated) -> Option<Message> {
    let message = honest(scenario, *kind, *sequence);
    let mut bytes = convert::encode(&message);
    for &(place, byte) in changes {
        let length = bytes.len();
        bytes[place % length] = byte;
    }
    codec.decode(message.kind(), &bytes).ok()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn mutated_messages_never_bring_evidence_that_cannot_be(messages in vec(mutated(), 1..30)) {
        let scenario = small();
        let (codec, limits) = (Codec::new(scenario.terrain().grid()), Limits::of(&scenario));
        let mut agent = Agent::new(AgentConfig::of_team(&scenario, 1).remove(0));
        let mut mission = Mission::new(CoordinatorConfig::of(&scenario));
        for mutated in &messages {
            let Some(message) = arrive(&scenario, &codec, mutated) else { continue };
            let from = Participant::Robot(RobotId::new(mutated.3.into()).unwrap());
            agent.react(NOW, Event::Received { from, message: message.clone() });
            mission.react(NOW, Event::Received { from, message });
            check(agent.replica(), agent.belief(), &scenario, &limits);
            check(mission.replica(), mission.belief(), &scenario, &limits);
        }
    }

    #[test]
    fn arbitrary_bytes_are_rejected_or_decoded(
        bytes in vec(any::<u8>(), 0..300), kind in 0..MessageKind::ALL.len(), header in any::<bool>(),
    ) {
        let scenario = small();
        let bytes = if header { [&BEGINNING[..], &bytes].concat() } else { bytes };
        let codec = Codec::new(scenario.terrain().grid());
        if let Ok(message) = codec.decode(MessageKind::ALL[kind], &bytes) {
            let mut agent = Agent::new(AgentConfig::of_team(&scenario, 1).remove(0));
            let from = Participant::Robot(MATE);
            agent.react(NOW, Event::Received { from, message });
            check(agent.replica(), agent.belief(), &scenario, &Limits::of(&scenario));
        }
    }
}

#[test]
fn the_honest_of_these_messages_count() {
    let scenario = small();
    let mut mission = Mission::new(CoordinatorConfig::of(&scenario));
    let from = Participant::Robot(MATE);
    for sequence in [3, 11] {
        let message = honest(&scenario, 1, sequence);
        mission.react(NOW, Event::Received { from, message });
    }
    assert_eq!(mission.replica().log().len(), 12);
    assert_ne!(mission.belief().digest(), scenario.prior().digest());
    assert!(mission.replica().rejected().is_empty());
}

#[test]
fn of_a_million_spoiled_messages_none_brings_evidence_that_cannot_be() {
    let name = "messages::of_a_million_spoiled_messages_none_brings_evidence_that_cannot_be";
    alone(name, WORLD_BYTES, || {
        let (mut tally, mut decisions) = (Tally::default(), Vec::new());
        for seed in 0..WORLDS {
            let mut world = World::new(seed);
            for number in 0..MESSAGES_A_WORLD {
                begin(format_args!("message {number} of world {seed}"));
                world.step(&mut tally);
                if number % CHECK_EVERY == 0 {
                    world.check();
                }
            }
            world.check();
            decisions.push(world.decisions());
        }
        println!("{tally:#?}, {decisions:?} decisions");
        // When faulty robots plan to observe everything, it waits; and at the end of time it decides seldom.
        assert!(decisions.iter().all(|&of_world| of_world >= 10), "the robots go on: {decisions:?}");
        check_has_met_all(&tally);
    });
}

/// Messages of each kind were accepted, and rejections have several reasons.
fn check_has_met_all(tally: &Tally) {
    let decoded: u64 = tally.decoded.values().sum();
    assert_eq!(decoded + tally.undecoded, WORLDS * MESSAGES_A_WORLD);
    assert!(tally.undecoded >= 300_000);
    for kind in MessageKind::ALL {
        assert!(tally.decoded[&kind] >= 30_000, "{kind:?}");
    }
    assert!(tally.misattributed >= 20_000);
    assert!(tally.counted >= 50_000);
    assert_eq!(tally.rejected.len(), 13, "of all reasons");
    // With so vague a sensor few values are impossible, and most of those are made so.
    assert!(tally.rejected.values().all(|&count| count >= 10), "{:?}", tally.rejected);
}

/// A list at the end claims to be endless, and is as long as a message can be.
#[test]
fn a_message_of_the_greatest_length_takes_a_few_times_as_much_memory() {
    let name = "messages::a_message_of_the_greatest_length_takes_a_few_times_as_much_memory";
    let (version, observation) = (wire::VERSION, wire::OBSERVATION_VERSION);
    alone(name, LONGEST_BYTES, || {
        let codec = Codec::new(small().terrain().grid());
        for (kind, mut bytes) in [
            (
                MessageKind::Observation,
                cdr::encode(&wire::Observation { version: observation, ..Default::default() }),
            ),
            (MessageKind::Intent, cdr::encode(&wire::Intent { version, ..Default::default() })),
            (MessageKind::Heartbeat, cdr::encode(&wire::Heartbeat { version, ..Default::default() })),
            (
                MessageKind::SyncReply,
                cdr::encode(&wire::SyncReply { version: observation, ..Default::default() }),
            ),
            (MessageKind::MissionStatus, cdr::encode(&wire::MissionStatus { version, ..Default::default() })),
            (MessageKind::Verdicts, cdr::encode(&wire::Verdicts { version, ..Default::default() })),
            (MessageKind::Orders, cdr::encode(&wire::Orders { version, ..Default::default() })),
            (MessageKind::Zones, cdr::encode(&wire::Zones { version, ..Default::default() })),
            (MessageKind::Marks, cdr::encode(&wire::Marks { version, ..Default::default() })),
        ] {
            begin(format_args!("{kind:?}"));
            let length = bytes.len() - 4..;
            bytes[length].fill(0xff);
            bytes.resize(MAX_BYTES, 0);
            let error = codec.decode(kind, &bytes).unwrap_err().to_string();
            assert!(error.contains("unexpected end of input"), "{error}");
        }
    });
}
