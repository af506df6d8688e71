//! Subjects of known number: a search for exactly `N` objects, each in one of the searched cells or outside of all of them.
//!
//! A [`Belief`] takes cells for independent: each has a probability of its own, and evidence about one says nothing about
//! another. If the number of objects is known, evidence about a cell moves all others: where no subject is, they are less
//! likely to be, and elsewhere, also outside of the searched area, more likely; and once all are found, no other cell has one. The evidence is the same
//! sum in both cases ([`crate::evidence`]), so this is a view on a belief, computed on demand.
//!
//! # Derivation
//!
//! Let first `N = 1`, and let `H(i)` say that the subject is in cell `i`, with the prior probability of area `p(i)` (POA), and `H(0)`
//! that it is in the rest of the world (ROW), with `r = 1 - sum p(i)`. Readings are independent given where the subject is, and under
//! `H(i)` only those of cell `i` have another distribution than under `H(0)`, under which all cells are empty. So all
//! readings together are `e^l(i)` times as likely under `H(i)` as under `H(0)`, where `l(i)` is the log-likelihood ratio of
//! the readings of cell `i` alone ([`crate::evidence::CellEvidence::log_likelihood_ratio_nats`]). By Bayes' rule
//!
//! ```text
//! P(i) = p(i) e^l(i) / Z,     P(0) = r / Z,     Z = r + sum over cells j of p(j) e^l(j)
//! ```
//!
//! A search by eye that found nothing has `e^l(i) = 1 - POD(i)`. Then `Z = 1 - sum p(i) POD(i)`, one minus the cumulative
//! probability of success of search planning, and `P` is its updated POA. Before any reading `Z = 1`.
//!
//! For `N > 1` let each cell hold one independently with the prior probability `N p(i)`, as a [`Belief`] has it, and let a Poisson number
//! with the mean `N r` be outside; what is known is that there are `N` in all. Their mean is `N`, so that in a cell and outside about as
//! many are expected as without that knowledge. With the odds `o(i)` of the belief, prior and evidence, the probability that a set `S` of cells holds them, and
//! `N - |S|` are outside, is
//!
//! ```text
//! P(S) = product over i in S of o(i) * (N r)^(N - |S|) / (N - |S|)! / Z
//! ```
//!
//! where `Z` makes the sum over all sets of at most `N` cells 1. `P(i)` is the sum over the sets with cell `i`. A factor on all odds and `r`
//! changes nothing; it is chosen so that about `N` are expected (`several`).
//!
//! Sources: B. O. Koopman, "Search and Screening" (1946; Pergamon, 1980); L. D. Stone, "Theory of Optimal Search" (1975),
//! where the target may be outside of the searched region with positive probability; IAMSAR Manual, Volume II, chapter 4
//! (POC or POA, POD, POS); for several, S. X. Chen and J. S. Liu, "Statistical Applications of the Poisson-Binomial and Conditional Bernoulli
//! Distributions" (Statistica Sinica 7, 1997). Departures: no cell holds two subjects; evidence is that of readings, which may speak for a subject as well, and cells that
//! an operator adds to the area take their mass from all places in proportion, since `Z` divides by what there is.

mod several;

use std::fmt;

use crate::belief::Belief;
use crate::cell::Cell;
use crate::reach::Reach;
use crate::seed::Stream;
use crate::terrain::Terrain;

/// That the number of objects that are sought is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subjects {
    number: u32,
    rest_of_world: f64,
}

impl Subjects {
    /// The most subjects.
    pub const MAX_NUMBER: u32 = 100;

    /// This number of subjects, 1 to [`Subjects::MAX_NUMBER`], each outside of the searched cells with this prior probability, 0 to
    /// below 1; `None` for other numbers.
    #[must_use]
    pub fn new(number: u32, rest_of_world: f64) -> Option<Self> {
        let is_valid = (1..=Self::MAX_NUMBER).contains(&number) && (0.0..1.0).contains(&rest_of_world);
        is_valid.then_some(Self { number, rest_of_world })
    }

    /// How many there are, from 1.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.number
    }

    /// Prior probability that a subject is outside of the searched cells, 0 to below 1.
    #[must_use]
    pub const fn rest_of_world(self) -> f64 {
        self.rest_of_world
    }

    /// Where the subjects are, given all evidence. [`Belief::prior_probability`] of a cell is its probability of area times their
    /// number; unless the search continues another, together they are one minus [`Subjects::rest_of_world`] of that number, up to rounding and added cells. Equal evidence gives
    /// equal bits.
    #[must_use]
    pub fn posterior(self, belief: &Belief) -> SubjectPosterior {
        match self.number {
            1 => {
                let prior = belief.prior_log_odds();
                let cells = prior.iter().zip(belief.evidence().cells());
                let nats = cells.map(|(prior, it)| ln_probability(*prior) + it.log_likelihood_ratio_nats());
                of_one(nats.collect(), self.rest_of_world.ln())
            }
            number => {
                let odds: Vec<f64> = belief.log_odds().collect();
                let (probability, rest_of_world) = several::posterior(&odds, self.of_several());
                SubjectPosterior { number, probability, rest_of_world }
            }
        }
    }

    /// [`SubjectPosterior::expected_remaining`] of the posterior, sooner.
    #[must_use]
    pub fn expected_remaining(
        self,
        belief: &Belief,
        terrain: &Terrain,
        reach: &Reach,
        is_declared: impl Fn(Cell) -> bool,
    ) -> f64 {
        if self.number == 1 {
            return self.posterior(belief).expected_remaining(terrain, reach, is_declared);
        }
        let is_left = |cell| terrain.is_searched(cell) && reach.covers(cell) && !is_declared(cell);
        let is_left: Vec<bool> = terrain.grid().cells().map(is_left).collect();
        let odds: Vec<f64> = belief.log_odds().collect();
        several::of_some(&odds, self.of_several(), &[], &is_left).1
    }

    /// [`SubjectPosterior::probability`] of each declared cell, in their order, and [`SubjectPosterior::expected_remaining`]
    /// without these cells, sooner.
    #[must_use]
    pub fn of_declared(
        self,
        belief: &Belief,
        terrain: &Terrain,
        reach: &Reach,
        declared: &[Cell],
    ) -> (Vec<f64>, f64) {
        if self.number == 1 {
            let posterior = self.posterior(belief);
            let of_declared = declared.iter().map(|&cell| posterior.probability(cell)).collect();
            return (
                of_declared,
                posterior.expected_remaining(terrain, reach, |cell| declared.contains(&cell)),
            );
        }
        let in_reach = |cell| terrain.is_searched(cell) && reach.covers(cell);
        let in_reach: Vec<bool> = terrain.grid().cells().map(in_reach).collect();
        let odds: Vec<f64> = belief.log_odds().collect();
        let declared: Vec<usize> = declared.iter().map(|cell| cell.index()).collect();
        several::of_some(&odds, self.of_several(), &declared, &in_reach)
    }

    /// Cells that hold subjects, at least two in all, drawn by what a belief says of them, by index; the others are outside.
    ///
    /// Cells and the number outside are drawn independently, and anew until there are as many in all as there are subjects.
    #[must_use]
    pub fn draw(self, belief: &Belief, random: &mut Stream) -> Vec<usize> {
        let odds: Vec<f64> = belief.log_odds().collect();
        several::draw(&odds, self.of_several(), random)
    }

    /// What several are, and where each may be.
    fn of_several(self) -> several::Number {
        let number = f64::from(self.number);
        several::Number { number: self.number as usize, rest_nats: (number * self.rest_of_world).ln() }
    }
}

fn of_one(mut probability: Vec<f64>, rest_nats: f64) -> SubjectPosterior {
    // Strong evidence exceeds the range of exponentials: all are divided by the greatest.
    let greatest_nats = probability.iter().copied().fold(rest_nats, f64::max);
    if greatest_nats == f64::NEG_INFINITY {
        // Nothing is searched.
        return SubjectPosterior { number: 1, probability: vec![0.0; probability.len()], rest_of_world: 1.0 };
    }
    let rest = (rest_nats - greatest_nats).exp();
    let mut sum = rest;
    for mass in &mut probability {
        *mass = (*mass - greatest_nats).exp();
        sum += *mass;
    }
    for mass in &mut probability {
        *mass /= sum;
    }
    SubjectPosterior { number: 1, probability, rest_of_world: rest / sum }
}

/// `ln p` of log-odds `ln(p / (1 - p))`.
fn ln_probability(log_odds_nats: f64) -> f64 {
    // exp overflows to infinity at -inf, whose logarithm is right.
    if log_odds_nats < 0.0 {
        log_odds_nats - log_odds_nats.exp().ln_1p()
    } else {
        -(-log_odds_nats).exp().ln_1p()
    }
}

/// Where the subjects are: the probability of each cell, and the expected number in the rest of the world. They add up to
/// the number of subjects.
#[derive(Clone, Debug, PartialEq)]
pub struct SubjectPosterior {
    number: u32,
    probability: Vec<f64>,
    rest_of_world: f64,
}

/// The posterior by what was declared, as expected numbers of subjects: found, remaining and rest of the world add up to their
/// number. Of one subject they are probabilities. It is no probability of success
/// (POS), which says of an effort, and not of what was seen, how probable a find is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// How many there are.
    pub number: u32,
    /// Subjects in declared cells.
    pub found: f64,
    /// In other searched cells.
    pub remaining: f64,
    /// Those of them in cells out of every robot's reach: no search by these robots can lower it.
    pub out_of_reach: f64,
    /// In the rest of the world (ROW).
    pub rest_of_world: f64,
}

impl Standing {
    /// The least number out of reach that is told, as it is printed.
    const LEAST: f64 = 0.000_05;

    /// `subject`, or `subjects` if there are several.
    #[must_use]
    pub const fn noun(&self) -> &'static str {
        if self.number == 1 { "subject" } else { "subjects" }
    }
}

impl fmt::Display for Standing {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { number, found, remaining, out_of_reach, rest_of_world } = self;
        match number {
            1 => write!(
                formatter,
                "in a declared cell with {found:.4}, elsewhere in the area with {remaining:.4}"
            )?,
            _ => write!(
                formatter,
                "of {number}, {found:.4} expected in declared cells, {remaining:.4} elsewhere in the area"
            )?,
        }
        if *out_of_reach >= Self::LEAST {
            write!(formatter, ", of which {out_of_reach:.4} out of every robot's reach")?;
        }
        let with = if *number == 1 { "with " } else { "" };
        write!(formatter, ", outside of the area {with}{rest_of_world:.4}")
    }
}

impl SubjectPosterior {
    /// How many subjects there are.
    #[must_use]
    pub const fn number(&self) -> u32 {
        self.number
    }

    /// Probability that a subject is in a cell.
    #[must_use]
    pub fn probability(&self, cell: Cell) -> f64 {
        self.probability[cell.index()]
    }

    /// Probability that a certain one of the subjects is in a cell.
    #[must_use]
    pub fn of_each(&self, cell: Cell) -> f64 {
        self.probability(cell) / f64::from(self.number)
    }

    /// Probability of each cell, shape `[cells]`; 0 where nothing is searched.
    #[must_use]
    pub fn probabilities(&self) -> &[f64] {
        &self.probability
    }

    /// How many subjects are expected outside of all searched cells; of one subject, the probability that it is.
    #[must_use]
    pub const fn rest_of_world(&self) -> f64 {
        self.rest_of_world
    }

    /// The expected number of subjects in cells in reach that are not declared.
    #[must_use]
    pub fn expected_remaining(
        &self,
        terrain: &Terrain,
        reach: &Reach,
        is_declared: impl Fn(Cell) -> bool,
    ) -> f64 {
        let remaining = terrain.searched_cells().filter(|&cell| reach.covers(cell) && !is_declared(cell));
        remaining.map(|cell| self.probability(cell)).sum::<f64>() + 0.0
    }

    /// The posterior by which cells are declared. As long as the prior and the sensor's model are right, as many subjects are in
    /// declared cells in the mean as [`Standing::found`] says, whenever and by whatever rule the search ends.
    #[must_use]
    pub fn standing(&self, terrain: &Terrain, reach: &Reach, is_declared: impl Fn(Cell) -> bool) -> Standing {
        let Self { number, rest_of_world, .. } = *self;
        let mut standing = Standing { number, found: 0.0, remaining: 0.0, out_of_reach: 0.0, rest_of_world };
        for cell in terrain.searched_cells() {
            let probability = self.probability(cell);
            if is_declared(cell) {
                standing.found += probability;
                continue;
            }
            standing.remaining += probability;
            if !reach.covers(cell) {
                standing.out_of_reach += probability;
            }
        }
        standing
    }

    /// The same probabilities as a belief without evidence, to be shown like any other.
    #[must_use]
    pub fn shown(&self, terrain: &Terrain) -> Option<Belief> {
        let log_odds_nats = self.probability.iter().map(|p| (p / (1.0 - p)).ln()).collect();
        Belief::from_log_odds(terrain, log_odds_nats).ok()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::evidence::Reading;
    use crate::reach::Sight;

    fn field(drawing: &str, prior: &[f64]) -> (Terrain, Belief, Vec<Cell>) {
        let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
        let cells = terrain.grid().cells().collect();
        let belief = Belief::new(&terrain, prior).unwrap();
        (terrain, belief, cells)
    }

    fn tell(belief: &mut Belief, cell: Cell, nats: f64) {
        let value = if nats > 0.0 { 1.0 } else { 0.0 };
        belief.add(&Reading::with_nats(cell, value, nats.abs()));
    }

    fn assert_near(given: &[f64], expected: &[f64]) {
        let is_near = |(given, expected): (&f64, &f64)| (given - expected).abs() < 1e-4;
        assert!(given.len() == expected.len() && given.iter().zip(expected).all(is_near), "{given:?}");
    }

    /// The numbers by hand: half of the mass of the first cell is searched with POD 0.8, and nothing is found.
    #[test]
    fn what_is_not_here_is_more_likely_elsewhere() {
        let (_, mut belief, cells) = field("...", &[0.5, 0.3, 0.1]);
        let subject = Subjects::new(1, 0.1).unwrap();
        assert_near(subject.posterior(&belief).probabilities(), &[0.5, 0.3, 0.1]);
        tell(&mut belief, cells[0], 0.2_f64.ln());
        let posterior = subject.posterior(&belief);
        assert_near(posterior.probabilities(), &[0.1 / 0.6, 0.3 / 0.6, 0.1 / 0.6]);
        assert_near(&[posterior.rest_of_world()], &[0.1 / 0.6]);
        tell(&mut belief, cells[1], 0.1_f64.ln());
        tell(&mut belief, cells[2], 0.1_f64.ln());
        let z = 0.1 + 0.03 + 0.01 + 0.1;
        assert_near(&[subject.posterior(&belief).rest_of_world()], &[0.1 / z]);
    }

    #[test]
    fn a_find_takes_the_mass_of_all_other_places_and_two_contradict_each_other() {
        let (terrain, mut belief, cells) = field("....", &[0.2; 4]);
        let subject = Subjects::new(1, 0.2).unwrap();
        tell(&mut belief, cells[0], 10.0);
        let everywhere = Reach::unknown(terrain.grid());
        let standing = subject.posterior(&belief).standing(&terrain, &everywhere, |cell| cell == cells[0]);
        assert!(standing.found > 0.999 && standing.remaining < 1e-3, "{standing:?}");
        tell(&mut belief, cells[3], 10.0);
        let posterior = subject.posterior(&belief);
        assert_near(posterior.probabilities(), &[0.5, 0.0, 0.0, 0.5]);
        assert!(
            cells.iter().all(|&cell| belief.probability(cell) > 0.999 || belief.probability(cell) < 0.21)
        );
    }

    #[test]
    fn certain_evidence_and_certain_areas_stay_numbers() {
        let (terrain, mut belief, cells) = field("..,", &[0.7, 0.3, 0.9]);
        let inside = Subjects::new(1, 0.0).unwrap();
        for cell in [cells[0], cells[1]] {
            for _ in 0..40 {
                tell(&mut belief, cell, -40.0);
            }
        }
        assert_near(inside.posterior(&belief).probabilities(), &[0.7, 0.3, 0.0]);
        assert_near(&[Subjects::new(1, 0.01).unwrap().posterior(&belief).rest_of_world()], &[1.0]);
        for _ in 0..60 {
            tell(&mut belief, cells[1], 40.0);
        }
        assert_near(inside.posterior(&belief).probabilities(), &[0.0, 1.0, 0.0]);
        let nowhere = Belief::uniform(&terrain, 0.0).unwrap();
        assert_near(&[inside.posterior(&nowhere).rest_of_world()], &[1.0]);
        for wrong in [-0.1, 1.0, f64::NAN] {
            assert_eq!(Subjects::new(1, wrong), None);
        }
    }

    #[test]
    fn the_subject_remains_in_cells_in_reach_that_are_not_declared() {
        let (terrain, belief, cells) = field(".~~~", &[0.2; 4]);
        let posterior = Subjects::new(1, 0.2).unwrap().posterior(&belief);
        let mut reach = Reach::unknown(terrain.grid());
        let remaining =
            |reach: &Reach| posterior.expected_remaining(&terrain, reach, |cell| cell == cells[0]);
        assert_near(&[remaining(&reach)], &[0.6]);
        reach.add_robot(&terrain, Sight::on_ground(1), cells[0]);
        assert_near(&[remaining(&reach)], &[0.2]);
        let shown = posterior.shown(&terrain).unwrap();
        assert_near(&shown.probabilities(), posterior.probabilities());
    }

    proptest! {
        /// By enumeration: the joint probability of each place with independent readings, divided by their sum.
        #[test]
        fn the_posterior_is_that_of_all_places_together(
            weights in prop::collection::vec(0.01_f64..1.0, 5), nats in prop::collection::vec(-6.0_f64..6.0, 4),
        ) {
            let sum: f64 = weights.iter().sum();
            let prior: Vec<f64> = weights.iter().map(|weight| weight / sum).collect();
            let (terrain, mut belief, cells) = field("....", &prior[..4]);
            for (&cell, &nats) in cells.iter().zip(&nats) {
                if nats.abs() > 0.01 {
                    tell(&mut belief, cell, nats);
                }
            }
            let likelihood = |cell: Cell| belief.evidence().of(cell).log_likelihood_ratio_nats().exp();
            let mut joint: Vec<f64> = cells.iter().map(|&cell| prior[cell.index()] * likelihood(cell)).collect();
            joint.push(prior[4]);
            let total: f64 = joint.iter().sum();
            let posterior = Subjects::new(1, prior[4]).unwrap().posterior(&belief);
            for (&cell, joint) in cells.iter().zip(&joint) {
                prop_assert!((posterior.probability(cell) - joint / total).abs() < 1e-9);
            }
            let mut reach = Reach::unknown(terrain.grid());
            reach.add_robot(&terrain, Sight::on_ground(1), cells[0]);
            let all = posterior.standing(&terrain, &reach, |cell| cell == cells[0]);
            prop_assert!((all.found + all.remaining + all.rest_of_world - 1.0).abs() < 1e-12);
            prop_assert!((all.found - joint[0] / total).abs() < 1e-9);
            let unseen: f64 = cells.iter().zip(&joint).filter(|(cell, _)| !reach.covers(**cell)).map(|(_, it)| it).sum();
            prop_assert!((all.out_of_reach - unseen / total).abs() < 1e-9);
        }
    }
}
