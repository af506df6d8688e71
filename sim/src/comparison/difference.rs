//! Differences between two policies on the same seeds.

use dragnet_search::seed::{Purpose, stream};
use rand::RngExt;
use serde::Serialize;

use super::trial::restricted;
use super::{Row, Trial};

/// Resamples of a bootstrap: enough that the ends of an interval move by a hundredth of its length.
const RESAMPLES: usize = 10_000;
/// Share of the resamples beyond each end of an interval.
const TAIL: f64 = 0.025;

/// The differences of one policy to the baseline, on one scenario. Names are those of the JSON object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the scenario.
    pub scenario: String,
    /// Label of the policy.
    pub policy: String,
    /// Label of the policy that it is compared with.
    pub baseline: String,
    /// Path length of the farthest robot until every object was found, cells; that of a miss is the budget.
    pub cells_to_full_recall: Interval,
    /// Mean of recall over path lengths up to the budget.
    pub average_recall: Interval,
    /// Mean of F1 over path lengths up to the budget.
    pub auc_f1: Interval,
}

/// The mean of paired differences, policy less baseline, and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Mean over the seeds.
    pub mean: f64,
    /// Lower end; unknown from one seed.
    pub low: Option<f64>,
    /// Upper end; unknown from one seed.
    pub high: Option<f64>,
    /// The policy compared with the baseline; unknown where the interval holds 0.
    pub verdict: Option<Verdict>,
}

/// How a policy compares with its baseline, beyond a 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It needs fewer cells, or finds more.
    Better,
    /// It needs more cells, or finds less.
    Worse,
}

/// The label of the policy that the others are compared with: the wanted one, or else the first.
///
/// # Errors
/// If it is not one of the policies: the allowed labels.
pub fn baseline<'a>(
    policies: impl Iterator<Item = &'a str>,
    wanted: Option<&str>,
) -> Result<&'a str, String> {
    let mut labels = Vec::new();
    for policy in policies {
        if wanted.is_none_or(|wanted| wanted == policy) {
            return Ok(policy);
        }
        if !labels.contains(&policy) {
            labels.push(policy);
        }
    }
    Err(format!("allowed are {}", labels.join(", ")))
}

/// Every other policy of a scenario compared with this one.
#[must_use]
pub fn differences(rows: &[Row], baseline: &str) -> Vec<Difference> {
    let scenarios = rows.chunk_by(|a, b| a.scenario == b.scenario);
    let of_scenario = |rows: &[Row]| -> Vec<Difference> {
        let Some(baseline) = rows.iter().find(|row| row.policy == baseline) else { return Vec::new() };
        let others = rows.iter().filter(|row| row.policy != baseline.policy);
        others.map(|row| Difference::new(row, baseline)).collect()
    };
    scenarios.flat_map(of_scenario).collect()
}

impl Verdict {
    /// As tables and JSON have it.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Worse => "worse",
        }
    }
}

impl Difference {
    /// Compares two policies on the same scenario and seeds.
    #[must_use]
    pub fn new(row: &Row, baseline: &Row) -> Self {
        debug_assert!(row.trials.iter().map(|it| it.seed).eq(baseline.trials.iter().map(|it| it.seed)));
        let paired = |of: &dyn Fn(&Row, &Trial) -> f64| -> Vec<f64> {
            let pairs = row.trials.iter().zip(&baseline.trials);
            pairs.map(|(ours, theirs)| of(row, ours) - of(baseline, theirs)).collect()
        };
        let cells = paired(&|row, trial| restricted(trial.cells_to_full_recall, row.budget_cells));
        Self {
            scenario: row.scenario.clone(),
            policy: row.policy.clone(),
            baseline: baseline.policy.clone(),
            cells_to_full_recall: Interval::of(&cells, Verdict::Worse),
            average_recall: Interval::of(&paired(&|_, trial| trial.average_recall), Verdict::Better),
            auc_f1: Interval::of(&paired(&|_, trial| trial.auc_f1), Verdict::Better),
        }
    }
}

impl Interval {
    /// The interval of at least one difference, by the percentile bootstrap (Efron and Tibshirani 1993, section 13.3):
    /// means of samples that are drawn from the differences with replacement, always by the same draws. A positive mean
    /// is `above`.
    fn of(differences: &[f64], above: Verdict) -> Self {
        let mean = mean(differences.iter().copied(), differences.len());
        let count = u32::try_from(differences.len()).unwrap_or(u32::MAX);
        if count < 2 {
            return Self { mean, low: None, high: None, verdict: None };
        }
        let mut random = stream(0, Purpose::Bootstrap, 0);
        let mut draw = |_| differences[random.random_range(0..count) as usize];
        let mut means: Vec<f64> =
            (0..RESAMPLES).map(|_| self::mean((0..count).map(&mut draw), differences.len())).collect();
        means.sort_unstable_by(f64::total_cmp);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of the resamples"
        )]
        let beyond = (TAIL * RESAMPLES as f64) as usize;
        let (low, high) = (means[beyond], means[RESAMPLES - 1 - beyond]);
        let below = if above == Verdict::Better { Verdict::Worse } else { Verdict::Better };
        let verdict = if low > 0.0 { Some(above) } else { (high < 0.0).then_some(below) };
        Self { mean, low: Some(low), high: Some(high), verdict }
    }
}

fn mean(values: impl Iterator<Item = f64>, count: usize) -> f64 {
    values.sum::<f64>() / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_of_normal_differences_is_that_of_the_normal_distribution() {
        // The quantiles of a normal distribution of mean 3 and deviation 2: -1.96 and 1.96 deviations are 95 %.
        let mut random = stream(1, Purpose::Noise, 1);
        let normal = rand_distr::Normal::new(3.0, 2.0).unwrap();
        let differences: Vec<f64> =
            (0..400).map(|_| rand_distr::Distribution::sample(&normal, &mut random)).collect();
        let interval = Interval::of(&differences, Verdict::Better);
        let sem = super::super::Estimate::of(differences.iter().copied()).sem.unwrap();
        assert!((interval.low.unwrap() - (interval.mean - 1.96 * sem)).abs() < 0.1 * sem, "{interval:?}");
        assert!((interval.high.unwrap() - (interval.mean + 1.96 * sem)).abs() < 0.1 * sem, "{interval:?}");
        assert_eq!(interval.verdict, Some(Verdict::Better));
        assert_eq!(Interval::of(&differences, Verdict::Worse).verdict, Some(Verdict::Worse));
        assert_eq!(interval, Interval::of(&differences, Verdict::Better), "the draws are always the same");
    }

    #[test]
    fn what_may_be_chance_gets_no_verdict() {
        let interval = Interval::of(&[-2.0, 1.0, -1.0, 2.5, -0.5], Verdict::Better);
        assert!(interval.low.unwrap() < 0.0 && interval.high.unwrap() > 0.0 && interval.verdict.is_none());
        let one = Interval::of(&[7.0], Verdict::Better);
        assert_eq!(one, Interval { mean: 7.0, low: None, high: None, verdict: None });
        let equal = Interval::of(&[0.0; 9], Verdict::Better);
        assert_eq!((equal.low, equal.high, equal.verdict), (Some(0.0), Some(0.0), None));
    }
}
