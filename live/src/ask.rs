//! Commands of the page: their format, validation and answers.

use dragnet_coordinator::finds::Find;
use dragnet_proto::command::{Command, Mark};
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::Zone;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::observation::RobotId;
use dragnet_search::route::{Connectivity, ShortestPathTree};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeSet;

use crate::polygon::{self, Corner, PolygonError};
use crate::view::{State, View};

/// A command of the page, JSON: `{"command": "mark", "row": 3, "column": 4, "as": "clue"}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum Ask {
    /// A robot stays where it is, or all do.
    Pause {
        /// The robot; all if it is missing.
        #[serde(default, deserialize_with = "a_number")]
        robot: Option<u16>,
    },
    /// A robot searches again, or all do.
    Resume {
        /// The robot; all if it is missing.
        #[serde(default, deserialize_with = "a_number")]
        robot: Option<u16>,
    },
    /// A robot returns to its base, or all do.
    Return {
        /// The robot; all if it is missing.
        #[serde(default, deserialize_with = "a_number")]
        robot: Option<u16>,
    },
    /// A robot goes to a cell, and stays there.
    Go {
        /// The robot.
        robot: u16,
        /// Row of the cell, from the south.
        row: u32,
        /// Column of the cell, from the west.
        column: u32,
    },
    /// Mark a cell.
    Mark {
        /// Row of the cell, from the south.
        row: u32,
        /// Column of the cell, from the west.
        column: u32,
        /// The mark.
        r#as: MarkName,
    },
    /// Decide about a find.
    Find {
        /// Row of its cell, from the south.
        row: u32,
        /// Column of its cell, from the west.
        column: u32,
        /// The decision.
        r#as: DecisionName,
    },
    /// Take the cells of a polygon out of the search, or open them again.
    Zone {
        /// Its corners.
        corners: Vec<Corner>,
        /// What its cells are.
        r#as: ZoneName,
    },
    /// Add a polygon to the search area.
    Search {
        /// Its corners.
        corners: Vec<Corner>,
    },
}

/// A program that does not know its robot, and says `null`, does not stop all.
fn a_number<'de, D: Deserializer<'de>>(number: D) -> Result<Option<u16>, D::Error> {
    u16::deserialize(number).map(Some)
}

/// Names of marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkName {
    /// [`Mark::Searched`].
    Searched,
    /// [`Mark::Clue`].
    Clue,
}

/// Names of zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ZoneName {
    /// [`Zone::Open`].
    Open,
    /// [`Zone::Skip`].
    Skip,
    /// [`Zone::NoGo`].
    NoGo,
}

/// Names of decisions about finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DecisionName {
    /// [`Decision::Confirmed`].
    Confirmed,
    /// [`Decision::Dismissed`].
    Dismissed,
    /// [`Decision::Undone`].
    Undone,
}

/// Why a command is rejected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AskError {
    /// A cell off the map.
    #[error(
        "cell [{row}, {column}] is not on the map; allowed are rows 0 to {last_row} and columns 0 to {last_column}"
    )]
    Cell {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
        /// The last row of the map.
        last_row: u32,
        /// The last column of the map.
        last_column: u32,
    },
    /// A cell in which nothing is searched.
    #[error(
        "cell [{row}, {column}] is not searched, so that a mark there has no effect: add a polygon around it first"
    )]
    NotSearched {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// No robot of the team.
    #[error("there is no robot {robot}; the team has robots {first} to {last}")]
    Robot {
        /// The given number.
        robot: u16,
        /// The lowest number of the team.
        first: u16,
        /// The highest number of the team.
        last: u16,
    },
    /// A cell that no robot can enter.
    #[error("no robot can drive in cell [{row}, {column}]: choose one beside it")]
    NotTraversable {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// A cell in a no-go zone.
    #[error("cell [{row}, {column}] is no-go by your order: open it again first")]
    Closed {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// A cell to which no way leads from where the robot is.
    #[error("no way leads from where robot {robot} is to cell [{row}, {column}]")]
    NoWay {
        /// The robot.
        robot: u16,
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// A robot that can go nowhere.
    #[error("robot {robot} goes nowhere: its budget is spent, or its battery low")]
    Spent {
        /// The robot.
        robot: u16,
    },
    /// No find to decide about.
    #[error("there is no find in cell [{row}, {column}]: only a find can be confirmed or dismissed")]
    NoFind {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// No decision to undo.
    #[error("no find in cell [{row}, {column}] was confirmed or dismissed, so that there is nothing to undo")]
    NothingDecided {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// An invalid polygon.
    #[error(transparent)]
    Polygon(#[from] PolygonError),
    /// No cell of the polygon is searched.
    #[error("no cell in it is searched, so that there is nothing to skip")]
    NothingToSkip,
    /// No cell of the polygon is in a zone.
    #[error("no cell in it is skipped or no-go by your order: no-go areas of the map stay")]
    NothingToOpen,
    /// All cells of the polygon are in the zone already.
    #[error("all cells in it are {0} already")]
    SameZone(&'static str),
    /// All cells of the polygon are searched already.
    #[error("all {0} cells in it are searched already")]
    NothingNew(usize),
}

impl Ask {
    /// The command for the mission of a view, and the answer to the page.
    ///
    /// # Errors
    /// If the command is rejected.
    pub fn command(self, view: &View) -> Result<(Command, String), AskError> {
        match self {
            Self::Pause { robot } => order(view, robot, TeamOrder::Pause),
            Self::Resume { robot } => order(view, robot, TeamOrder::Search),
            Self::Return { robot } => order(view, robot, TeamOrder::Return),
            Self::Go { robot, row, column } => go(view, robot, Position { row, column }),
            Self::Mark { row, column, r#as } => mark(view, Position { row, column }, r#as),
            Self::Find { row, column, r#as } => decide(view, Position { row, column }, r#as),
            Self::Search { corners } => search(view, &corners),
            Self::Zone { corners, r#as } => zone(view, &corners, r#as),
        }
    }
}

/// An order to a robot, or to all.
fn order(view: &View, robot: Option<u16>, order: TeamOrder) -> Result<(Command, String), AskError> {
    let [all, one] = match order {
        TeamOrder::Search => ["search", "searches"],
        TeamOrder::Pause => ["are paused", "is paused"],
        TeamOrder::Return => ["are called back to their bases", "is called back to its base"],
    };
    if let Some(robot) = robot {
        return to_one(view, robot, order.into(), one);
    }
    let already = if view.orders().is_given_to_all(order) { " already" } else { "" };
    Ok((Command::Team(order), format!("All robots {all}{already}.")))
}

fn to_one(view: &View, number: u16, order: RobotOrder, what: &str) -> Result<(Command, String), AskError> {
    let robot = of_team(view, number)?;
    let already = if view.orders().is_given(robot, order) { " already" } else { "" };
    Ok((Command::Robot(robot, order), format!("Robot {robot} {what}{already}.")))
}

fn of_team(view: &View, number: u16) -> Result<RobotId, AskError> {
    let team = &view.about().team;
    let [first, last] = [team.first(), team.last()].map(|end| end.map_or(0, |robot| robot.number()));
    let robot = team.iter().copied().find(|robot| robot.number() == number);
    robot.ok_or(AskError::Robot { robot: number, first, last })
}

/// Robots that fly may be sent anywhere; others where robots can drive, and a way leads from where they are.
fn go(view: &View, number: u16, at: Position) -> Result<(Command, String), AskError> {
    let robot = of_team(view, number)?;
    let (cell, Position { row, column }) = (cell_at(view, at)?, at);
    let found = view.robots().find(|(known, ..)| *known == robot);
    let flies = view.about().sights.get(robot.index()).is_some_and(|sight| sight.flies());
    let zones = view.fold().zones();
    if zones.of(cell) == Some(Zone::NoGo) {
        return Err(AskError::Closed { row, column });
    }
    if !flies && !view.terrain().is_traversable(cell) {
        return Err(AskError::NotTraversable { row, column });
    }
    if let Some((_, _, track, state)) = found {
        if state == State::Spent {
            return Err(AskError::Spent { robot: number });
        }
        // Diagonal moves connect no more cells than straight ones.
        let is_cut_off = |(from, _)| {
            // It leaves a no-go zone first.
            if zones.of(from) == Some(Zone::NoGo) {
                return false;
            }
            let terrain = zones.on(view.terrain());
            !ShortestPathTree::from(&terrain, Connectivity::Four, from).length(cell).is_finite()
        };
        if !flies && track.pose.is_some_and(is_cut_off) {
            return Err(AskError::NoWay { robot: number, row, column });
        }
    }
    let sent = format!("is sent to cell [{row}, {column}]");
    let is_new = !view.orders().is_given(robot, RobotOrder::Go(cell));
    let how = if is_new { ", as far as its budget leaves the way home, and stays there" } else { "" };
    to_one(view, number, RobotOrder::Go(cell), &format!("{sent}{how}"))
}

fn cell_at(view: &View, at: Position) -> Result<Cell, AskError> {
    let (grid, Position { row, column }) = (view.terrain().grid(), at);
    let (last_row, last_column) = (grid.rows() - 1, grid.columns() - 1);
    grid.cell(at).ok_or(AskError::Cell { row, column, last_row, last_column })
}

fn decide(view: &View, at: Position, name: DecisionName) -> Result<(Command, String), AskError> {
    let (cell, Position { row, column }) = (cell_at(view, at)?, at);
    let find = view.fold().finds().into_iter().find(|find| find.cell == cell);
    let (decision, effect) = match (name, find) {
        (DecisionName::Undone, Some(Find { operator: Some(_), .. })) => {
            (Decision::Undone, "open again: what the robots have seen decides")
        }
        (DecisionName::Undone, _) => return Err(AskError::NothingDecided { row, column }),
        (_, None) => return Err(AskError::NoFind { row, column }),
        (DecisionName::Confirmed, Some(_)) => {
            (Decision::Confirmed, "confirmed: it stays, whatever robots see later")
        }
        (DecisionName::Dismissed, Some(_)) => {
            (Decision::Dismissed, "dismissed: it comes back only if robots see much more that speaks for it")
        }
    };
    Ok((Command::Judge(decision, cell), format!("The find in cell [{row}, {column}] is {effect}.")))
}

fn mark(view: &View, at: Position, name: MarkName) -> Result<(Command, String), AskError> {
    let (cell, Position { row, column }) = (cell_at(view, at)?, at);
    if !view.terrain().is_searched(cell) {
        return Err(AskError::NotSearched { row, column });
    }
    let (mark, what) = match name {
        MarkName::Searched => (Mark::Searched, "searched"),
        MarkName::Clue => (Mark::Clue, "a clue"),
    };
    let by = Mark::STRENGTH_NATS.exp();
    let moved = match mark {
        Mark::Searched => "lower",
        Mark::Clue => "higher",
    };
    let answer = format!(
        "Cell [{row}, {column}] is marked as {what}: the odds of an object there are {by:.0} times {moved}."
    );
    Ok((Command::Mark(mark, cell), answer))
}

fn zone(view: &View, corners: &[Corner], name: ZoneName) -> Result<(Command, String), AskError> {
    let inside = polygon::cells_within(view.terrain().grid(), corners)?;
    let zones = view.fold().zones();
    let is = |cell: Cell| zones.of(cell).unwrap_or(Zone::Open);
    let robots = view.robots().filter_map(|(robot, _, track, _)| Some((robot, track.pose?.0)));
    let is_inside = inside.iter().copied().collect::<BTreeSet<_>>();
    let robots: Vec<String> =
        robots.filter(|(_, cell)| is_inside.contains(cell)).map(|(robot, _)| robot.to_string()).collect();
    let (zone, nothing, kept): (Zone, AskError, Vec<Cell>) = match name {
        ZoneName::Open => (Zone::Open, AskError::NothingToOpen, inside),
        ZoneName::Skip => {
            let searched: Vec<Cell> =
                inside.into_iter().filter(|&cell| view.terrain().is_searched(cell)).collect();
            if searched.is_empty() {
                return Err(AskError::NothingToSkip);
            }
            (Zone::Skip, AskError::SameZone("skipped"), searched)
        }
        ZoneName::NoGo => (Zone::NoGo, AskError::SameZone("no-go"), inside),
    };
    let cells: Vec<Cell> = kept.into_iter().filter(|&cell| is(cell) != zone).collect();
    let effect = match zone {
        _ if cells.is_empty() => return Err(nothing),
        Zone::Open => "are open again".to_owned(),
        Zone::Skip => "are skipped: robots do not search there, and may drive through".to_owned(),
        Zone::NoGo if robots.is_empty() => "are no-go: robots go around them".to_owned(),
        Zone::NoGo => {
            let who = if robots.len() == 1 { "robot" } else { "robots" };
            let leave = if robots.len() == 1 { "leaves" } else { "leave" };
            format!("are no-go: {who} {} {leave} by the shortest way, others go around", robots.join(", "))
        }
    };
    let answer = format!("{} cells {effect}.", cells.len());
    Ok((Command::Zone(zone, cells), answer))
}

fn search(view: &View, corners: &[Corner]) -> Result<(Command, String), AskError> {
    let cells = polygon::cells_within(view.terrain().grid(), corners)?;
    let is_new = |&&cell: &&_| !view.terrain().is_searched(cell);
    let new = cells.iter().filter(is_new).count();
    if new == 0 {
        return Err(AskError::NothingNew(cells.len()));
    }
    let known = match cells.len() - new {
        0 => String::new(),
        known => format!(" {known} more in it were searched already and stay as they are."),
    };
    let answer = format!("{new} cells are searched from now on.{known}");
    Ok((Command::Search(cells), answer))
}
