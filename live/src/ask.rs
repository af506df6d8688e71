//! Commands of the page: their format, validation and answers.

use dragnet_coordinator::finds::Find;
use dragnet_proto::command::Command;
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::marks::{MarkId, Marks};
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::Zone;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::mark::{Clue, Mark, Searched};
use dragnet_search::observation::RobotId;
use dragnet_search::route::{Connectivity, ShortestPathTree};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeSet;

use crate::orders::Order;
use crate::polygon::{self, Corner, PolygonError};
use crate::view::{State, View};

/// A command of the page, JSON: `{"command": "go", "robot": 2, "row": 3, "column": 4}`.
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
    /// The mission ends: all robots return to their bases.
    End {
        /// Whether it ends at once; otherwise once all robots are back.
        #[serde(default)]
        now: bool,
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
    /// Mark a clue.
    Clue {
        /// Row of its cell, from the south.
        row: u32,
        /// Column of its cell, from the west.
        column: u32,
        /// How many times as likely it is if an object is there, [`LEAST_RATIO`] to [`MOST_RATIO`].
        #[serde(default = "usual_ratio")]
        ratio: f64,
        /// Its standard error a direction, meters; 0 for its cell alone.
        #[serde(default)]
        radius_meters: f64,
        /// What it is.
        #[serde(default)]
        note: String,
    },
    /// Mark the cells of a polygon that others have searched without a find.
    Searched {
        /// Its corners.
        corners: Vec<Corner>,
        /// Their probability of detection, [`LEAST_POD`] to [`MOST_POD`].
        #[serde(default = "usual_pod")]
        pod: f64,
        /// Who has searched.
        #[serde(default)]
        note: String,
    },
    /// Withdraw a mark.
    Withdraw {
        /// Its name: [`crate::frame::MarkFrame::id`].
        mark: String,
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

/// The least likelihood ratio of a clue.
pub const LEAST_RATIO: f64 = 1.001;
/// The greatest likelihood ratio of a clue.
pub const MOST_RATIO: f64 = 1000.0;
/// The least probability of detection of a search of others.
pub const LEAST_POD: f64 = 0.001;
/// The greatest probability of detection of a search of others.
pub const MOST_POD: f64 = 0.999;

/// Of a clue of which nothing else is said.
const fn usual_ratio() -> f64 {
    10.0
}

/// Of a search of which nothing else is said: a thorough one.
const fn usual_pod() -> f64 {
    0.8
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
        "nothing is searched near cell [{row}, {column}], so that a clue there has no effect: add a polygon around it first"
    )]
    NotSearched {
        /// The given row.
        row: u32,
        /// The given column.
        column: u32,
    },
    /// No searched cell in a polygon.
    #[error("no cell in it is searched, so that a search of others there has no effect")]
    NothingSearched,
    /// A clue with a radius beyond what can be told.
    #[error("a radius of {found} m; allowed are 0 to {most:.0} m, 100 cells of this map")]
    Radius {
        /// The given radius, meters.
        found: f64,
        /// The greatest, meters.
        most: f64,
    },
    /// No mark of this name counts.
    #[error("there is no mark {0:?} that counts; the list of marks has their names")]
    NoMark(String),
    /// As many marks as there can be, or cells of them.
    #[error(
        "there are too many marks, with those that were withdrawn; allowed are {most} with {0} cells together",
        most = Marks::MOST
    )]
    NoRoom(usize),
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
            Self::End { now } => Ok(end(view, now)),
            Self::Go { robot, row, column } => go(view, robot, Position { row, column }),
            Self::Clue { row, column, ratio, radius_meters, note } => {
                clue(view, Position { row, column }, (ratio, radius_meters), &note)
            }
            Self::Searched { corners, pod, note } => searched(view, &corners, pod, &note),
            Self::Withdraw { mark } => withdraw(view, mark),
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
        TeamOrder::Return | TeamOrder::End => {
            ["are called back to their bases", "is called back to its base"]
        }
    };
    if let Some(robot) = robot {
        return to_one(view, robot, order.into(), one);
    }
    let already = if view.orders().is_given_to_all(order) { " already" } else { "" };
    let away = away(view, |_| true);
    let ending = if view.ending().is_some() { " The mission no longer ends." } else { "" };
    Ok((Command::Team(order), format!("All robots {all}{already}.{ending}{away}")))
}

/// The end of the mission.
fn end(view: &View, now: bool) -> (Command, String) {
    if now {
        let told = match &numbers(lacking(view))[..] {
            [] => "; all robots return to their bases.".to_owned(),
            [one] => format!(
                ". Robot {one} is not known to have the order to return: it goes on unless a teammate tells it."
            ),
            all => format!(
                ". Robots {} are not known to have the order to return: they go on unless a teammate tells them.",
                all.join(", ")
            ),
        };
        return (Command::EndNow, format!("The mission ends now{told}"));
    }
    let answer = format!("The mission ends once all robots are back at their bases.{}", away(view, |_| true));
    (Command::Team(TeamOrder::End), answer)
}

/// Robots that are not known to have the order to end the mission; before it is given those that are not here.
fn lacking(view: &View) -> Vec<RobotId> {
    let given = view.orders().iter().find(|given| matches!(given.order, Order::Team(..)));
    match given.filter(|given| matches!(given.order, Order::Team(_, TeamOrder::End))) {
        Some(end) => view.about().team.iter().filter(|robot| !end.has.contains(robot)).copied().collect(),
        None => those_away(view).collect(),
    }
}

fn those_away(view: &View) -> impl Iterator<Item = RobotId> + '_ {
    let away = |state| matches!(state, State::Awaited | State::Lost);
    view.robots().filter(move |&(.., state)| away(state)).map(|(robot, ..)| robot)
}

fn numbers(robots: impl IntoIterator<Item = RobotId>) -> Vec<String> {
    robots.into_iter().map(|robot| robot.to_string()).collect()
}

/// Which of these robots cannot know an order yet, in a sentence of its own; empty if all can.
fn away(view: &View, concerns: impl Fn(RobotId) -> bool) -> String {
    match &numbers(those_away(view).filter(|&robot| concerns(robot)))[..] {
        [] => String::new(),
        [one] => format!(" Robot {one} is not here: it follows once it is."),
        all => format!(" Robots {} are not here: they follow once they are.", all.join(", ")),
    }
}

fn to_one(view: &View, number: u16, order: RobotOrder, what: &str) -> Result<(Command, String), AskError> {
    let robot = of_team(view, number)?;
    let already = if view.orders().is_given(robot, order) { " already" } else { "" };
    let away = away(view, |concerned| concerned == robot);
    Ok((Command::Robot(robot, order), format!("Robot {robot} {what}{already}.{away}")))
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

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the allowed ranges")]
fn clue(
    view: &View,
    at: Position,
    (ratio, radius_meters): (f64, f64),
    note: &str,
) -> Result<(Command, String), AskError> {
    let (cell, Position { row, column }) = (cell_at(view, at)?, at);
    let cell_meters = view.terrain().cell_meters();
    let most = f64::from(Clue::MAX_RADIUS_HUNDREDTHS) / 100.0 * cell_meters;
    if radius_meters > most {
        return Err(AskError::Radius { found: radius_meters, most });
    }
    let mark = Mark::Clue(Clue {
        cell,
        ratio_thousandths: (ratio * 1000.0).round() as u32,
        radius_hundredths: (radius_meters / cell_meters * 100.0).round() as u32,
    });
    let is_searched = |&(cell, _): &(Cell, _)| view.terrain().is_searched(cell);
    if !mark.evidence(view.terrain().grid()).iter().any(is_searched) {
        return Err(AskError::NotSearched { row, column });
    }
    has_room(view, 1)?;
    let spread = if radius_meters > 0.0 {
        let there = 1.0 + (ratio - 1.0) * (-0.5_f64).exp();
        format!(", {there:.1} times at {radius_meters} m from there, and as before far away")
    } else {
        String::new()
    };
    let answer = format!(
        "Clue in cell [{row}, {column}]: the odds of an object are {ratio} times higher there{spread}; all clues \
         together make it at most as likely as not."
    );
    Ok((Command::Mark(mark, on_one_line(note)), answer))
}

/// A note as a line of a log: no breaks, and nothing that a terminal obeys.
fn on_one_line(note: &str) -> String {
    let words: String = note.chars().map(|it| if it.is_control() { ' ' } else { it }).collect();
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn has_room(view: &View, cells: usize) -> Result<(), AskError> {
    let grid = view.terrain().grid();
    if view.fold().marks().has_room(grid, cells) {
        Ok(())
    } else {
        Err(AskError::NoRoom(Marks::most_cells(grid)))
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the allowed range")]
fn searched(view: &View, corners: &[Corner], pod: f64, note: &str) -> Result<(Command, String), AskError> {
    let inside = polygon::cells_within(view.terrain().grid(), corners)?;
    let cells: BTreeSet<Cell> = inside.into_iter().filter(|&cell| view.terrain().is_searched(cell)).collect();
    if cells.is_empty() {
        return Err(AskError::NothingSearched);
    }
    has_room(view, cells.len())?;
    let (count, percent) = (cells.len(), pod * 100.0);
    let answer = format!(
        "{count} cell{} marked as searched by others: they found nothing, and would have found {percent:.1} % of what is there.",
        if count == 1 { " is" } else { "s are" }
    );
    let pod_thousandths = (pod * 1000.0).round() as u16;
    let mark = Mark::Searched(Searched { cells, pod_thousandths });
    Ok((Command::Mark(mark, on_one_line(note)), answer))
}

fn withdraw(view: &View, name: String) -> Result<(Command, String), AskError> {
    let known = name.parse().ok().and_then(|id: MarkId| Some((id, view.fold().marks().of(id)?)));
    match known {
        Some((id, marked)) if !marked.is_withdrawn => {
            let what = match &marked.mark {
                Mark::Clue(_) => "The clue",
                Mark::Searched(_) => "The search of others",
            };
            Ok((Command::Unmark(id), format!("{what} is withdrawn, and counts no longer.")))
        }
        _ => Err(AskError::NoMark(name)),
    }
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
