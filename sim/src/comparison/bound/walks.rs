//! The most credit that a walk can earn: an exact dynamic program over all walks.
//!
//! A walk earns the price of a target whenever it comes into sight that was not in sight from the two cells before, so
//! every target that a walk has seen has been paid at least once. A state is the position with the one before, and
//! which of a few *landmarks* have been seen: groups of neighboring targets with a second price, paid once.

use std::collections::VecDeque;
use std::ops::Range;

use super::board::Board;

/// Prices are counted in this part of a target.
pub(super) const UNIT: i32 = 1024;

/// A position with the one before, and the moves from there.
struct Node {
    position: u16,
    turns: Range<u32>,
}

/// A move that follows another one.
struct Turn {
    next: u32,
    length: u8,
    /// Targets that come into sight, the first `Turn::glances` of them by a single glance if the walk goes straight on.
    entered: Range<u32>,
    glances: u32,
    /// Landmarks in sight.
    landmarks: u32,
}

/// All walks on a board.
pub(super) struct Walks<'a> {
    board: &'a Board,
    /// The first are walks that have just begun, by position.
    nodes: Vec<Node>,
    turns: Vec<Turn>,
    entered: Vec<u16>,
    /// Targets of each landmark.
    pub landmarks: Vec<Vec<u16>>,
    /// Landmarks in sight of each position.
    sight: Vec<u32>,
}

/// What a walk earns by targets, [`UNIT`]s.
#[derive(Clone)]
pub(super) struct Prices {
    /// Whenever the target comes into sight, by target.
    pub entry: Vec<i32>,
    /// Once, when a target of its landmark does, by target.
    pub once: Vec<i32>,
    /// The share of `entry` for a glance, [`UNIT`]s.
    pub glance: i32,
}

/// The most credit, [`UNIT`]s, and how to earn it.
pub(super) struct MostCredit {
    /// After each unit of length, by start position.
    pub from: Vec<Vec<i32>>,
    /// For each unit of length left but 0, by state: the turn, or [`STAY`].
    turns: Vec<Vec<u8>>,
}

/// No turn earns anything.
const STAY: u8 = u8::MAX;

/// What a walk has been paid for.
pub(super) struct Earned {
    /// How often each target came into sight; by a glance it counts as its share.
    pub entries: Vec<f64>,
    /// The landmarks that were seen.
    pub landmarks: u32,
}

impl<'a> Walks<'a> {
    pub(super) fn new(board: &'a Board, landmarks: Vec<Vec<u16>>) -> Self {
        let sight = board.seen.iter().map(|seen| {
            let is_seen = |landmark: &Vec<u16>| landmark.iter().any(|it| seen.binary_search(it).is_ok());
            (0..).zip(&landmarks).filter(|(_, it)| is_seen(it)).fold(0, |bits, (bit, _)| bits | 1 << bit)
        });
        let mut walks = Self {
            board,
            nodes: Vec::new(),
            turns: Vec::new(),
            entered: Vec::new(),
            sight: sight.collect(),
            landmarks,
        };
        let count = u32::try_from(board.positions.len()).unwrap_or(u32::MAX);
        // The node of a move is numbered behind those of the starts, in order of its start.
        let mut first = vec![count];
        for steps in &board.steps {
            first.push(first[first.len() - 1] + u32::try_from(steps.len()).unwrap_or(0));
        }
        let starts = (0..board.positions.len()).map(|at| (None, at));
        let moved = board.steps.iter().enumerate();
        let moved =
            moved.flat_map(|(from, steps)| steps.iter().map(move |it| (Some(from), usize::from(it.to))));
        let mut seen = Seen { counts: vec![0; board.targets.len()] };
        for (before, at) in starts.chain(moved) {
            walks.add(before, at, first[at], &mut seen);
        }
        walks
    }

    /// Number of positions with the one before.
    pub(super) const fn node_count(&self) -> usize {
        self.nodes.len()
    }

    fn add(&mut self, before: Option<usize>, at: usize, first: u32, seen: &mut Seen) {
        let board = self.board;
        let start = self.turns.len();
        for &position in before.iter().chain([&at]) {
            seen.change(&board.seen[position], 1);
        }
        for (next, step) in (first..).zip(&board.steps[at]) {
            let to = usize::from(step.to);
            let from = self.entered.len();
            let (mut glances, mut others) = (Vec::new(), Vec::new());
            for &target in &board.seen[to] {
                match seen.counts[usize::from(target)] {
                    0 if board.is_glance(target, at, to) => glances.push(target),
                    0 => others.push(target),
                    1 if before.is_some_and(|before| board.is_glanced(target, before, at)) => {
                        glances.push(target);
                    }
                    _ => {}
                }
            }
            let glance_count = glances.len();
            self.entered.extend(glances.into_iter().chain(others));
            self.turns.push(Turn {
                next,
                length: step.length,
                entered: range(from, self.entered.len()),
                glances: u32::try_from(glance_count).unwrap_or(0),
                landmarks: self.sight[to],
            });
        }
        for &position in before.iter().chain([&at]) {
            seen.change(&board.seen[position], -1);
        }
        let position = u16::try_from(at).unwrap_or(u16::MAX);
        self.nodes.push(Node { position, turns: range(start, self.turns.len()) });
    }

    /// The most credit that a walk earns within each length, from 0 on, until `is_enough` says so of the last one or
    /// the length is `longest` (units).
    pub(super) fn most_credit(
        &self,
        prices: &Prices,
        longest: usize,
        is_enough: impl Fn(&[i32]) -> bool,
    ) -> MostCredit {
        let masks = 1_usize << self.landmarks.len();
        let entry = |target: u16| prices.entry[usize::from(target)];
        let glance = |target: u16| prices.glance_price(target);
        let gains: Vec<i32> = self
            .turns
            .iter()
            .map(|turn| {
                let (glances, others) = self.split(turn);
                glances.iter().map(|&it| glance(it)).sum::<i32>()
                    + others.iter().map(|&it| entry(it)).sum::<i32>()
            })
            .collect();
        let worth = self.worth_of_landmarks(prices);
        let first: Vec<i32> = (0..self.board.positions.len())
            .map(|at| {
                self.board.seen[at].iter().map(|&it| entry(it)).sum::<i32>() + worth[self.sight[at] as usize]
            })
            .collect();
        // The last values, as many as the longest move has units; the newest first.
        let mut values: VecDeque<Vec<i32>> = VecDeque::from([vec![0; self.nodes.len() * masks]]);
        let mut most = MostCredit { from: Vec::new(), turns: Vec::new() };
        loop {
            let from = |at: usize| first[at] + values[0][at * masks + self.sight[at] as usize];
            let from: Vec<i32> = (0..first.len()).map(from).collect();
            let is_last = most.from.len() == longest || is_enough(&from);
            most.from.push(from);
            if is_last {
                return most;
            }
            let mut next = vec![0; self.nodes.len() * masks];
            let mut taken = vec![STAY; next.len()];
            let states = next.chunks_exact_mut(masks).zip(taken.chunks_exact_mut(masks));
            for (node, (next, taken)) in self.nodes.iter().zip(states) {
                let turns = node.turns.start as usize..node.turns.end as usize;
                for (place, (turn, gain)) in (0..).zip(self.turns[turns.clone()].iter().zip(&gains[turns])) {
                    let Some(values) = values.get(usize::from(turn.length) - 1) else { continue };
                    let after = &values[turn.next as usize * masks..][..masks];
                    let new = turn.landmarks & !self.sight[usize::from(node.position)];
                    improve((next, taken), (after, &worth), (new as usize, *gain), place);
                }
            }
            most.turns.push(taken);
            values.push_front(next);
            values.truncate(LONGEST_MOVE);
        }
    }

    /// What landmarks are worth together, by their bits.
    fn worth_of_landmarks(&self, prices: &Prices) -> Vec<i32> {
        let each =
            self.landmarks.iter().map(|it| it.iter().map(|&it| prices.once[usize::from(it)]).sum::<i32>());
        let each: Vec<i32> = each.collect();
        let is_set = |mask: usize, bit: usize| mask >> bit & 1 == 1;
        (0..1 << each.len())
            .map(|mask| {
                each.iter().enumerate().filter(|&(bit, _)| is_set(mask, bit)).map(|(_, worth)| worth).sum()
            })
            .collect()
    }

    /// Targets that come into sight, by a glance and otherwise.
    fn split(&self, turn: &Turn) -> (&[u16], &[u16]) {
        let entered = &self.entered[turn.entered.start as usize..turn.entered.end as usize];
        entered.split_at(turn.glances as usize)
    }

    /// Adds what a walk is paid for that earns the most credit within a length (units).
    pub(super) fn retrace(
        &self,
        most: &MostCredit,
        glance: f64,
        start: u16,
        length: usize,
        earned: &mut Earned,
    ) {
        let masks = 1_usize << self.landmarks.len();
        let mut node = usize::from(start);
        let mut seen = self.sight[node];
        for &target in &self.board.seen[node] {
            earned.entries[usize::from(target)] += 1.0;
        }
        let mut left = length;
        while left > 0 {
            let place = most.turns[left - 1][node * masks + seen as usize];
            if place == STAY {
                break;
            }
            let turn = &self.turns[self.nodes[node].turns.start as usize + usize::from(place)];
            let (glances, others) = self.split(turn);
            for (targets, share) in [(glances, glance), (others, 1.0)] {
                for &target in targets {
                    earned.entries[usize::from(target)] += share;
                }
            }
            seen |= turn.landmarks;
            node = turn.next as usize;
            left -= usize::from(turn.length);
        }
        earned.landmarks |= seen;
    }
}

/// Units of the longest move.
const LONGEST_MOVE: usize = 7;

impl Prices {
    /// What a glance earns, rounded up.
    fn glance_price(&self, target: u16) -> i32 {
        (self.entry[usize::from(target)] * self.glance + UNIT - 1) / UNIT
    }
}

/// Takes a turn in each state of a node where it earns more: it gains this much, and sees new landmarks.
#[inline]
fn improve(
    (best, taken): (&mut [i32], &mut [u8]),
    (after, worth): (&[i32], &[i32]),
    (new, gain): (usize, i32),
    place: u8,
) {
    if new == 0 {
        for ((best, taken), after) in best.iter_mut().zip(taken).zip(after) {
            let value = gain + after;
            let is_better = value > *best;
            *best = if is_better { value } else { *best };
            *taken = if is_better { place } else { *taken };
        }
        return;
    }
    for (seen, (best, taken)) in best.iter_mut().zip(taken).enumerate() {
        let value = gain + after[seen | new] + worth[seen | new] - worth[seen];
        if value > *best {
            (*best, *taken) = (value, place);
        }
    }
}

/// How often each target is in sight from a few positions.
struct Seen {
    counts: Vec<i8>,
}

impl Seen {
    fn change(&mut self, targets: &[u16], by: i8) {
        for &target in targets {
            self.counts[usize::from(target)] += by;
        }
    }
}

fn range(start: usize, end: usize) -> Range<u32> {
    u32::try_from(start).unwrap_or(u32::MAX)..u32::try_from(end).unwrap_or(u32::MAX)
}
