//! Figure 5: clones compared with their experts.

use dragnet_learn::policy::PolicyName;
use dragnet_search::policy::PolicyName as Exact;

use super::curves;
use super::markup::Markup;
use super::measure::{self, Gap};
use super::part::Part;
use super::published::{PARTING_F1, TRACKING_POINTS};
use super::section::{Claim, Section, Verdict, certain, within};
use super::study::{Comparison, Panel};
use crate::ExperimentError;
use crate::comparison::Row;

const RANDOM: PolicyName = PolicyName::Exact(Exact::Random);
const COVERAGE: PolicyName = PolicyName::Exact(Exact::Coverage);

/// Relative difference in path length to `greedy` up to which `random` counts as equally fast.
const ABOUT_THE_SAME: f64 = 0.25;

pub(super) fn section(comparison: &Comparison) -> Result<Section, ExperimentError> {
    let caption = "F1 against path length, mean and standard error (shaded), 20 % of the cells hold an object. The \
                   clone of each map is the one that was trained on it.";
    let drawn = curves::figure(comparison, Part::Figure5, caption)?;
    let body = Markup::new()
        .paragraph(
            "The paper: clones of the greedy expert attain an F-score within 1.5 % of the expert at each timestep on all \
             four maps; coverage is the most budget-inefficient baseline; random search does well at the start and \
             saturates. It prints curves and no numbers.",
        )
        .then(&drawn.figure)
        .paragraph(&largest(comparison))
        .table(&curves::table(comparison));
    Ok(Section {
        part: Part::Figure5,
        title: "Imitating the greedy expert",
        body,
        claims: vec![tracking(comparison), inefficient_coverage(comparison), parting(comparison)],
        files: curves::files(comparison, Part::Figure5, drawn.files)?,
    })
}

fn gap(panel: Panel<'_>) -> Gap {
    let clone = PolicyName::Learned(panel.map.greedy_clone());
    measure::largest_difference(panel.row(clone), panel.expert())
}

/// The largest difference between clone and expert.
fn largest(comparison: &Comparison) -> String {
    format!(
        "The mean F1 of the clone is farthest from that of its expert by these points of a hundred, after so many \
         cells: {}. The paper's bound is {TRACKING_POINTS} points. Two policies of equal worth that part ways once \
         differ at some length by chance: the standard error there tells how much of it that may be.",
        curves::by_map(comparison, |panel| gap(panel).to_string())
    )
}

fn tracking(comparison: &Comparison) -> Claim {
    let margins = comparison.panels().map(|panel| within(TRACKING_POINTS, gap(panel).points));
    Claim {
        part: Part::Figure5,
        paper: "The F1 of the clones stays within 1.5 % of the expert's at each timestep, on all four maps.",
        here: format!(
            "Farthest apart, in points, after so many cells: {}.",
            curves::by_map(comparison, |panel| gap(panel).to_string())
        ),
        verdict: Verdict::of(&margins.collect::<Vec<_>>()),
    }
}

fn inefficient_coverage(comparison: &Comparison) -> Claim {
    let leads = comparison.panels().map(|panel| {
        let others = panel.rows.iter().filter(|row| row.policy != COVERAGE.as_str());
        others.map(|row| measure::area_points(row, panel.row(COVERAGE))).collect::<Vec<_>>()
    });
    let maps = leads.clone().filter(|leads| leads.iter().all(|lead| lead.mean >= 0.0)).count();
    Claim {
        part: Part::Figure5,
        paper: "Coverage is the most budget-inefficient baseline.",
        here: format!("It has the least area under F1 of all policies on {maps} of 4 maps."),
        verdict: Verdict::of(&leads.flatten().collect::<Vec<_>>()),
    }
}

fn parting(comparison: &Comparison) -> Claim {
    let path = |row: &Row| measure::length_to(row, PARTING_F1);
    let paths = |panel: Panel<'_>| path(panel.expert()).zip(path(panel.row(RANDOM)));
    let together = |panel: Panel<'_>| {
        let spare = |(greedy, random): (f64, f64)| ABOUT_THE_SAME * greedy - (random - greedy).abs();
        certain(paths(panel).map_or(-1.0, spare))
    };
    let lead = |panel: Panel<'_>| measure::area_points(panel.expert(), panel.row(RANDOM));
    let texts = curves::by_map(comparison, |panel| match paths(panel) {
        Some((greedy, random)) => format!("{greedy:.0} and {random:.0}"),
        None => "not reached".to_owned(),
    });
    let leads = curves::by_map(comparison, |panel| measure::signed(lead(panel), 1));
    let margins = comparison.panels().flat_map(|panel| [together(panel), lead(panel)]);
    Claim {
        part: Part::Figure5,
        paper: "Random and greedy search reach an F1 of 0.6 at about the same path length; from there greedy goes on and random \
                saturates.",
        here: format!(
            "Cells to 0.6 of greedy and random: {texts} (we count up to a quarter more or less as the same). Greedy's area \
             under F1 is above random's by these points: {leads}."
        ),
        verdict: Verdict::of(&margins.collect::<Vec<_>>()),
    }
}
