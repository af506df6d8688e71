//! Table II: the areas under the curves of Figure 7.

use dragnet_learn::policy::{PolicyName, Shipped};

use super::curves;
use super::map::Map;
use super::markup::{Markup, Table};
use super::measure;
use super::part::Part;
use super::published::{Areas, BEST_DROP_POINTS, TABLE_2};
use super::section::{Claim, Section, Verdict, below_zero};
use super::study::{BASELINES, Comparison, Panel};
use crate::ExperimentError;
use crate::comparison::{Estimate, Row, estimate};

const AT: PolicyName = PolicyName::Learned(Shipped::GreedyAllTraversable);

pub(super) fn section(comparison: &Comparison) -> Result<Section, ExperimentError> {
    let body = Markup::new()
        .paragraph(
            "The paper's budget and sensor are not known, so that areas compare within a column and not between paper and \
             program: the differences to the expert do. What the paper's text calls percent are points of its table.",
        )
        .table(&areas(comparison))
        .table(&curves::against_expert(comparison))
        .table(&curves::full_recall(comparison))
        .table(&curves::gap_closed(comparison));
    Ok(Section {
        part: Part::Table2,
        title: "Area under F1 with fewer objects",
        body,
        claims: vec![own_maps(comparison), best_clone(comparison)],
        files: curves::tables(comparison, Part::Table2)?,
    })
}

/// One policy on all maps.
fn rows(comparison: &Comparison, policy: PolicyName) -> Vec<&Row> {
    comparison.panels().map(|panel| panel.row(policy)).collect()
}

/// Its areas and their mean, in the order of the table's columns.
fn measured(rows: &[&Row]) -> Vec<Estimate> {
    rows.iter().map(|row| row.auc_f1).chain([measure::mean_area(rows)]).collect()
}

fn areas(comparison: &Comparison) -> Table {
    let mut table = Table::of_numbers(
        "Area under F1 on maps of 30 x 30 cells, 1 % of them with an object; clones were trained at 20 %. Against the \
         expert: the relative difference of the area to the expert's in the same column.",
        &["", "ICC", "OA", "Four", "AT", "Mean"],
    );
    let expert = measured(&rows(comparison, comparison.study.expert()));
    for paper in TABLE_2 {
        table.group(&title(paper.policy));
        let here = measured(&rows(comparison, paper.policy));
        table.row(line("here", here.iter().map(|area| estimate(Some(area.mean), area.sem, 4))));
        table.row(line("paper", printed(&paper).iter().map(|area| format!("{area:.4}"))));
        if paper.policy != comparison.study.expert() {
            table.row(line("here, against the expert", relative(&here, &expert)));
            table.row(line("paper, against the expert", relative_printed(&paper)));
        }
    }
    for policy in BASELINES {
        table.group(&format!("`{policy}` (not in the paper's table)"));
        let here = measured(&rows(comparison, policy));
        table.row(line("here", here.iter().map(|area| estimate(Some(area.mean), area.sem, 4))));
        table.row(line("here, against the expert", relative(&here, &expert)));
    }
    table
}

fn title(policy: PolicyName) -> String {
    let clone = curves::greedy_clones().into_iter().find(|&(_, clone)| clone == policy);
    clone.map_or_else(
        || format!("Expert (Greedy-EIG): `{policy}`"),
        |(map, _)| format!("GNN (Greedy-EIG; {}): `{policy}`", map.short()),
    )
}

fn line(name: &str, cells: impl Iterator<Item = String>) -> Vec<String> {
    [name.to_owned()].into_iter().chain(cells).collect()
}

fn printed(paper: &Areas) -> Vec<f64> {
    paper.maps.into_iter().chain([paper.mean]).collect()
}

fn relative<'a>(areas: &'a [Estimate], expert: &'a [Estimate]) -> impl Iterator<Item = String> {
    areas.iter().zip(expert).map(|(area, expert)| percent_more(area.mean, expert.mean))
}

fn relative_printed(paper: &Areas) -> impl Iterator<Item = String> {
    printed(paper).into_iter().zip(printed(&TABLE_2[0])).map(|(area, expert)| percent_more(area, expert))
}

fn percent_more(area: f64, expert: f64) -> String {
    format!("{} %", measure::with_sign(100.0 * (area / expert - 1.0), 1))
}

/// The difference between the mean areas of two policies, percentage points; seed by seed.
fn mean_points(comparison: &Comparison, policy: PolicyName, other: PolicyName) -> Estimate {
    let (policy, other) = (rows(comparison, policy), rows(comparison, other));
    let points = |place: usize| {
        let over = |(policy, other): (&&Row, &&Row)| policy.trials[place].auc_f1 - other.trials[place].auc_f1;
        policy.iter().zip(&other).map(over).sum::<f64>() * 100.0 / policy.len() as f64
    };
    Estimate::of((0..policy[0].trials.len()).map(points))
}

fn own_maps(comparison: &Comparison) -> Claim {
    let on_own = |panel: Panel<'_>| {
        let clone = PolicyName::Learned(panel.map.greedy_clone());
        measure::area_points(panel.row(clone), panel.expert())
    };
    let margins = comparison.panels().map(|panel| match panel.map {
        Map::IceCreamCone | Map::AllTraversable => on_own(panel),
        Map::OpenAsterisk | Map::FigureFour => below_zero(on_own(panel)),
    });
    Claim {
        part: Part::Table2,
        paper: "On their own maps the clones of ICC and AT exceed their expert (by 0.5 and 1.5 %), those of OA and Four fall \
                behind it (by 2 and 3 %).",
        here: format!(
            "On their own maps, in points against the expert: {}.",
            curves::by_map(comparison, |panel| measure::signed(on_own(panel), 2))
        ),
        verdict: Verdict::of(&margins.collect::<Vec<_>>()),
    }
}

fn best_clone(comparison: &Comparison) -> Claim {
    let expert = comparison.study.expert();
    let clones = curves::greedy_clones();
    let texts = clones.map(|(map, clone)| {
        format!("{} {}", map.short(), measure::signed(mean_points(comparison, clone, expert), 2))
    });
    let others = clones.iter().filter(|&&(_, clone)| clone != AT);
    let mut margins: Vec<Estimate> = others.map(|&(_, clone)| mean_points(comparison, AT, clone)).collect();
    let drop = mean_points(comparison, AT, expert);
    margins.push(Estimate { mean: drop.mean + BEST_DROP_POINTS, ..drop });
    Claim {
        part: Part::Table2,
        paper: "The clone of the all-traversable map generalizes best, with an average drop of less than 1 %; the others \
                drop by 2 to 3 %.",
        here: format!(
            "Mean over the maps, in points against the expert, by the map of training: {}.",
            texts.join(", ")
        ),
        verdict: Verdict::of(&margins),
    }
}

/// A claim about Figure 7, whose curves have these areas.
pub(super) fn tracking(comparison: &Comparison) -> Claim {
    let expert = comparison.study.expert();
    let points = curves::greedy_clones().map(|(_, clone)| mean_points(comparison, clone, expert));
    let worst = points.iter().map(|points| points.mean).fold(f64::INFINITY, f64::min);
    let of_paper = TABLE_2.iter().map(|row| 100.0 * (row.mean - TABLE_2[0].mean)).fold(0.0, f64::min);
    Claim {
        part: Part::Figure7,
        paper: "Trained at a density of 20 %, all clones closely track their expert at 1 %.",
        here: format!(
            "The mean area of the worst clone is {} points from the expert's; the paper's worst is {}, which we take as the \
             bound.",
            measure::with_sign(worst, 2),
            measure::with_sign(of_paper, 2)
        ),
        verdict: Verdict::of(&points.map(|points| Estimate { mean: points.mean - of_paper, ..points })),
    }
}
