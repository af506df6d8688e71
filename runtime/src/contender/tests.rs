use std::collections::{BTreeMap, BTreeSet, HashSet, VecDeque};

use super::*;

const fn claim(seniority: u8, identity: u64) -> Claim {
    Claim { seniority, identity }
}

const fn seconds(seconds: u64) -> Duration {
    Duration::from_secs(seconds)
}

/// A process with this identity that has gone on alone until now.
fn alone(identity: u64, until: u64) -> Contender {
    let mut contender = Contender::new(claim(0, identity));
    contender.update(seconds(until), []);
    contender
}

#[test]
fn seniority_rises_with_the_time_that_a_process_goes_on_and_with_its_first_observation() {
    for (until, level) in
        [(0, 0), (3, 0), (4, 1), (15, 1), (16, 2), (63, 2), (64, 3), (86_400, 8), (1 << 60, 16)]
    {
        assert_eq!(alone(7, until).claim(), claim(level, 7), "{until} s");
    }
    let mut observed = alone(7, 1);
    observed.observe();
    observed.update(seconds(1), []);
    assert_eq!(observed.claim(), claim(1, 7));
    observed.update(seconds(5), []);
    assert_eq!(observed.claim(), claim(1, 7), "not twice");
}

#[test]
fn it_is_due_when_it_rises() {
    let mut contender = alone(7, 0);
    for level in 1..10 {
        let due = contender.due().unwrap();
        contender.update(due.saturating_sub(Duration::from_millis(1)), []);
        assert_eq!((contender.claim().seniority, contender.due()), (level - 1, Some(due)));
        contender.update(due, []);
        assert_eq!(contender.claim().seniority, level);
    }
    contender.update(seconds(1 << 30), [claim(Claim::TAKES_OVER, 1)]);
    assert_eq!(contender.due(), None);
    assert_eq!(Contender::new(claim(Claim::TAKES_OVER, 1)).due(), None);
}

#[test]
fn of_two_that_start_together_the_greater_identity_goes_on() {
    let mut both = [alone(3, 1), alone(7, 1)];
    let claims = both.each_ref().map(Contender::claim);
    both[0].update(seconds(2), [claims[1]]);
    both[1].update(seconds(2), [claims[0]]);
    assert_eq!(both.each_ref().map(Contender::stands), [true, false]);
}

#[test]
fn one_that_has_searched_is_not_stopped_by_one_that_starts() {
    let mut first = alone(3, 1);
    first.observe();
    first.update(seconds(1), []);
    let mut second = Contender::new(claim(0, 7));
    first.update(seconds(2), [second.claim()]);
    second.update(seconds(0), [first.claim()]);
    assert!(!first.stands() && second.stands());
}

#[test]
fn one_that_stands_does_not_rise_and_goes_on_when_it_is_alone() {
    let mut second = Contender::new(claim(0, 7));
    second.update(seconds(0), [claim(1, 3)]);
    second.update(seconds(1000), [claim(3, 3)]);
    assert!(second.stands());
    second.update(seconds(1001), []);
    assert!(!second.stands());
    // A token that was gone for a moment only: the first process goes on, as before.
    second.update(seconds(1003), [claim(3, 3)]);
    assert!(second.stands() && second.claim() == claim(0, 7));
}

#[test]
fn one_that_takes_over_stops_all_others() {
    let mut first = alone(7, 1 << 40);
    let mut second = Contender::new(claim(Claim::TAKES_OVER, 3));
    second.update(seconds(1), [first.claim()]);
    first.update(seconds(1 << 41), [second.claim()]);
    assert!(first.stands() && !second.stands());
}

/// Several processes of one number, and the tokens that are on their way from each to each other.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Network {
    processes: Vec<Option<Contender>>,
    seen: BTreeMap<(usize, usize), BTreeSet<Claim>>,
    /// Tokens that come (`true`) and go, in the order of each connection.
    under_way: BTreeMap<(usize, usize), VecDeque<(Claim, bool)>>,
    /// Number of processes that have not started.
    waiting: usize,
    now: u64,
}

/// The longest time that is simulated, seconds: two levels of seniority.
const UNTIL: u64 = 8;
/// The time that passes in one step, seconds.
const STEP: u64 = 4;

impl Network {
    fn new(count: usize) -> Self {
        let processes = vec![None; count];
        Self { processes, seen: BTreeMap::new(), under_way: BTreeMap::new(), waiting: count, now: 0 }
    }

    fn others(&self, me: usize) -> impl Iterator<Item = usize> + use<> {
        (0..self.processes.len()).filter(move |&other| other != me)
    }

    /// Sends a change of a token to all others.
    fn send(&mut self, from: usize, token: Claim, is_here: bool) {
        for other in self.others(from) {
            self.under_way.entry((from, other)).or_default().push_back((token, is_here));
        }
    }

    /// What a process does when anything has happened.
    fn update(&mut self, me: usize) {
        let rivals: Vec<Claim> = self
            .others(me)
            .flat_map(|other| self.seen.get(&(other, me)).cloned().unwrap_or_default())
            .collect();
        let now = seconds(self.now);
        let Some(process) = &mut self.processes[me] else { return };
        let before = process.claim();
        process.update(now, rivals);
        let after = process.claim();
        if after != before {
            self.send(me, after, true);
            self.send(me, before, false);
        }
    }

    /// All that can happen next.
    fn next(&self) -> Vec<Self> {
        let mut next = Vec::new();
        let mut happens = |change: &dyn Fn(&mut Self)| {
            let mut network = self.clone();
            change(&mut network);
            next.push(network);
        };
        for me in 0..self.processes.len() {
            match &self.processes[me] {
                None => happens(&|network| {
                    let token = claim(0, me as u64);
                    network.processes[me] = Some(Contender::new(token));
                    network.waiting -= 1;
                    network.send(me, token, true);
                    network.update(me);
                }),
                Some(process) if !process.stands() && !process.has_observed => happens(&|network| {
                    network.processes[me].as_mut().unwrap().observe();
                    network.update(me);
                }),
                Some(_) => {}
            }
        }
        for (&way, tokens) in self.under_way.iter().filter(|&(&(_, to), _)| self.processes[to].is_some()) {
            if !tokens.is_empty() {
                happens(&|network| network.deliver(way));
            }
        }
        if self.now < UNTIL {
            happens(&|network| {
                network.now += STEP;
                (0..network.processes.len()).for_each(|me| network.update(me));
            });
        }
        next
    }

    fn deliver(&mut self, way: (usize, usize)) {
        let Some((token, is_here)) = self.under_way.get_mut(&way).and_then(VecDeque::pop_front) else {
            return;
        };
        let seen = self.seen.entry(way).or_default();
        if is_here {
            seen.insert(token);
        } else {
            seen.remove(&token);
        }
        self.update(way.1);
    }

    /// Lets everything arrive, and returns the processes that go on.
    fn settled(mut self) -> Vec<usize> {
        while let Some(way) = self.under_way.iter().find(|(_, it)| !it.is_empty()).map(|(&way, _)| way) {
            self.deliver(way);
        }
        let goes = |&me: &usize| self.processes[me].as_ref().is_some_and(|process| !process.stands());
        (0..self.processes.len()).filter(goes).collect()
    }
}

/// Every order in which processes start, observe, and see each other's tokens, however late.
fn check_all_orders(count: usize) {
    let (mut known, mut open) = (HashSet::new(), vec![Network::new(count)]);
    let (mut winners, mut flips) = (BTreeSet::new(), 0);
    while let Some(network) = open.pop() {
        if !known.insert(network.clone()) {
            continue;
        }
        if network.waiting == 0 {
            let go = network.clone().settled();
            assert_eq!(go.len(), 1, "{:?}", network.processes);
            winners.extend(go);
            let running = network.processes.iter().flatten().filter(|process| !process.stands()).count();
            flips += usize::from(running != 1);
        }
        open.extend(network.next());
    }
    assert_eq!(winners, (0..count).collect(), "each can go on");
    assert!(flips > 0, "of {} states none had tokens on their way that matter", known.len());
}

#[test]
fn one_of_two_goes_on_in_every_order_of_starts_and_tokens() {
    check_all_orders(2);
}

/// The same for three, along random orders: all of them are too many.
#[test]
fn one_of_three_goes_on_in_many_orders_of_starts_and_tokens() {
    let mut winners = BTreeSet::new();
    for seed in 0..500_u64 {
        let (mut network, mut state) = (Network::new(3), seed);
        for _ in 0..40 {
            let next = network.next();
            if next.is_empty() {
                break;
            }
            // Knuth's linear congruential generator: this crate draws nothing else at random in tests.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let choice = (state >> 33) as usize % next.len();
            network = next.into_iter().nth(choice).unwrap();
        }
        if network.waiting == 0 {
            let go = network.settled();
            assert_eq!(go.len(), 1, "seed {seed}");
            winners.extend(go);
        }
    }
    assert_eq!(winners, BTreeSet::from([0, 1, 2]));
}

/// A connection that breaks and comes back: both have gone on without each other, and one of them does in the end.
#[test]
fn of_two_that_were_cut_off_the_one_that_has_gone_on_far_longer_does() {
    for (first, second) in [(3, 7), (7, 3)] {
        let (mut long, mut short) = (alone(first, 3000), alone(second, 300));
        let claims = [long.claim(), short.claim()];
        long.update(seconds(3001), [claims[1]]);
        short.update(seconds(301), [claims[0]]);
        assert!(!long.stands() && short.stands());
    }
}
