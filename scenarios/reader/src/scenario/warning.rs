//! Likely mistakes in scenarios that can still be run.

use std::collections::BTreeMap;
use std::fmt;

use dragnet_search::cell::{Cell, Position};
use dragnet_search::observation::RobotId;
use dragnet_search::reach::{Reach, Sight};
use dragnet_search::sensor::{Noise, Sensor};

use crate::map_file::areas::{Areas, Purpose, Rest};

use super::{Drawn, Objects, Scenario, Start, start};

/// A likely mistake in a scenario that can still be run.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// Searched cells that no robot can observe: objects there are never found.
    Unseen {
        /// The cells, by their indices.
        cells: Vec<Cell>,
        /// Number of searched cells.
        searched: usize,
        /// Probability that an object is in one of them, given that it is in a searched cell: 0 to 1.
        probability: f64,
        /// The first one.
        first: Position,
    },
    /// Two robots start in areas that no path connects.
    Apart {
        /// The robot with the smallest number.
        robot: RobotId,
        /// The first one that it cannot reach.
        other: RobotId,
    },
    /// Drawn search areas in parts that no path connects, of which some have no robot, or for which robots are spread.
    Parts {
        /// Traversable cells of each part that a robot starts in, and how many robots do, the largest part first.
        searched: Vec<(usize, usize)>,
        /// Traversable cells of each part without a robot of which some searched cell is seen by none, the largest first.
        unsearched: Vec<usize>,
    },
    /// A search area or a no-go area without effect.
    Idle {
        /// Its kind as files name it.
        kind: &'static str,
        /// Its name.
        name: String,
        /// Whether it is meant to close cells.
        closes: bool,
    },
    /// Some of a no-go area's polygons and lines, not all, lie beyond the map.
    Beyond {
        /// Its name.
        name: String,
        /// Their number.
        beyond: usize,
        /// Their total number.
        barriers: usize,
    },
    /// The prior expects more than twice or less than half as many objects as there are, and they differ by more than one.
    Contradiction {
        /// Objects that the prior expects.
        by_prior: f64,
        /// Objects by `[objects]`, as expected.
        by_objects: f64,
    },
    /// The search ends before it begins: no more objects are expected than may remain.
    StopsAtOnce {
        /// `mission.stop_when_expected_remaining`.
        limit: f64,
        /// Objects that the prior expects in cells that robots can observe.
        expected: f64,
    },
    /// A map alone is so large that its assumed budget hardly covers it.
    ShortBudget {
        /// About as many cells as all robots together can observe within their budgets, each once.
        observed: f64,
        /// Number of searched cells that robots can observe.
        searched: usize,
    },
    /// Readings of empty cells look like those of objects at these distances, since the belief assumes Gaussian noise.
    Clipped {
        /// The nearest such distance, cells.
        distance: u32,
        /// The variance of readings there.
        variance: f32,
    },
    /// Objects in given cells that can never be found.
    NeverFound {
        /// The reason.
        reason: Reason,
        /// Their number.
        objects: usize,
        /// Number of given objects.
        given: usize,
        /// The first one.
        first: Position,
    },
    /// A start on the earth that lies in no traversable cell: robots start in the nearest one.
    MovedStart {
        /// Its name in the map, or its key.
        name: String,
        /// The cell.
        cell: Position,
        /// From the point to the cell's center, meters.
        meters: f64,
    },
    /// Search areas that share ground, which is searched once.
    Overlap {
        /// The names of the first two.
        areas: [String; 2],
        /// How many other pairs do.
        others: usize,
    },
    /// Polygons with a fault that changes next to nothing, and were read without it.
    Mended {
        /// Place and fault of each, at least one.
        faults: Vec<String>,
    },
    /// The regions leave a probability, and ground of the search area between them that is too narrow for a cell of its own.
    Gap {
        /// The probability that they leave, which lies beyond the map.
        poa: f64,
        /// The share of the search area that no region covers.
        share: f64,
    },
    /// A feature of a file that has no meaning for the search.
    LeftOut {
        /// Its name, or its position in the file.
        name: String,
    },
}

/// From this variance on clipped readings mislead the belief: of an empty cell the mean of `min(|N(0, v)|, 1)` is 0.4 at
/// `v = 0.3` and rises, and 0.5 speaks for an object as much as against it.
const CLIPPED_VARIANCE: f32 = 0.3;

/// Fewer observations of each cell complete no search. With `tour`, one to three robots and one object, five areas of 600 to
/// 3600 cells were complete after 1.4 (a square) to 3.3 (a long island); where the budget was for 1.0, two areas left a
/// fifth of the object or more.
const LOOKS_A_CELL: f64 = 1.3;

/// The most mended polygons that are told by themselves.
const MAX_FAULTS: usize = 3;

/// Shares of a probability or an area below this are those of rounded coordinates and percentages.
const LEAST_TOLD: f64 = 1e-3;

/// The most parts of an area that are told by themselves.
const MAX_PARTS: usize = 5;

/// What is done about parts of an area without robots.
const TO_SEARCH_ALL: &str =
    "with more robots, or a start drawn in each, they are searched too, or search each by itself";

/// Why an object is never found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The prior of its cell is 0, which no reading changes.
    Excluded,
    /// No robot can observe its cell.
    OutOfSight,
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.written(|Position { row, column }| format!("[{row}, {column}]")))
    }
}

impl Warning {
    /// The warning in words; `place` writes a cell.
    #[must_use]
    pub fn written(&self, place: impl Fn(Position) -> String) -> String {
        match self {
            Self::Unseen { cells, searched, probability, first } => format!(
                "{} of {searched} searched cells, with {:.1} % of the probability, are out of every robot's sight, the first \
                 one {}",
                cells.len(),
                100.0 * probability,
                place(*first)
            ),
            Self::Apart { robot, other } => {
                format!("robots {robot} and {other} start in areas that no path connects")
            }
            Self::Parts { searched, unsearched } => parts(searched, unsearched),
            Self::Idle { kind, name, closes: true } => {
                format!("{kind} {name:?} closes no cell: it lies where nothing is searched")
            }
            Self::Idle { kind, name, closes: false } => format!(
                "{kind} {name:?} covers no searched cell: a cell is searched where half of it lies inside"
            ),
            Self::Beyond { name, beyond, barriers } => format!(
                "of {barriers} polygons and lines of no_go {name:?}, {beyond} beyond the map close nothing"
            ),
            Self::Contradiction { by_prior, by_objects } => {
                format!("the prior expects {by_prior:.2} objects, and [objects] says {by_objects:.2}")
            }
            Self::StopsAtOnce { limit, expected } => format!(
                "mission.stop_when_expected_remaining is {limit}, and no more than {expected:.3} objects are expected: the search \
                 ends before it begins"
            ),
            Self::ShortBudget { observed, searched } => format!(
                "the assumed budget is short for this map: the robots can look at about {observed:.0} cells, and a complete search of \
                 {searched} cells looks at {:.0} or more, since it looks twice at some; more robots see more, and so does a \
                 scenario with a larger mission.budget_seconds",
                LOOKS_A_CELL * *searched as f64
            ),
            Self::Clipped { distance, variance } => format!(
                "sensor.noise is \"clipped\", and the belief takes readings for gaussian: with a variance of {variance} at distance \
                 {distance} more empty cells are declared than mission.detection_threshold allows; below {CLIPPED_VARIANCE} at \
                 all distances they are not"
            ),
            Self::NeverFound { reason, objects, given, first } => {
                let reason = match reason {
                    Reason::Excluded => "where the prior is 0",
                    Reason::OutOfSight => "out of every robot's sight",
                };
                format!(
                    "{objects} of {given} given objects lie {reason} and are never found, the first one {}",
                    place(*first)
                )
            }
            Self::MovedStart { name, cell, meters } => format!(
                "{name} lies in no traversable cell: robots start in the nearest one, {}, {meters:.0} m away",
                place(*cell)
            ),
            Self::Overlap { areas: [a, b], others } => {
                let others = match others {
                    0 => String::new(),
                    1 => ", and another pair".to_owned(),
                    others => format!(", and {others} other pairs"),
                };
                format!("search areas overlap, {a:?} and {b:?}{others}: what they share is searched once")
            }
            Self::Mended { faults } => {
                let listed =
                    faults.iter().take(MAX_FAULTS).map(String::as_str).collect::<Vec<_>>().join("; ");
                let polygons = match faults.len() {
                    1 => "a polygon".to_owned(),
                    number => format!("{number} polygons"),
                };
                let more = match faults.len().saturating_sub(MAX_FAULTS) {
                    0 => String::new(),
                    more => format!("; and {more} more"),
                };
                format!(
                    "mended {polygons}, since it changes less than a thousandth of the area: {listed}{more}"
                )
            }
            Self::Gap { poa, share } => format!(
                "the regions leave {:.1} % of the probability and {:.1} % of the search area, in gaps narrower than a cell: that \
                 probability is taken for beyond the map; regions that meet, or one for the rest, say where it is",
                100.0 * poa,
                100.0 * share
            ),
            Self::LeftOut { name } => {
                format!("left out: {}; kinds are {}", name.escape_debug(), Purpose::KINDS.join(", "))
            }
        }
    }
}

impl Scenario {
    /// Likely mistakes in the scenario.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        self.warnings_with(&self.drawn())
    }

    /// Like [`Scenario::warnings`], with the result of [`Scenario::drawn`].
    #[must_use]
    pub fn warnings_with(&self, drawn: &[Drawn]) -> Vec<Warning> {
        let mut reach = Reach::unknown(self.terrain().grid());
        // The first robot of each sight: robots that move alike and cannot meet are apart.
        let mut firsts: BTreeMap<Sight, RobotId> = BTreeMap::new();
        let mut apart = None;
        let connected = self.terrain().connected_areas();
        for robot in self.robots() {
            let Some(start) = some_start(&connected, robot.start) else { continue };
            let sight = robot.class.sight();
            if !reach.is_news(sight, start) {
                continue;
            }
            let first = *firsts.entry(sight).or_insert(robot.id);
            // Whoever is spread over the parts is meant to be apart.
            let is_meant = matches!(robot.start, Start::Together { area: 1.. });
            if first != robot.id && apart.is_none() && !is_meant {
                apart = Some(Warning::Apart { robot: first, other: robot.id });
            }
            reach.add_robot(self.terrain(), sight, start);
        }
        let Areas { left_out, mended, .. } = self.areas();
        let is_seen: Vec<bool> = self.terrain().grid().cells().map(|cell| reach.covers(cell)).collect();
        let starts = start::warnings(&self.file.robots, &self.map);
        let mut warnings: Vec<Warning> = self
            .unseen(&is_seen)
            .into_iter()
            .chain(apart)
            .chain(self.parts(&connected, &is_seen))
            .chain(starts)
            .collect();
        warnings.extend(self.contradiction());
        warnings.extend(self.stops_at_once(&is_seen));
        warnings.extend(self.short_budget(&is_seen));
        warnings.extend(self.clipped());
        warnings.extend(self.never_found(&is_seen));
        warnings.extend(drawn.iter().filter_map(about_area));
        warnings.extend(self.overlap());
        warnings.extend(self.gap());
        warnings.extend((!mended.is_empty()).then_some(Warning::Mended { faults: mended }));
        warnings.extend(left_out.into_iter().map(|name| Warning::LeftOut { name }));
        warnings
    }

    /// The connected parts of drawn search areas, with and without robots.
    fn parts(&self, connected: &[Vec<Cell>], is_seen: &[bool]) -> Option<Warning> {
        if !self.map.areas.has_search_area() {
            return None;
        }
        let area_of = |start| match start {
            Start::Together { area } => Some(area),
            Start::Scattered => Some(0),
            Start::Cell(cell) => connected.iter().position(|area| area.binary_search(&cell).is_ok()),
        };
        let mut robots = vec![0; connected.len()];
        for area in
            self.robots().iter().filter(|robot| !robot.class.flies).filter_map(|robot| area_of(robot.start))
        {
            robots[area] += 1;
        }
        let is_unseen = |&cell: &Cell| self.terrain().is_searched(cell) && !is_seen[cell.index()];
        let parts = || connected.iter().zip(&robots);
        let searched: Vec<(usize, usize)> =
            parts().filter(|&(_, &robots)| robots > 0).map(|(area, &robots)| (area.len(), robots)).collect();
        let unsearched: Vec<usize> =
            parts().filter(|(area, _)| area.iter().any(is_unseen)).map(|(area, _)| area.len()).collect();
        let is_spread =
            self.robots().iter().any(|robot| matches!(robot.start, Start::Together { area: 1.. }));
        (is_spread || !unsearched.is_empty()).then_some(Warning::Parts { searched, unsearched })
    }

    /// A prior may expect more or fewer objects than there are: a factor of two is a warning.
    fn contradiction(&self) -> Option<Warning> {
        if self.subjects().is_some() {
            // It is scaled to their number, and expects the others outside.
            return None;
        }
        let terrain = self.terrain();
        let by_prior: f64 = terrain.searched_cells().map(|cell| self.prior().probability(cell)).sum();
        let by_objects = match self.objects() {
            Objects::Count(count) => f64::from(*count),
            Objects::Cells(cells) => cells.len() as f64,
            density @ Objects::Density(_) => density.expected_count(terrain),
        };
        let (more, less) = (by_prior.max(by_objects), by_prior.min(by_objects));
        (more > 2.0 * less && more - less > 1.0).then_some(Warning::Contradiction { by_prior, by_objects })
    }

    /// Ground between regions that is narrower than a cell has no cell of its own for what the regions leave.
    fn gap(&self) -> Option<Warning> {
        let Rest { poa, cells } = self.claims()?.rest;
        if cells > 0 || poa < LEAST_TOLD {
            return None;
        }
        let share = self.areas().unclaimed_share();
        (share >= LEAST_TOLD).then_some(Warning::Gap { poa, share })
    }

    fn overlap(&self) -> Option<Warning> {
        let (first, others) = self.map.overlaps.split_first()?;
        Some(Warning::Overlap { areas: first.clone(), others: others.len() })
    }

    fn stops_at_once(&self, is_seen: &[bool]) -> Option<Warning> {
        let limit = self.mission().stop_when_expected_remaining?;
        let seen = self.terrain().searched_cells().filter(|cell| is_seen[cell.index()]);
        let expected: f64 = seen.map(|cell| self.prior().probability(cell)).sum();
        (expected <= limit).then_some(Warning::StopsAtOnce { limit, expected })
    }

    /// Who made the scenario of a map alone did not choose its budget. Each robot observes what it sees from its start, and
    /// along its path a strip as wide as its sight.
    fn short_budget(&self, is_seen: &[bool]) -> Option<Warning> {
        let searched = self.terrain().searched_cells().filter(|cell| is_seen[cell.index()]).count();
        let observed: f64 = self
            .robots()
            .iter()
            .map(|robot| {
                let width = f64::from(2 * robot.class.sensor.radius() + 1);
                let budget_cells = robot.class.budget_meters() / self.terrain().cell_meters();
                std::f64::consts::PI * width * width / 4.0 + budget_cells * width
            })
            .sum();
        let is_short = self.is_of_map() && observed < LOOKS_A_CELL * searched as f64;
        is_short.then_some(Warning::ShortBudget { observed, searched })
    }

    /// Clipped readings are no more exact than the belief takes them for; of large variances they mislead it.
    fn clipped(&self) -> Option<Warning> {
        let misleads = |sensor: &Sensor| {
            let is_large = |&distance: &u32| sensor.variance(distance) >= CLIPPED_VARIANCE;
            let distance = (0..=sensor.radius()).find(is_large)?;
            let is_clipped = sensor.noise() == Noise::Clipped;
            is_clipped.then(|| Warning::Clipped { distance, variance: sensor.variance(distance) })
        };
        self.robots().iter().find_map(|robot| misleads(&robot.class.sensor))
    }

    /// Objects in given cells, each with the first reason only.
    fn never_found(&self, is_seen: &[bool]) -> Vec<Warning> {
        let Objects::Cells(given) = self.objects() else { return Vec::new() };
        let (seen, unseen): (Vec<Cell>, Vec<Cell>) = given.iter().partition(|cell| is_seen[cell.index()]);
        let excluded = seen.into_iter().filter(|&cell| self.prior().probability(cell) <= 0.0).collect();
        let warning = |(reason, cells): (Reason, Vec<Cell>)| {
            let first = self.terrain().grid().position(*cells.first()?);
            Some(Warning::NeverFound { reason, objects: cells.len(), given: given.len(), first })
        };
        [(Reason::OutOfSight, unseen), (Reason::Excluded, excluded)].into_iter().filter_map(warning).collect()
    }

    fn unseen(&self, is_seen: &[bool]) -> Option<Warning> {
        let terrain = self.terrain();
        let unseen: Vec<Cell> = terrain.searched_cells().filter(|cell| !is_seen[cell.index()]).collect();
        let first = terrain.grid().position(*unseen.first()?);
        let sum = |cells: &mut dyn Iterator<Item = Cell>| -> f64 {
            cells.map(|cell| self.prior().probability(cell)).sum()
        };
        let (there, everywhere) = (sum(&mut unseen.iter().copied()), sum(&mut terrain.searched_cells()));
        let probability = if everywhere > 0.0 { there / everywhere } else { 0.0 };
        let searched = terrain.searched_cells().count();
        Some(Warning::Unseen { cells: unseen, searched, probability, first })
    }
}

/// The warning about an area without effect, or with parts without effect.
fn about_area(drawn: &Drawn) -> Option<Warning> {
    let Drawn { name, kind, cells, beyond, barriers } = drawn.clone();
    match (cells, beyond) {
        (0, _) => Some(Warning::Idle { kind, name, closes: barriers > 0 }),
        (_, 0) => None,
        (_, beyond) => Some(Warning::Beyond { name, beyond, barriers }),
    }
}

/// A cell of the area that a robot starts in; all of them reach the same.
fn some_start(connected: &[Vec<Cell>], start: Start) -> Option<Cell> {
    let area = match start {
        Start::Cell(cell) => return Some(cell),
        Start::Together { area } => area,
        Start::Scattered => 0,
    };
    connected.get(area)?.first().copied()
}

/// The parts of an area in words.
fn parts(searched: &[(usize, usize)], unsearched: &[usize]) -> String {
    let without = match unsearched {
        [] => String::new(),
        [cells] => format!("; 1 has no robot, of {cells} cells: {TO_SEARCH_ALL}"),
        all => format!("; {} have no robot, of {} cells: {TO_SEARCH_ALL}", all.len(), sizes(all)),
    };
    let plural = if matches!(searched, [(_, 1), ..]) { "robot starts" } else { "robots start" };
    let with = searched.iter().take(MAX_PARTS).enumerate().map(|(place, (cells, robots))| match place {
        0 => format!("; {robots} {plural} in that of {cells} cells"),
        _ => format!(", {robots} in that of {cells}"),
    });
    let others: usize = searched.iter().skip(MAX_PARTS).map(|(_, robots)| robots).sum();
    let others = if others > 0 { format!(", {others} in smaller ones") } else { String::new() };
    let number = searched.len() + unsearched.len();
    format!("the area is in {number} parts that no way connects{without}{}{others}", with.collect::<String>())
}

/// Numbers of cells, the largest first.
fn sizes(cells: &[usize]) -> String {
    let (listed, others) = cells.split_at(cells.len().min(MAX_PARTS));
    let mut listed: Vec<String> = listed.iter().map(ToString::to_string).collect();
    let last = match others {
        [] => listed.pop().unwrap_or_default(),
        _ => format!("{} more with {}", others.len(), others.iter().sum::<usize>()),
    };
    format!("{} and {last}", listed.join(", "))
}
