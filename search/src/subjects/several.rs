//! The posterior of several subjects.

use std::iter;

use rand::RngExt;
use rand_distr::{Distribution, Poisson};

use crate::belief;
use crate::seed::Stream;

/// How far from the number of subjects the mean of the tilted distribution may be.
const TOLERANCE: f64 = 0.25;
/// Log-odds from which a cell is certain to a 64-bit number.
const CERTAIN_NATS: f64 = 50.0;
/// More steps than it takes to halve an interval until 64-bit numbers leave nothing to halve.
const MOST_STEPS: u32 = 200;

/// How many subjects there are, at least two, and the logarithm of how many of them are expected outside.
#[derive(Clone, Copy)]
pub(super) struct Number {
    pub(super) number: usize,
    pub(super) rest_nats: f64,
}

/// With which probability each cell holds a subject, and how many subjects are outside in the mean.
///
/// `nats` are the log-odds of cells that hold one each independently. If the subjects
/// do not fit into the cells, and cannot be outside, all cells that may hold one do.
pub(super) fn posterior(nats: &[f64], of: Number) -> (Vec<f64>, f64) {
    let mut probability = vec![0.0; nats.len()];
    let Some(Tilted { possible, probability: tilted, outside, .. }) = Tilted::of(nats, of) else {
        for (probability, nats) in probability.iter_mut().zip(nats) {
            *probability = if *nats > f64::NEG_INFINITY { 1.0 } else { 0.0 };
        }
        return (probability, 0.0);
    };
    let (of_cells, rest) = given_number(&tilted, &outside, of.number);
    for (cell, given) in possible.into_iter().zip(of_cells) {
        probability[cell] = given;
    }
    (probability, rest)
}

/// What [`posterior`] says of `some` cells, given by index, and how many subjects are in the mean in the others that count: in one
/// pass over all cells, since of the others only the distribution of their number matters.
pub(super) fn of_some(nats: &[f64], of: Number, some: &[usize], is_counted: &[bool]) -> (Vec<f64>, f64) {
    let mut is_some = vec![false; nats.len()];
    for &cell in some {
        is_some[cell] = true;
    }
    let Some(Tilted { possible, probability: tilted, outside, .. }) = Tilted::of(nats, of) else {
        let is_possible = |cell: usize| nats[cell] > f64::NEG_INFINITY;
        let counted = (0..nats.len()).filter(|&it| is_counted[it] && !is_some[it] && is_possible(it)).count();
        let of_some = some.iter().map(|&cell| if is_possible(cell) { 1.0 } else { 0.0 }).collect();
        return (of_some, counted as f64);
    };
    let mut tilted_some = vec![0.0; nats.len()];
    let (mut here, mut elsewhere) = (nothing(of.number), outside);
    for (cell, p) in possible.into_iter().zip(tilted) {
        match (is_some[cell], is_counted[cell]) {
            (true, _) => tilted_some[cell] = p,
            (false, true) => count(&mut here, p),
            (false, false) => count(&mut elsewhere, p),
        }
    }
    let some: Vec<f64> = some.iter().map(|&cell| tilted_some[cell]).collect();
    let (of_some, _) = given_number(&some, &product(&here, &elsewhere), of.number);
    for p in some {
        count(&mut elsewhere, p);
    }
    (of_some, mean(&here, &elsewhere))
}

/// Indices of cells that hold subjects, drawn by their distribution; what is missing is outside.
pub(super) fn draw(nats: &[f64], of: Number, random: &mut Stream) -> Vec<usize> {
    let Some(Tilted { possible, probability, rest, .. }) = Tilted::of(nats, of) else {
        return (0..nats.len()).filter(|&cell| nats[cell] > f64::NEG_INFINITY).collect();
    };
    let outside = Poisson::new(rest).ok();
    loop {
        let cells = possible.iter().zip(&probability).filter(|(_, p)| random.random::<f64>() < **p);
        let cells: Vec<usize> = cells.map(|(&cell, _)| cell).collect();
        let outside = outside.map_or(0.0, |outside| outside.sample(random));
        if (cells.len() as f64 + outside - of.number as f64).abs() < 0.5 {
            return cells;
        }
    }
}

/// The mean of the first of two numbers, given that their sum is the last one of both distributions.
fn mean(of: &[f64], other: &[f64]) -> f64 {
    let counted: Vec<f64> = (0..).zip(of).map(|(count, p)| f64::from(count) * p).collect();
    at_degree(&counted, other) / at_degree(of, other)
}

/// Independent cells, and a number outside, of which about as many are expected as there are: those that are to be taken given
/// their number.
struct Tilted {
    /// Indices of the cells that may hold one.
    possible: Vec<usize>,
    /// The probability of each of them.
    probability: Vec<f64>,
    /// How many are outside in the mean, and the distribution of their number.
    rest: f64,
    outside: Vec<f64>,
}

impl Tilted {
    /// `None` if they do not fit.
    fn of(nats: &[f64], Number { number, rest_nats }: Number) -> Option<Self> {
        let possible: Vec<usize> = (0..nats.len()).filter(|&cell| nats[cell] > f64::NEG_INFINITY).collect();
        if rest_nats == f64::NEG_INFINITY && possible.len() <= number {
            return None;
        }
        let nats: Vec<f64> = possible.iter().map(|&cell| nats[cell]).collect();
        let tilt = tilt(&nats, rest_nats, number);
        let probability = nats.iter().map(|nats| belief::probability(nats + tilt)).collect();
        let rest = (rest_nats + tilt).exp();
        Some(Self { possible, probability, rest, outside: poisson(rest, number) })
    }
}

/// The logarithm of the factor on all weights by which about as many subjects are expected as there are, if each cell holds
/// one independently of all others. Given their number, the factor makes no difference; it keeps all sums within the range of numbers.
///
/// By Newton's method on the logarithm of the expected number, which nearly is a line as long as no cell is likely; where it
/// leaves the interval that holds the root, that is halved.
fn tilt(nats: &[f64], rest_nats: f64, number: usize) -> f64 {
    let number_of = number as f64;
    // The expected number, and its slope.
    let expected = |tilt: f64| {
        let outside = (rest_nats + tilt).exp();
        nats.iter()
            .map(|nats| belief::probability(nats + tilt))
            .fold((outside, outside), |(sum, slope), p| (sum + p, slope + p * (1.0 - p)))
    };
    let greatest = nats.iter().copied().fold(rest_nats, f64::max);
    let mut low = -greatest - (nats.len() as f64 + 1.0).ln();
    // As many are certain, or outside.
    let outside = number_of.ln() - rest_nats;
    let mut high = match nats.len().checked_sub(number) {
        Some(others) => {
            let mut sorted = nats.to_vec();
            let (_, least, _) = sorted.select_nth_unstable_by(others, f64::total_cmp);
            outside.min(CERTAIN_NATS - *least)
        }
        None => outside,
    };
    // A belief that is right expects about as many as there are.
    let mut tilt = if low < 0.0 && 0.0 < high { 0.0 } else { low };
    for _ in 0..MOST_STEPS {
        let (sum, slope) = expected(tilt);
        if (sum - number_of).abs() <= TOLERANCE {
            break;
        }
        *(if sum > number_of { &mut high } else { &mut low }) = tilt;
        let next = tilt + (number_of / sum).ln() * sum / slope;
        tilt = if low < next && next < high { next } else { f64::midpoint(low, high) };
    }
    tilt
}

/// The probability of each cell given that there are `number` in all, for cells that hold one each independently, with these
/// probabilities, and a number outside that has this distribution; and the mean number outside.
///
/// All sums are of positive numbers: those of all cells but one are put together from the cells before it and those after it, in
/// blocks of about the square root of their number, so that neither memory nor time grows with its square.
fn given_number(cells: &[f64], outside: &[f64], number: usize) -> (Vec<f64>, f64) {
    let blocks: Vec<&[f64]> = cells.chunks(cells.len().isqrt().max(1)).collect();
    // Of all blocks from one on.
    let mut after = vec![nothing(number)];
    for cells in blocks.iter().rev() {
        let mut sums = after[after.len() - 1].clone();
        for &p in *cells {
            count(&mut sums, p);
        }
        after.push(sums);
    }
    let of_cells = after.pop().unwrap_or_default();
    let rest = mean(outside, &of_cells);

    let mut before = outside.to_vec();
    let mut probability = Vec::with_capacity(cells.len());
    // Of the cells of a block after one, with all other blocks.
    let mut behind = Vec::new();
    for cells in blocks {
        let mut sums = product(&before, &after.pop().unwrap_or_default());
        behind.clear();
        for &p in cells.iter().rev() {
            behind.extend_from_slice(&sums);
            count(&mut sums, p);
        }
        let mut up_to = nothing(number);
        for (&p, behind) in cells.iter().zip(behind.rchunks_exact(number + 1)) {
            let with_one = p * at_degree(&up_to[..number], &behind[..number]);
            let without = (1.0 - p) * at_degree(&up_to, behind);
            probability.push(with_one / (with_one + without));
            count(&mut up_to, p);
        }
        for &p in cells {
            count(&mut before, p);
        }
    }
    (probability, rest)
}

/// The distribution, up to a number, of how many there are in no cell.
fn nothing(number: usize) -> Vec<f64> {
    let mut sums = vec![0.0; number + 1];
    sums[0] = 1.0;
    sums
}

/// Adds a cell that holds one with this probability to the distribution of a number.
fn count(sums: &mut [f64], p: f64) {
    for most in (1..sums.len()).rev() {
        sums[most] = sums[most] * (1.0 - p) + sums[most - 1] * p;
    }
    sums[0] *= 1.0 - p;
}

/// The distribution of the sum of two numbers, as far as theirs go.
fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len()];
    for (i, a) in a.iter().enumerate() {
        for (sum, b) in product.iter_mut().skip(i).zip(b) {
            *sum += a * b;
        }
    }
    product
}

/// The probability that the sum of two numbers is the last one of both distributions.
fn at_degree(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b.iter().rev()).map(|(a, b)| a * b).sum()
}

/// The Poisson distribution of a mean, up to a number.
fn poisson(mean: f64, number: usize) -> Vec<f64> {
    let mut next = (-mean).exp();
    let mut count = 0.0;
    let terms = iter::from_fn(|| {
        let term = next;
        count += 1.0;
        next *= mean / count;
        Some(term)
    });
    terms.take(number + 1).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::seed::{Purpose, stream};

    /// By enumeration of all sets of cells: what is not in one of them is outside.
    fn enumerated(nats: &[f64], rest_nats: f64, number: usize) -> (Vec<f64>, f64) {
        let greatest = nats.iter().copied().fold(rest_nats, f64::max);
        let (mut cells, mut outside, mut total) = (vec![0.0; nats.len()], 0.0, 0.0);
        for set in 0_u32..1 << nats.len() {
            let inside: Vec<usize> = (0..nats.len()).filter(|cell| set >> cell & 1 == 1).collect();
            let Some(rest) = number.checked_sub(inside.len()) else { continue };
            let orders: f64 = (1..=rest).map(|it| it as f64).product();
            let of_cells: f64 = inside.iter().map(|&cell| (nats[cell] - greatest).exp()).product();
            let weight = of_cells * (rest_nats - greatest).exp().powi(i32::try_from(rest).unwrap()) / orders;
            total += weight;
            outside += rest as f64 * weight;
            for cell in inside {
                cells[cell] += weight;
            }
        }
        (cells.into_iter().map(|it| it / total).collect(), outside / total)
    }

    proptest! {
        #[test]
        fn it_is_that_of_all_sets_of_cells_together(
            nats in prop::collection::vec(prop_oneof![9 => -9.0_f64..9.0, 1 => Just(f64::NEG_INFINITY)], 4..10),
            rest in 0.001_f64..0.9, is_outside in any::<bool>(), number in 2_usize..5,
        ) {
            let rest_nats = if is_outside { rest.ln() } else { f64::NEG_INFINITY };
            let possible = nats.iter().filter(|nats| nats.is_finite()).count();
            prop_assume!(is_outside || possible >= number);
            let (expected, outside) = enumerated(&nats, rest_nats, number);
            let of = Number { number, rest_nats };
            let (given, rest) = posterior(&nats, of);
            for (given, expected) in given.iter().zip(&expected) {
                prop_assert!((given - expected).abs() < 1e-9, "{given} {expected}");
            }
            prop_assert!((rest - outside).abs() < 1e-9, "{rest} {outside}");
            prop_assert!((given.iter().sum::<f64>() + rest - number as f64).abs() < 1e-9);
            let is_counted: Vec<bool> = (0..nats.len()).map(|cell| cell % 3 > 0).collect();
            let counted = given.iter().zip(&is_counted).filter(|(_, it)| **it).map(|(p, _)| p).sum::<f64>();
            prop_assert!((of_some(&nats, of, &[], &is_counted).1 - counted).abs() < 1e-9);
            let (of_two, others) = of_some(&nats, of, &[3, 1], &is_counted);
            prop_assert!((of_two[0] - given[3]).abs() < 1e-9 && (of_two[1] - given[1]).abs() < 1e-9, "{of_two:?}");
            prop_assert!((others - (counted - given[1])).abs() < 1e-9, "1 counts, 3 does not: {others}");
        }

        /// Evidence of many readings exceeds the range of exponentials by far.
        #[test]
        fn strong_evidence_stays_numbers(
            found in 0_usize..6, empty in prop::bool::weighted(0.7), is_outside in any::<bool>(),
            number in 2_usize..40, cells in 50_usize..400,
        ) {
            let mut nats = vec![if empty { -5000.0 } else { -7.0 }; cells];
            nats[..found].fill(4000.0);
            let rest_nats = if is_outside { -2.0 } else { f64::NEG_INFINITY };
            let (given, rest) = posterior(&nats, Number { number, rest_nats });
            prop_assert!(given.iter().all(|p| (0.0..=1.0).contains(p)), "{given:?}");
            let sum = given.iter().sum::<f64>() + rest;
            prop_assert!((sum - number as f64).abs() < 1e-9 * number as f64, "{sum}");
            let sure = found.min(number) as f64 / found as f64;
            prop_assert!(given[..found].iter().all(|p| (p - sure).abs() < 1e-9), "{given:?}");
        }
    }

    #[test]
    fn draws_are_as_frequent_as_the_posterior_says() {
        let nats = [-3.0, 1.0, -1.0, -9.0, f64::NEG_INFINITY, 0.5];
        let of = Number { number: 2, rest_nats: 0.7_f64.ln() };
        let (expected, outside) = posterior(&nats, of);
        let mut random = stream(1, Purpose::Truth, 0);
        let draws: Vec<Vec<usize>> = (0..20_000).map(|_| draw(&nats, of, &mut random)).collect();
        let share = |count: usize| count as f64 / draws.len() as f64;
        for (cell, expected) in expected.iter().enumerate() {
            let frequency = share(draws.iter().filter(|cells| cells.contains(&cell)).count());
            assert!((frequency - expected).abs() < 0.015, "{cell}: {frequency} {expected}");
        }
        let inside = share(draws.iter().map(Vec::len).sum());
        assert!((2.0 - inside - outside).abs() < 0.015, "{inside} {outside}");
    }

    #[test]
    fn more_subjects_than_cells_fill_them() {
        let two = Number { number: 2, rest_nats: f64::NEG_INFINITY };
        let nats = [-1.0, f64::NEG_INFINITY];
        assert_eq!(posterior(&nats, two), (vec![1.0, 0.0], 0.0));
        assert!((of_some(&nats, two, &[], &[true; 2]).1 - 1.0).abs() < 1e-12);
    }
}
