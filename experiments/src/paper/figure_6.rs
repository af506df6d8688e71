//! Figure 6: clones on larger maps than in training.

use super::curves;
use super::markup::Markup;
use super::measure::{self, MATCHING_SHARE};
use super::part::Part;
use super::published::TRACKING_POINTS;
use super::section::{Claim, Section, Verdict};
use super::study::Comparison;
use crate::ExperimentError;
use crate::comparison::Estimate;

pub(super) fn section(comparison: &Comparison) -> Result<Section, ExperimentError> {
    let caption = "F1 against path length on maps of 60 x 60 cells, mean and standard error (shaded), 20 % of the cells \
                   hold an object. All clones were trained on maps of 30 x 30 cells.";
    let drawn = curves::figure(comparison, Part::Figure6, caption)?;
    let body = Markup::new()
        .paragraph(
            "The paper: policies that were trained on the 30 x 30 variant of one map track their expert nearly perfectly \
             on the 60 x 60 variants of all. It prints curves and no numbers.",
        )
        .then(&drawn.figure)
        .table(&curves::against_expert(comparison))
        .table(&curves::table(comparison));
    Ok(Section {
        part: Part::Figure6,
        title: "Across maps and sizes",
        body,
        claims: vec![tracking(comparison)],
        files: curves::files(comparison, Part::Figure6, drawn.files)?,
    })
}

fn tracking(comparison: &Comparison) -> Claim {
    let pairs = curves::greedy_clones().into_iter().flat_map(|(_, clone)| {
        comparison.panels().map(move |panel| (panel.row(clone), panel.random(), panel.expert()))
    });
    let points = pairs.clone().map(|(clone, _, expert)| measure::area_points(clone, expert));
    let shares =
        pairs.clone().filter_map(|(clone, random, expert)| measure::share_closed(clone, random, expert));
    let (least, most) = range(points.clone().map(|points| points.mean));
    let (least_share, max_share) = range(shares.map(|share| 100.0 * share.mean));
    let matching = pairs.filter_map(|(clone, random, expert)| measure::matching(clone, random, expert));
    let margins =
        points.map(|points| Estimate { mean: points.mean + TRACKING_POINTS, ..points }).chain(matching);
    Claim {
        part: Part::Figure6,
        paper: "Trained on one map of 30 x 30 cells, the clones track their expert nearly perfectly on all four of 60 x 60.",
        here: format!(
            "Area under F1 against the expert's, the 16 pairs of clone and map: {} to {} points; of the gap between random \
             and expert they close {least_share:.0} to {max_share:.0} %. We call it tracking if no pair is more than \
             {TRACKING_POINTS} points behind or closes less than {:.0} %.",
            measure::with_sign(least, 2),
            measure::with_sign(most, 2),
            100.0 * MATCHING_SHARE
        ),
        verdict: Verdict::of(&margins.collect::<Vec<_>>()),
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)))
}
