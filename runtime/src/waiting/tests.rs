use dragnet_search::observation::RobotId;

use super::*;

const fn robot(number: u16) -> Participant {
    Participant::Robot(RobotId::new(number).unwrap())
}

const FAULTY: Sender = Sender::Known(robot(1));
const HONEST: Sender = Sender::Known(robot(2));

fn raw(number: u64, bytes: usize) -> Raw {
    Raw { key: String::new(), payload: vec![0; bytes], envelope: Some(Envelope { number, identity: 0 }) }
}

const fn claim(identity: u64) -> Claim {
    Claim { seniority: 0, identity }
}

/// Takes all pending messages: their numbers by sender, in order.
fn taken(queues: &mut Queues) -> Vec<(Sender, u64)> {
    let arrivals = std::iter::from_fn(|| queues.take());
    arrivals
        .filter_map(|arrival| match arrival {
            Arrival::Message { from, raw } => Some((from, raw.envelope?.number)),
            Arrival::Presence { .. } => None,
        })
        .collect()
}

#[test]
fn a_flooding_sender_loses_its_own_oldest_messages_and_memory_is_bounded() {
    let max_bytes = 100_000;
    let mut queues = Queues { max_bytes, ..Queues::default() };
    for number in 0..50 {
        queues.put_message(HONEST, raw(number, 100));
        for flood in 0..100 {
            queues.put_message(FAULTY, raw(number * 100 + flood, 5000));
            assert!(queues.bytes <= max_bytes);
        }
        queues.put_message(Sender::Stranger, raw(number, 100));
    }
    assert_eq!(queues.dropped.keys().copied().collect::<Vec<_>>(), [FAULTY]);
    let taken = taken(&mut queues);
    let of =
        |participant| taken.iter().filter(move |(from, _)| *from == participant).map(|&(_, number)| number);
    assert!(of(HONEST).eq(0..50) && of(Sender::Stranger).eq(0..50));
    let kept: Vec<u64> = of(FAULTY).collect();
    assert!(!kept.is_empty() && kept[..] == (5000 - kept.len() as u64..5000).collect::<Vec<_>>());
    assert_eq!(queues.dropped[&FAULTY], 5000 - kept.len() as u64);
    assert_eq!(queues.bytes, 0);
}

#[test]
fn turns_are_fair_by_bytes() {
    let mut queues = Queues { max_bytes: 1 << 20, ..Queues::default() };
    (0..10).for_each(|number| queues.put_message(FAULTY, raw(number, 10_000)));
    (0..10).for_each(|number| queues.put_message(HONEST, raw(number, 100)));
    let order = taken(&mut queues);
    let last = order.iter().rposition(|&(from, _)| from == HONEST).unwrap();
    assert_eq!(last, 10, "one long message at most goes before all short ones: {order:?}");
}

#[test]
fn a_silent_sender_saves_up_no_turns() {
    let mut queues = Queues { max_bytes: 1 << 20, ..Queues::default() };
    queues.put_message(FAULTY, raw(0, 0));
    (0..100).for_each(|number| queues.put_message(HONEST, raw(number, 1000)));
    assert_eq!(taken(&mut queues).len(), 101);
    for number in 0..100 {
        queues.put_message(FAULTY, raw(number, 1000));
        queues.put_message(HONEST, raw(number, 1000));
    }
    let order = taken(&mut queues);
    let among_first = order[..20].iter().filter(|(from, _)| *from == HONEST).count();
    assert!(among_first >= 9, "{order:?}");
}

#[test]
fn presence_is_known_however_often_a_process_comes_and_goes() {
    let mut queues = Queues { max_bytes: 10_000, ..Queues::default() };
    queues.put_message(FAULTY, raw(0, 0));
    for turn in 0..10_001 {
        queues.put_presence(robot(1), claim(7), turn % 2 == 0);
    }
    // A flood does not drop presence changes.
    (1..100).for_each(|number| queues.put_message(FAULTY, raw(number, 1000)));
    let presence: Vec<bool> = std::iter::from_fn(|| queues.take())
        .filter_map(|arrival| match arrival {
            Arrival::Presence { participant, is_here, .. } if participant == robot(1) => Some(is_here),
            _ => None,
        })
        .collect();
    assert_eq!(presence, [false, true]);
}

#[test]
fn messages_of_one_sender_keep_their_order() {
    let mut queues = Queues { max_bytes: 10_000, ..Queues::default() };
    queues.put_message(FAULTY, raw(0, 10));
    queues.put_presence(robot(1), claim(7), false);
    queues.put_message(FAULTY, raw(1, 10));
    let is_message = |arrival| matches!(arrival, Arrival::Message { .. });
    let kinds: Vec<bool> = std::iter::from_fn(|| queues.take()).map(is_message).collect();
    assert_eq!(kinds, [true, false, true]);
}

#[tokio::test]
async fn no_record_is_missed_and_the_end_is_announced() {
    let (inlet, mut outlet) = waiting(MOST_BYTES);
    let sending = tokio::spawn(async move {
        for number in 0..1000 {
            inlet.message(HONEST, raw(number, 1));
            if number % 7 == 0 {
                tokio::task::yield_now().await;
            }
        }
    });
    let mut count = 0;
    while outlet.take().await.is_some() {
        count += 1;
    }
    assert_eq!(count, 1000);
    sending.await.unwrap();
}

#[test]
fn departures_are_reported_however_many_come_and_go_meanwhile() {
    let mut queues = Queues { max_bytes: 1 << 20, ..Queues::default() };
    queues.put_presence(robot(1), claim(7), false);
    for identity in 100..100 + 10 * MOST_PRESENCE as u64 {
        queues.put_presence(robot(1), claim(identity), true);
        queues.put_presence(robot(1), claim(identity), false);
    }
    queues.put_presence(robot(1), claim(8), true);
    let reported: Vec<(u64, bool)> = std::iter::from_fn(|| queues.take())
        .map(|arrival| match arrival {
            Arrival::Presence { claim, is_here, .. } => (claim.identity, is_here),
            Arrival::Message { .. } => panic!("{arrival:?}"),
        })
        .collect();
    assert_eq!((reported.first(), reported.last()), (Some(&(7, false)), Some(&(8, true))));
    assert!(reported.len() <= MOST_PRESENCE);
}
