//! Any message survives encoding and decoding, and no bytes do harm.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::dragnet_msgs::{OBSERVATION_VERSION, VERSION};
use dragnet_proto::marks::{Marked, Marks};
use dragnet_proto::message::{
    Activity, Audience, Detection, Heartbeat, Intent, MarkReport, Message, MessageKind, MissionStatus,
    OrderReport, SyncReply, SyncRequest, VerdictReport, ZoneReport,
};
use dragnet_proto::newest::Numbered;
use dragnet_proto::orders::{NumberedOrder, RobotOrder, RobotOrders};
use dragnet_proto::radio::{Load, Priority};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_proto::step::{MessageRef, Sensed, Step, StepEvent, StepReply};
use dragnet_proto::verdict::{Decision, Verdict, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::mark::{Clue, Mark, Searched};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, Origin, RobotId, Source, Version, Versions};
use dragnet_search::sensor::Sensor;
use proptest::collection::{btree_set, vec};
use proptest::prelude::*;

const ROWS: u32 = 7;
const COLUMNS: u32 = 9;

fn grid() -> Grid {
    Grid::new(ROWS, COLUMNS).unwrap()
}

fn cells() -> impl Strategy<Value = Cell> {
    (0..ROWS * COLUMNS).prop_map(|number| grid().cell_numbered(number).unwrap())
}

fn robots() -> impl Strategy<Value = RobotId> {
    (1..=u16::MAX).prop_map(|number| RobotId::new(number).unwrap())
}

fn origins() -> impl Strategy<Value = Origin> {
    let source = prop_oneof![Just(Source::Operator), robots().prop_map(Source::Robot)];
    (source, any::<u64>()).prop_map(|(source, incarnation)| Origin { source, incarnation })
}

fn digests() -> impl Strategy<Value = Digest> {
    any::<u128>().prop_map(Digest)
}

fn participants() -> impl Strategy<Value = Participant> {
    prop_oneof![robots().prop_map(Participant::Robot), Just(Participant::Coordinator)]
}

fn audiences() -> impl Strategy<Value = Audience> {
    prop_oneof![Just(Audience::All), participants().prop_map(Audience::One)]
}

fn activities() -> impl Strategy<Value = Activity> {
    prop_oneof![
        Just(Activity::Searching),
        Just(Activity::Cleared),
        Just(Activity::Spent),
        Just(Activity::Stuck),
        Just(Activity::Paused),
        Just(Activity::Waiting),
        Just(Activity::Returning),
        Just(Activity::Recalled),
        Just(Activity::Sent),
        Just(Activity::Holding),
        Just(Activity::Leaving),
        Just(Activity::GivingWay),
    ]
}

fn readings() -> impl Strategy<Value = Vec<Reading>> {
    let reading = (cells(), -1e3_f32..=1e3, 1e-6_f32..=1e4);
    vec(reading.prop_map(|(cell, value, variance)| Reading { cell, value, variance }), 0..20)
}

fn positions() -> impl Strategy<Value = Box<[ObjectPosition]>> {
    let meters = prop::array::uniform2(any::<f64>().prop_filter("finite", |it| it.is_finite()));
    let covariance = (0_f32..=1e6, 0_f32..=1e6, -1_f32..=1.0)
        .prop_map(|(east, north, share)| [east, share * (east * north).sqrt(), north]);
    let position = (cells(), meters, covariance)
        .prop_filter_map("no covariance", |(cell, meters, covariance)| {
            ObjectPosition::new(cell, meters, covariance)
        });
    vec(position, 0..4).prop_map(|mut positions| {
        positions.sort_by_key(ObjectPosition::cell);
        positions.dedup_by_key(|position| position.cell());
        positions.into()
    })
}

fn observations() -> impl Strategy<Value = Observation> {
    (origins(), any::<u64>(), any::<u64>(), cells(), readings(), positions()).prop_map(
        |(origin, sequence, time_ns, from, readings, positions)| Observation {
            origin,
            sequence,
            time_ns,
            from,
            readings,
            positions,
        },
    )
}

fn intents() -> impl Strategy<Value = Intent> {
    (robots(), any::<[u64; 3]>(), vec(cells(), 0..30)).prop_map(
        |(robot, [incarnation, decision, time_ns], path)| Intent {
            robot,
            incarnation,
            decision,
            time_ns,
            path: path.into(),
        },
    )
}

fn versions() -> impl Strategy<Value = Versions> {
    let known = proptest::collection::btree_map(origins(), any::<u64>(), 0..5);
    known.prop_map(|known| known.into_iter().map(|(origin, next)| Version { origin, next }).collect())
}

fn directives() -> impl Strategy<Value = Directive> {
    let added = proptest::collection::btree_set(cells(), 0..20);
    (any::<u64>(), 0..4_usize, added).prop_map(|(number, order, added)| Directive {
        number,
        order: [TeamOrder::Search, TeamOrder::Return, TeamOrder::End, TeamOrder::Pause][order],
        added,
    })
}

fn heartbeats() -> impl Strategy<Value = Heartbeat> {
    let place = (any::<u64>(), activities(), cells(), 0.0..1e9);
    (intents(), place, versions(), digests(), directives()).prop_map(
        |(intent, (time_ns, activity, cell, path_meters), versions, digest, directive)| Heartbeat {
            robot: intent.robot,
            time_ns,
            activity,
            cell,
            path_meters,
            intent,
            versions,
            digest,
            directive,
        },
    )
}

fn sync_replies() -> impl Strategy<Value = SyncReply> {
    (origins(), any::<u32>(), vec(observations(), 0..4)).prop_map(|(origin, first, observations)| {
        let numbered = (u64::from(first)..)
            .zip(observations)
            .map(|(sequence, observation)| Arc::new(Observation { origin, sequence, ..observation }));
        SyncReply { observations: numbered.collect() }
    })
}

fn mission_statuses() -> impl Strategy<Value = MissionStatus> {
    let detection = (cells(), 0.0..=1.0, any::<u64>());
    let declared = vec(
        detection.prop_map(|(cell, probability, time_ns)| Detection { cell, probability, time_ns }),
        0..9,
    );
    let known = (versions(), digests(), directives());
    let robots = || vec(robots(), 0..9);
    (any::<u64>(), declared, 0.0..1e6, (robots(), robots()), any::<u64>(), known).prop_map(
        |(
            time_ns,
            declared,
            expected_remaining,
            (alive, doubled),
            observations,
            (versions, digest, directive),
        )| {
            MissionStatus {
                time_ns,
                declared,
                expected_remaining,
                alive,
                observations,
                versions,
                digest,
                directive,
                doubled,
            }
        },
    )
}

fn verdicts() -> impl Strategy<Value = Verdicts> {
    let most = Verdict::CONFIRMED_UNITS;
    let decided = prop_oneof![
        Just((Decision::Undone, 0)),
        Just((Decision::Confirmed, most)),
        (-most..0).prop_map(|units| (Decision::Dismissed, units)),
    ];
    let verdict = (cells(), any::<u64>(), decided).prop_map(|(cell, number, (decision, log_odds_units))| {
        (cell, Verdict { number, decision, log_odds_units })
    });
    vec(verdict, 0..9).prop_map(|verdicts| verdicts.into_iter().collect())
}

fn orders() -> impl Strategy<Value = RobotOrders> {
    let order = prop_oneof![
        Just(RobotOrder::Search),
        cells().prop_map(RobotOrder::Go),
        Just(RobotOrder::Return),
        Just(RobotOrder::Pause),
    ];
    let given = (robots(), any::<u64>(), order)
        .prop_map(|(robot, number, order)| (robot, NumberedOrder { number, value: order }));
    vec(given, 0..9).prop_map(|orders| orders.into_iter().collect())
}

fn zones() -> impl Strategy<Value = Zones> {
    let zone = (cells(), 0..3_u64, 0..3_usize)
        .prop_map(|(cell, number, zone)| (cell, Numbered { number, value: Zone::ALL[zone] }));
    vec(zone, 0..30).prop_map(|zones| zones.into_iter().collect())
}

fn marks() -> impl Strategy<Value = Marks> {
    let clue = (cells(), Clue::RATIO_THOUSANDTHS, 0..=Clue::MAX_RADIUS_HUNDREDTHS).prop_map(
        |(cell, ratio_thousandths, radius_hundredths)| {
            Mark::Clue(Clue { cell, ratio_thousandths, radius_hundredths })
        },
    );
    let searched = (btree_set(cells(), 1..30), Searched::POD_THOUSANDTHS)
        .prop_map(|(cells, pod_thousandths)| Mark::Searched(Searched { cells, pod_thousandths }));
    let marked = (prop_oneof![clue, searched], any::<bool>(), "\\PC{0,60}")
        .prop_map(|(mark, is_withdrawn, note)| Arc::new(Marked { is_withdrawn, mark, note }));
    let entry =
        (any::<u64>(), any::<u64>(), marked).prop_map(|(id, number, value)| (id, Numbered { number, value }));
    vec(entry, 0..9).prop_map(|marks| marks.into_iter().collect())
}

fn messages() -> impl Strategy<Value = Message> {
    prop_oneof![
        observations().prop_map(|observation| Message::Observation(Arc::new(observation))),
        intents().prop_map(Message::Intent),
        heartbeats().prop_map(Message::Heartbeat),
        (participants(), origins(), any::<u64>())
            .prop_map(|(from, of, first)| Message::SyncRequest(SyncRequest { from, of, first })),
        sync_replies().prop_map(Message::SyncReply),
        mission_statuses().prop_map(Message::MissionStatus),
        (participants(), any::<u64>(), verdicts()).prop_map(|(from, time_ns, verdicts)| Message::Verdicts(
            VerdictReport { from, time_ns, verdicts }
        )),
        (participants(), any::<u64>(), orders())
            .prop_map(|(from, time_ns, orders)| Message::Orders(OrderReport { from, time_ns, orders })),
        (participants(), any::<u64>(), zones())
            .prop_map(|(from, time_ns, zones)| Message::Zones(ZoneReport { from, time_ns, zones })),
        (participants(), any::<u64>(), marks())
            .prop_map(|(from, time_ns, marks)| Message::Marks(MarkReport { from, time_ns, marks })),
    ]
}

fn steps() -> impl Strategy<Value = Step> {
    let event = prop_oneof![
        Just(StepEvent::Event(Event::Start)),
        (cells(), readings()).prop_map(|(cell, readings)| StepEvent::Event(Event::Sensed { cell, readings })),
        (participants(), any::<u64>())
            .prop_map(|(from, message)| StepEvent::Event(Event::Received { from, message })),
        Just(StepEvent::Event(Event::Woke)),
        robots().prop_map(|robot| StepEvent::Event(Event::Lost(robot))),
        Just(StepEvent::Report),
        Just(StepEvent::Finish),
    ];
    (any::<u64>(), event).prop_map(|(time_ns, event)| Step { time_ns, event })
}

fn step_replies() -> impl Strategy<Value = StepReply> {
    let kind = (0..MessageKind::ALL.len()).prop_map(|index| MessageKind::ALL[index]);
    let priority = (0..Priority::ALL.len()).prop_map(|index| Priority::ALL[index]);
    let load = (kind, priority, any::<u16>(), any::<u32>()).prop_map(|(kind, priority, about, bytes)| Load {
        kind,
        priority,
        about,
        bytes,
    });
    let message =
        (audiences(), any::<u64>(), load).prop_map(|(to, number, load)| (to, MessageRef { number, load }));
    let next = (proptest::option::of(vec(cells(), 0..30)), 1..=u64::MAX, activities());
    let decision = proptest::option::of((1_u64..1 << 40).prop_map(Duration::from_nanos));
    (vec(message, 0..5), next, any::<u64>(), decision, digests(), ".*").prop_map(
        |(published, (route, wake_at_ns, activity), observations, decision, digest, error)| {
            let wake_at = MissionTime(wake_at_ns);
            let effects = Effects { published, route, wake_at, activity, decision, ..Effects::default() };
            StepReply { effects, digest, observations, error }
        },
    )
}

fn sensed() -> impl Strategy<Value = Sensed> {
    (robots(), any::<u64>(), cells(), readings()).prop_map(|(robot, time_ns, from, readings)| Sensed {
        robot,
        time_ns,
        from,
        readings,
    })
}

/// The codec of a team with radios.
fn packing() -> Codec {
    let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 7, columns = 9 }\nobjects.count = 1\nrobots.count = 3\n\
                mission.budget_seconds = 60.0\nnetwork.bytes_per_second = 125.0\n";
    Codec::of(&Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap())
}

/// Valid bytes of any of Dragnet's messages.
fn valid_bytes() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        6 => messages().prop_map(|message| convert::encode(&message)),
        1 => steps().prop_map(|step| convert::encode_step(&step).unwrap()),
        1 => step_replies().prop_map(|reply| convert::encode_step_reply(&reply)),
        1 => sensed().prop_map(|sensed| convert::encode_sensed(&sensed)),
    ]
}

fn versions_of_messages() -> impl Strategy<Value = u8> {
    prop_oneof![Just(VERSION), Just(OBSERVATION_VERSION)]
}

/// Decodes the bytes as every kind; each decoded message can be encoded.
fn decode_as_everything(bytes: &[u8]) {
    let codec = Codec::new(grid());
    for kind in MessageKind::ALL {
        if let Ok(message) = codec.decode(kind, bytes) {
            assert_eq!(codec.decode(kind, &convert::encode(&message)).unwrap(), message);
        }
    }
    if let Ok(step) = codec.decode_step(bytes) {
        assert_eq!(codec.decode_step(&convert::encode_step(&step).unwrap()).unwrap(), step);
    }
    if let Ok(reply) = codec.decode_step_reply(bytes) {
        let again = codec.decode_step_reply(&convert::encode_step_reply(&reply)).unwrap();
        assert_eq!(again, reply);
    }
    if let Ok(sensed) = codec.decode_sensed(bytes) {
        assert_eq!(codec.decode_sensed(&convert::encode_sensed(&sensed)).unwrap(), sensed);
    }
}

proptest! {
    #[test]
    fn a_message_arrives_as_it_was_sent(message in messages()) {
        let bytes = convert::encode(&message);
        prop_assert_eq!(Codec::new(grid()).decode(message.kind(), &bytes).unwrap(), message);
    }

    #[test]
    fn a_packed_message_arrives_as_it_was_sent(message in messages()) {
        let bytes = packing().encode(&message);
        prop_assert_ne!(bytes[0], 0);
        prop_assert_eq!(Codec::new(grid()).decode(message.kind(), &bytes).unwrap(), message);
    }

    #[test]
    fn packed_bytes_are_rejected_or_a_message(body in vec(any::<u8>(), 0..200)) {
        let mut bytes = packing().encode(&Message::SyncReply(SyncReply { observations: Vec::new() }));
        bytes.pop();
        bytes.extend(body);
        decode_as_everything(&bytes);
    }

    #[test]
    fn a_truncated_packed_message_is_rejected(message in messages(), cut in any::<prop::sample::Index>()) {
        let mut bytes = packing().encode(&message);
        bytes.truncate(cut.index(bytes.len()));
        prop_assert!(Codec::new(grid()).decode(message.kind(), &bytes).is_err());
    }

    /// Rounded readings of the sensor, all around a cell: a byte for each, and no cell or variance.
    #[test]
    fn readings_of_the_sensor_are_packed_in_a_byte_each(from in cells(), values in vec(-1.0_f32..=2.0, ROWS as usize * COLUMNS as usize)) {
        let sensor = Sensor::default();
        let seen = sensor.footprint().iter().filter_map(|it| Some((it, grid().step(from, it.offset)?)));
        let readings: Vec<Reading> = seen
            .zip(values)
            .map(|((it, cell), value)| Reading { cell, value, variance: it.variance }.rounded())
            .collect();
        let count = readings.len();
        let origin = Origin::first(RobotId::FIRST);
        let message = Message::Observation(Arc::new(Observation { origin, sequence: 3, time_ns: 1 << 40, from, readings, positions: Box::default() }));
        let bytes = packing().encode(&message);
        // Values near the robot may take two bytes.
        prop_assert!(bytes.len() <= 24 + count + 9, "{} bytes, {count} readings", bytes.len());
        prop_assert_eq!(Codec::new(grid()).decode(MessageKind::Observation, &bytes).unwrap(), message);
    }

    #[test]
    fn a_step_arrives_as_it_was_sent(step in steps()) {
        let bytes = convert::encode_step(&step).unwrap();
        prop_assert_eq!(Codec::new(grid()).decode_step(&bytes).unwrap(), step);
    }

    #[test]
    fn a_step_reply_arrives_as_it_was_sent(reply in step_replies()) {
        let bytes = convert::encode_step_reply(&reply);
        prop_assert_eq!(Codec::new(grid()).decode_step_reply(&bytes).unwrap(), reply);
    }

    #[test]
    fn sensed_readings_arrive_as_they_were_sent(sensed in sensed()) {
        let bytes = convert::encode_sensed(&sensed);
        prop_assert_eq!(Codec::new(grid()).decode_sensed(&bytes).unwrap(), sensed);
    }

    #[test]
    fn any_bytes_are_rejected_or_a_message(version in versions_of_messages(), body in vec(any::<u8>(), 0..200)) {
        decode_as_everything(&body);
        let mut bytes = vec![0, 1, 0, 0, version];
        bytes.extend(body);
        decode_as_everything(&bytes);
    }

    #[test]
    fn small_numbers_are_rejected_or_a_message(version in versions_of_messages(), body in vec(0_u8..3, 0..200)) {
        let mut bytes = vec![0, 1, 0, 0, version];
        bytes.extend(body);
        decode_as_everything(&bytes);
    }

    #[test]
    fn a_truncated_message_is_rejected(message in messages(), cut in any::<prop::sample::Index>()) {
        let mut bytes = convert::encode(&message);
        bytes.truncate(cut.index(bytes.len()));
        prop_assert!(Codec::new(grid()).decode(message.kind(), &bytes).is_err());
        decode_as_everything(&bytes);
    }

    #[test]
    fn a_flipped_bit_does_no_harm(
        mut bytes in valid_bytes(), at in any::<prop::sample::Index>(), bit in 0_u32..8,
    ) {
        let at = at.index(bytes.len());
        bytes[at] ^= 1_u8 << bit;
        decode_as_everything(&bytes);
    }
}
