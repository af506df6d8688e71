//! Figure 9: the path-integral expert and its clones.

use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_search::policy::PolicyName as Exact;

use super::curves;
use super::map::Map;
use super::markup::Markup;
use super::measure::{self, MATCHING_SHARE};
use super::part::Part;
use super::published::TRACKING_POINTS;
use super::section::{Claim, Section, Verdict, below_zero, within};
use super::study::{Comparison, Panel};
use crate::ExperimentError;
use crate::comparison::Estimate;

const GREEDY: PolicyName = PolicyName::Exact(Exact::Greedy);
const CLONE: PolicyName = PolicyName::Learned(Shipped::PathIceCreamCone);
const GENERAL: PolicyName = PolicyName::Learned(Shipped::General);

pub(super) fn section(comparison: &Comparison) -> Result<Section, ExperimentError> {
    let caption = "F1 against path length, mean and standard error (shaded), 20 % of the cells hold an object. `gnn-path` \
                   was trained on the ice cream cone alone and meets the other maps for the first time; `gnn` was trained \
                   on generated maps, none of which is among these four.";
    let drawn = curves::figure(comparison, Part::Figure9, caption)?;
    let body = Markup::new()
        .paragraph(
            "The paper: the path-integral clone, trained on the ice cream cone, shows marked improvement over the greedy \
             expert and almost matches its own expert on ICC and OA; it just tracks the greedy expert on the figure four \
             and is worse than it on AT. It prints curves and no numbers. `gnn` is not in the paper.",
        )
        .then(&drawn.figure)
        .table(&curves::table(comparison));
    Ok(Section {
        part: Part::Figure9,
        title: "The path-integral expert and its clones",
        body,
        claims: vec![
            expert_leads(comparison),
            clone_leads(comparison),
            clone_lags(comparison),
            general(comparison),
        ],
        files: curves::files(comparison, Part::Figure9, drawn.files)?,
    })
}

/// The difference of a policy's area to that of `greedy`, percentage points.
fn over_greedy(panel: Panel<'_>, policy: PolicyName) -> Estimate {
    measure::area_points(panel.row(policy), panel.row(GREEDY))
}

fn on(comparison: &Comparison, maps: [Map; 2]) -> impl Iterator<Item = Panel<'_>> {
    comparison.panels().filter(move |panel| maps.contains(&panel.map))
}

fn expert_leads(comparison: &Comparison) -> Claim {
    let lead = |panel: Panel<'_>| measure::area_points(panel.expert(), panel.row(GREEDY));
    let saved = |panel: Panel<'_>| {
        let way = |policy| panel.row(policy).cells_to_full_recall.mean;
        let cells = way(GREEDY).zip(way(PolicyName::Exact(Exact::Path)));
        cells.map_or_else(|| "-".to_owned(), |(greedy, path)| format!("{path:.0} and {greedy:.0}"))
    };
    Claim {
        part: Part::Figure9,
        paper: "The path-integral expert searches better than the greedy one.",
        here: format!(
            "Its area under F1 is above greedy's by these points: {}. Cells to full recall, path and greedy: {}.",
            curves::by_map(comparison, |panel| measure::signed(lead(panel), 2)),
            curves::by_map(comparison, saved)
        ),
        verdict: Verdict::of(&comparison.panels().map(lead).collect::<Vec<_>>()),
    }
}

fn clone_leads(comparison: &Comparison) -> Claim {
    let maps = [Map::IceCreamCone, Map::OpenAsterisk];
    let share = |panel: Panel<'_>| measure::share_closed(panel.row(CLONE), panel.random(), panel.expert());
    let matching = |panel: Panel<'_>| measure::matching(panel.row(CLONE), panel.random(), panel.expert());
    let margins =
        on(comparison, maps).flat_map(|panel| [Some(over_greedy(panel, CLONE)), matching(panel)]).flatten();
    let texts = on(comparison, maps).map(|panel| {
        let (points, share) = (measure::signed(over_greedy(panel, CLONE), 2), measure::percent(share(panel)));
        format!("{} {points} points against greedy, {share} of the gap closed", panel.map.short())
    });
    Claim {
        part: Part::Figure9,
        paper: "On ICC and OA the clone of the path-integral expert is better than the greedy expert and almost matches its \
                own.",
        here: format!(
            "Area under F1: {}. We call it matching from {:.0} % of the gap between random and expert on.",
            texts.collect::<Vec<_>>().join("; "),
            100.0 * MATCHING_SHARE
        ),
        verdict: Verdict::of(&margins.collect::<Vec<_>>()),
    }
}

fn clone_lags(comparison: &Comparison) -> Claim {
    let margin = |panel: Panel<'_>| match panel.map {
        Map::AllTraversable => below_zero(over_greedy(panel, CLONE)),
        _ => within(TRACKING_POINTS, over_greedy(panel, CLONE)),
    };
    let maps = [Map::FigureFour, Map::AllTraversable];
    let texts = on(comparison, maps)
        .map(|panel| format!("{} {}", panel.map.short(), measure::signed(over_greedy(panel, CLONE), 2)));
    Claim {
        part: Part::Figure9,
        paper: "On the figure four it only tracks the greedy expert, and on AT it is worse.",
        here: format!("Area under F1 against greedy's, in points: {}.", texts.collect::<Vec<_>>().join(", ")),
        verdict: Verdict::of(&on(comparison, maps).map(margin).collect::<Vec<_>>()),
    }
}

fn general(comparison: &Comparison) -> Claim {
    let points = |panel: Panel<'_>| over_greedy(panel, GENERAL);
    Claim {
        part: Part::Figure9,
        paper: "A clone may generalize to all maps with more parameters and data (a conjecture).",
        here: format!(
            "`gnn`, trained on generated maps, against greedy, in points of area under F1: {}.",
            curves::by_map(comparison, |panel| measure::signed(points(panel), 2))
        ),
        verdict: Verdict::of(&comparison.panels().map(points).collect::<Vec<_>>()),
    }
}
