//! The contents of a part of the report: text, claims of the paper with measurements, and files.

use std::fmt;

use super::markup::Markup;
use super::part::Part;
use crate::comparison::Estimate;

/// A part of the report.
pub(super) struct Section {
    pub(super) part: Part,
    pub(super) title: &'static str,
    pub(super) body: Markup,
    pub(super) claims: Vec<Claim>,
    pub(super) files: Vec<File>,
}

/// Numbers or a drawing, in a file beside the page.
pub(super) struct File {
    pub(super) name: String,
    pub(super) content: Vec<u8>,
}

/// A claim of the paper, and the measurement here.
pub(super) struct Claim {
    pub(super) part: Part,
    pub(super) paper: &'static str,
    pub(super) here: String,
    pub(super) verdict: Verdict,
}

/// Whether a claim of the paper is true of the means measured here, and whether chance could change that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Holds,
    /// It holds, by less than two standard errors.
    HoldsBarely,
    /// It does not, by less than two standard errors.
    FailsBarely,
    Fails,
}

impl Verdict {
    /// The verdict on a claim with several margins: it holds if none of them is below 0. One without a standard error
    /// is of one seed, which proves nothing.
    pub(super) fn of(margins: &[Estimate]) -> Self {
        let sem = |margin: &Estimate| margin.sem.unwrap_or(f64::INFINITY);
        if margins.iter().all(|margin| margin.mean >= 0.0) {
            let is_clear = margins.iter().all(|margin| margin.mean >= 2.0 * sem(margin));
            return if is_clear { Self::Holds } else { Self::HoldsBarely };
        }
        let is_clear = margins.iter().any(|margin| margin.mean < -2.0 * sem(margin));
        if is_clear { Self::Fails } else { Self::FailsBarely }
    }

    pub(super) const fn holds(self) -> bool {
        matches!(self, Self::Holds | Self::HoldsBarely)
    }
}

/// A margin without randomness.
pub(super) const fn certain(mean: f64) -> Estimate {
    Estimate { mean, sem: Some(0.0) }
}

/// By how much the absolute value of a measure is below a bound.
pub(super) fn within(bound: f64, measure: Estimate) -> Estimate {
    Estimate { mean: bound - measure.mean.abs(), ..measure }
}

/// By how much a measure is below 0.
pub(super) fn below_zero(measure: Estimate) -> Estimate {
    Estimate { mean: -measure.mean, ..measure }
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Holds => "\u{2713} holds",
            Self::HoldsBarely => "\u{2713} holds in the mean, but chance could explain it",
            Self::FailsBarely => "\u{2717} does not hold in the mean, but chance could explain it",
            Self::Fails => "\u{2717} does not hold",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_holds_if_no_margin_is_below_zero_and_clearly_so_beyond_two_errors() {
        let margin = |mean, sem| Estimate { mean, sem: Some(sem) };
        for (margins, expected) in [
            (vec![margin(3.0, 1.0), certain(0.0)], Verdict::Holds),
            (vec![margin(3.0, 1.0), margin(1.0, 0.6)], Verdict::HoldsBarely),
            (vec![margin(3.0, 1.0), margin(-1.0, 0.6)], Verdict::FailsBarely),
            (vec![margin(3.0, 1.0), margin(-1.0, 0.4)], Verdict::Fails),
            (vec![Estimate { mean: 9.0, sem: None }], Verdict::HoldsBarely),
            (vec![Estimate { mean: -9.0, sem: None }], Verdict::FailsBarely),
        ] {
            assert_eq!(Verdict::of(&margins), expected, "{margins:?}");
        }
        assert_eq!(within(1.5, margin(-2.0, 0.1)), margin(-0.5, 0.1));
    }
}
