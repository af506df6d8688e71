//! Beyond the paper: policies that plan the whole rest of the search, how far they are from the best, what a network
//! makes of them, and teams.

use dragnet_learn::policy::Shipped;
use dragnet_scenario::Scenario;
use dragnet_scenario::file::PolicyField;

use super::curves::{self, Curves};
use super::map::{Map, Size};
use super::markup::{Markup, Table};
use super::part::Part;
use super::section::Section;
use crate::ExperimentError;
use crate::comparison::{Case, Experiment, Row, estimate, files};
use crate::plot::LineStyle;
use crate::progress::Progress;
use crate::seeds::Seeds;
use crate::shard::Shard;

/// The policies: the paper's expert as it is and with the weight of path length that suits it best, the tour, and a
/// clone of each expert.
const POLICIES: [&str; 5] =
    ["path", "path(path_length_weight=1)", "tour", Shipped::General.as_str(), Shipped::Tour.as_str()];
const TEAM_POLICIES: [&str; 2] = ["path", "tour"];
/// One color each: at most five lines, and no two that differ in their dashes alone.
const LINE_STYLES: [LineStyle; 5] = [
    LineStyle { color: 4, dashes: 0 },
    LineStyle { color: 1, dashes: 2 },
    LineStyle { color: 6, dashes: 0 },
    LineStyle { color: 2, dashes: 1 },
    LineStyle { color: 7, dashes: 3 },
];

/// Share of the cells that hold an object, few and many.
const DENSITIES: [f64; 2] = [0.01, 0.2];
/// A search that has not found everything after this path length counts as it, cells.
const BUDGET_CELLS: u32 = 300;
const TEAM: u32 = 8;
const TEAM_BUDGET_CELLS: u32 = 400;

/// The rows of one density, by map, then by policy.
struct Density {
    share: f64,
    rows: Vec<Row>,
    /// By map, where it was computed.
    bounds: Vec<(String, f64)>,
}

pub(super) fn section(
    seeds: Seeds,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Section, ExperimentError> {
    let [few, many] = DENSITIES;
    let few = Density::run(few, true, seeds, threads, progress)?;
    let many = Density::run(many, false, seeds, threads, progress)?;
    let team = team(seeds).and_then(|experiment| rows(&experiment, threads, progress))?;
    let drawn = few.curves(seeds)?;
    let body = Markup::new()
        .paragraph(
            "`path` is exact and looks one path ahead. `tour` plans the whole rest of the search, keeps its plan and improves it \
             under each new belief. `gnn` is trained on `path`, `gnn-tour` on what `tour` expects the rest of the search to \
             cost from each cell on: both decide by one pass of a network, on maps that they were not trained on.",
        )
        .table(&lengths(&few, &many))
        .then(&drawn.figure)
        .table(&amortized(&few, &many))
        .table(&of_team(&team));
    let mut files = vec![
        curves::file(Part::Beyond, "summary-few", files::summary(&few.rows))?,
        curves::file(Part::Beyond, "summary-many", files::summary(&many.rows))?,
        curves::file(Part::Beyond, "summary-team", files::summary(&team))?,
        curves::file(Part::Beyond, "curves", files::curves(&few.rows))?,
    ];
    files.extend(drawn.files);
    Ok(Section {
        part: Part::Beyond,
        title: "planning the whole rest of the search",
        body,
        claims: Vec::new(),
        files,
    })
}

fn case(scenario: &Scenario, policy: &str) -> Result<Case, ExperimentError> {
    let field: PolicyField = policy.parse().map_err(ExperimentError::run)?;
    Ok(Case::new(scenario.with_policy(field).map_err(ExperimentError::run)?, policy))
}

fn rows(
    experiment: &Experiment,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Vec<Row>, ExperimentError> {
    Ok(experiment.design().rows(experiment.run(Shard::WHOLE, threads, progress)?.results))
}

/// Eight robots that start in one cell of the open map.
fn team(seeds: Seeds) -> Result<Experiment, ExperimentError> {
    let scenario = Map::AllTraversable
        .scenario(Size::Sixty)?
        .with_density(DENSITIES[0])
        .and_then(|scenario| scenario.with_robots(TEAM))
        .and_then(|scenario| scenario.with_budget_cells(TEAM_BUDGET_CELLS))
        .map_err(ExperimentError::run)?;
    let cases = TEAM_POLICIES.map(|policy| case(&scenario, policy)).into_iter().collect::<Result<_, _>>()?;
    Ok(Experiment { cases, seeds })
}

impl Density {
    fn run(
        share: f64,
        is_bounded: bool,
        seeds: Seeds,
        threads: Option<u16>,
        progress: &dyn Progress,
    ) -> Result<Self, ExperimentError> {
        let mut cases = Vec::new();
        for map in Map::ALL {
            let scenario = map.scenario(Size::Thirty)?.with_density(share);
            let scenario =
                scenario.and_then(|it| it.with_budget_cells(BUDGET_CELLS)).map_err(ExperimentError::run)?;
            for policy in POLICIES {
                cases.push(case(&scenario, policy)?);
            }
        }
        let experiment = Experiment { cases, seeds };
        let bounds = if is_bounded { experiment.bounds(threads, progress)? } else { Vec::new() };
        Ok(Self { share, rows: rows(&experiment, threads, progress)?, bounds })
    }

    /// The rows of each map, in the order of [`Map::ALL`].
    fn maps(&self) -> impl Iterator<Item = &[Row]> {
        self.rows.chunks(POLICIES.len())
    }

    /// The rows of a policy, by map.
    fn of(&self, place: usize) -> impl Iterator<Item = &Row> {
        self.maps().map(move |rows| &rows[place])
    }

    fn curves(&self, seeds: Seeds) -> Result<Curves, ExperimentError> {
        let caption = format!(
            "F1 against path length, mean and standard error (shaded), an object in {} % of the cells.",
            self.share * 100.0
        );
        let figures = Map::ALL.into_iter().zip(self.maps()).map(|(map, rows)| {
            let mut figure = files::figure(rows, seeds);
            for (line, style) in figure.lines.iter_mut().zip(LINE_STYLES) {
                line.line_style = style;
            }
            (map, figure)
        });
        curves::drawn(Part::Beyond, &caption, figures)
    }
}

/// Path lengths to full recall by map and density, and how far above the bound.
fn lengths(few: &Density, many: &Density) -> Table {
    let maps = Map::ALL.map(Map::short);
    let titles: Vec<&str> = ["policy"].into_iter().chain(maps).collect();
    let mut table = Table::of_numbers(
        &format!(
            "Cells to full recall on maps of 30 x 30 cells, one robot: the mean over all seeds, a search that has not \
             found everything after {BUDGET_CELLS} cells counting as those, with its standard error. The bound is proven: \
             no policy needs fewer cells in the mean; the mean of few seeds may be below it by chance. Percent say how \
             far a policy is above it."
        ),
        &titles,
    );
    for density in [few, many] {
        table.group(&format!("An object in {} % of the cells", density.share * 100.0));
        for (place, policy) in POLICIES.into_iter().enumerate() {
            let mut cells = vec![format!("`{policy}`")];
            cells.extend(density.of(place).enumerate().map(|(map, row)| length(density, map, row)));
            table.row(cells);
        }
        if !density.bounds.is_empty() {
            let bounds = density.bounds.iter().map(|(_, cells)| format!("{cells:.1}"));
            table.row(["no policy needs fewer than".to_owned()].into_iter().chain(bounds).collect());
        }
    }
    table
}

fn length(density: &Density, map: usize, row: &Row) -> String {
    let full = &row.cells_to_full_recall;
    let cells = estimate(Some(full.restricted_mean), full.restricted_sem, 1);
    match density.bounds.get(map) {
        Some((_, bound)) => format!("{cells} (+{:.0} %)", 100.0 * (full.restricted_mean / bound - 1.0)),
        None => cells,
    }
}

/// What a network saves in time and loses in length against its expert.
fn amortized(few: &Density, many: &Density) -> Table {
    let mut table = Table::of_numbers(
        "What amortization buys: length and computing time side by side. Lengths are relative to `path` with the same \
         weight 0.2 as in the paper, of the sums over the four maps; times are medians and 99th percentiles of one core over \
         the decisions of the ice cream cone.",
        &["policy", "length, few objects", "length, many", "median ms", "99 % ms"],
    );
    for (place, policy) in POLICIES.into_iter().enumerate() {
        let relative = |density: &Density| {
            let sum =
                |place| density.of(place).map(|row| row.cells_to_full_recall.restricted_mean).sum::<f64>();
            format!("{:.2}", sum(place) / sum(0))
        };
        let times = few.of(place).next().map(|row| [row.decision_ms.p50, row.decision_ms.p99]);
        let [median, most] = times.unwrap_or_default().map(|time| estimate(time, None, 2));
        table.row(vec![format!("`{policy}`"), relative(few), relative(many), median, most]);
    }
    table
}

fn of_team(rows: &[Row]) -> Table {
    let mut table = Table::of_numbers(
        &format!(
            "A team of {TEAM} on the open map of 60 x 60 cells, 1 % of them with an object, all robots starting in one cell: \
             path length of the farthest robot until every object is found, cells."
        ),
        &["policy", "full recall", "reached by", "50 %", "80 %", "95 %"],
    );
    for row in rows {
        let full = &row.cells_to_full_recall;
        let part = |place: usize| estimate(Some(row.cells_to_recall[place].restricted_mean), None, 1);
        table.row(vec![
            format!("`{}`", row.policy),
            estimate(Some(full.restricted_mean), full.restricted_sem, 1),
            format!("{} of {}", full.reached, row.seeds),
            part(0),
            part(1),
            part(2),
        ]);
    }
    table
}
