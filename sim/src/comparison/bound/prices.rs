//! Prices that leave walks the least to see, by a subgradient method.
//!
//! Any prices give a bound; these are sought: a target that the walks of the most credit see more than once, in the
//! mean, is paid less, and one that they miss more. No two walks have the same best prices, so of all prices that were
//! tried the best counts for each start and length.

use dragnet_search::seed::{Purpose, Stream, stream};
use rand::RngExt;

use super::board::{Board, Starts};
use super::walks::{Earned, MostCredit, Prices, UNIT, Walks};

/// Prices that are tried, without landmarks and with them, which takes longer.
const TRIALS: u32 = 150;
const TRIALS_WITH_LANDMARKS: u32 = 80;
/// Walks that each trial samples.
const SAMPLES: u32 = 128;
/// The first change of a price, for a target that no sampled walk sees, and the trials after which it is halved.
const FIRST_CHANGE: f64 = 0.2;
const HALVED_AFTER: f64 = 20.0;
/// How far beyond the end of a search walks are looked at, targets.
const BEYOND: f64 = 8.0;

/// Starts of all robots, one of several that are equally likely.
pub(super) struct Case<'a> {
    /// For each robot, where it may start: for the bound, at the best of these.
    pub starts: Vec<&'a [u16]>,
}

/// Targets that walks leave unseen at least, [`UNIT`]s.
pub(super) struct Unseen {
    /// After each unit of length, by case; at most 0 from the last on.
    pub least: Vec<Vec<i32>>,
}

/// What the search for prices is to know.
pub(super) struct Search<'a> {
    pub board: &'a Board,
    pub cases: &'a [Case<'a>],
    /// Share of the price for a glance, [`UNIT`]s.
    pub glance: i32,
    /// Probability that a target holds no object, about: what matters is what is left when few objects are.
    pub is_empty: f64,
    /// Length that is of interest, units.
    pub longest: usize,
}

impl<'a> Case<'a> {
    pub(super) fn all(starts: &'a Starts, robots: usize) -> Vec<Self> {
        match starts {
            Starts::Together(starts) => {
                starts.chunks(1).map(|start| Self { starts: vec![start; robots] }).collect()
            }
            Starts::Apart(starts) => vec![Self { starts: starts.iter().map(Vec::as_slice).collect() }],
        }
    }

    /// The robots' starts of most credit.
    fn best(&self, from: &[i32]) -> impl Iterator<Item = u16> {
        let best = |starts: &&[u16]| starts.iter().copied().max_by_key(|&at| from[usize::from(at)]);
        self.starts.iter().filter_map(best)
    }

    fn credit(&self, from: &[i32]) -> i32 {
        self.best(from).map(|at| from[usize::from(at)]).sum()
    }
}

impl Unseen {
    pub(super) const fn new() -> Self {
        Self { least: Vec::new() }
    }

    /// Takes what other prices prove where it is more.
    fn improve(&mut self, other: Vec<Vec<i32>>) {
        for (place, other) in other.into_iter().enumerate() {
            match self.least.get_mut(place) {
                None => self.least.push(other),
                Some(least) => {
                    least.iter_mut().zip(other).for_each(|(least, other)| *least = (*least).max(other));
                }
            }
        }
    }
}

impl Search<'_> {
    /// Tries prices on walks with these landmarks.
    pub(super) fn run(&self, walks: &Walks<'_>, unseen: &mut Unseen) {
        let mut random = stream(0, Purpose::Bound, 0);
        let mut shares = Shares::new(self.board.targets.len(), &walks.landmarks);
        let trials = if walks.landmarks.is_empty() { TRIALS } else { TRIALS_WITH_LANDMARKS };
        for trial in 0..trials {
            let prices = shares.prices(self.glance);
            let total: i32 = prices.entry.iter().chain(&prices.once).sum();
            #[expect(clippy::cast_possible_truncation, reason = "a small constant")]
            let beyond = (BEYOND * f64::from(UNIT)) as i32;
            let is_enough = |from: &[i32]| self.cases.iter().all(|case| total - case.credit(from) < -beyond);
            let most = walks.most_credit(&prices, self.longest, is_enough);
            let left: Vec<Vec<i32>> = most
                .from
                .iter()
                .map(|from| self.cases.iter().map(|case| total - case.credit(from)).collect())
                .collect();
            let earned = self.sample(walks, &most, &left, &mut random);
            let change = FIRST_CHANGE / (1.0 + f64::from(trial) / HALVED_AFTER);
            shares.change(&earned, change, &walks.landmarks);
            unseen.improve(left);
        }
    }

    /// Walks of the most credit; the likelier an end is near, the more of them. Returns entries of each target and sights
    /// of each landmark, for a walk.
    fn sample(
        &self,
        walks: &Walks<'_>,
        most: &MostCredit,
        left: &[Vec<i32>],
        random: &mut Stream,
    ) -> (Vec<f64>, Vec<f64>) {
        let weight = |&left: &i32| {
            libm::pow(self.is_empty, f64::from(left).max(-BEYOND * f64::from(UNIT)) / f64::from(UNIT))
        };
        let mut sums = Vec::with_capacity(left.len() * self.cases.len());
        let mut sum = 0.0;
        for left in left.iter().flatten() {
            sum += weight(left);
            sums.push(sum);
        }
        let mut earned = Earned { entries: vec![0.0; self.board.targets.len()], landmarks: 0 };
        let mut sights = vec![0.0; walks.landmarks.len()];
        for _ in 0..SAMPLES {
            let drawn = random.random::<f64>() * sum;
            let place = sums.partition_point(|&sum| sum < drawn).min(sums.len() - 1);
            let (length, case) = (place / self.cases.len(), &self.cases[place % self.cases.len()]);
            earned.landmarks = 0;
            for start in case.best(&most.from[length]) {
                walks.retrace(most, f64::from(self.glance) / f64::from(UNIT), start, length, &mut earned);
            }
            for (bit, sights) in sights.iter_mut().enumerate() {
                *sights += f64::from(earned.landmarks >> bit & 1);
            }
        }
        let mean = |values: Vec<f64>| values.into_iter().map(|it| it / f64::from(SAMPLES)).collect();
        (mean(earned.entries), mean(sights))
    }
}

/// Prices as shares of a target, `0..=1` together.
struct Shares {
    entry: Vec<f64>,
    once: Vec<f64>,
}

impl Shares {
    fn new(targets: usize, landmarks: &[Vec<u16>]) -> Self {
        let mut shares = Self { entry: vec![1.0; targets], once: vec![0.0; targets] };
        for &target in landmarks.iter().flatten() {
            (shares.entry[usize::from(target)], shares.once[usize::from(target)]) = (0.5, 0.5);
        }
        shares
    }

    #[expect(clippy::cast_possible_truncation, reason = "at most one unit")]
    fn prices(&self, glance: i32) -> Prices {
        let units = |shares: &[f64]| shares.iter().map(|it| (it * f64::from(UNIT)).floor() as i32).collect();
        Prices { entry: units(&self.entry), once: units(&self.once), glance }
    }

    /// Raises prices of what is missed, and lowers those of what is seen more than once.
    fn change(&mut self, (entries, sights): &(Vec<f64>, Vec<f64>), change: f64, landmarks: &[Vec<u16>]) {
        for (share, entries) in self.entry.iter_mut().zip(entries) {
            *share = (*share + change * (1.0 - entries)).clamp(0.0, 1.0);
        }
        for (landmark, sights) in landmarks.iter().zip(sights) {
            for &target in landmark {
                let (entry, once) =
                    (&mut self.entry[usize::from(target)], &mut self.once[usize::from(target)]);
                *once = (*once + change * (1.0 - sights)).clamp(0.0, 1.0);
                let excess = (*entry + *once - 1.0).max(0.0);
                let taken = (excess / 2.0).min(*entry).max(excess - *once);
                *entry -= taken;
                *once -= excess - taken;
            }
        }
    }
}
