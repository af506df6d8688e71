//! The mission as the events that show it on a map.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_coordinator::finds::{Find, Finders, of_subject};
use dragnet_coordinator::fold::MissionFold;
use dragnet_coordinator::mission::Record;
use dragnet_proto::message::{Activity, Detection, Heartbeat};
use dragnet_proto::verdict::Decision;
use dragnet_scenario::map_file::{Area, GeoPoint, Georeference, Purpose};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Class, Places, Robot, Scenario, accuracy};
use dragnet_search::cell::Cell;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{self, RobotId};

use super::event::{Color, Detail, Event, Motion};
use super::shapes::{Shape, shapes};
use crate::account::closed;
use crate::bands::region;
use crate::time::utc;

/// Periods after which a robot that is not heard any more is no longer shown as current.
const STALE_PERIODS: u32 = 4;
/// The time for which finds and areas are shown after the last event: longer than a coordinator takes to start again.
const LASTING: Duration = Duration::from_hours(1);
/// How often the removal of one thing is sent: datagrams may be lost.
const REMOVALS: u32 = 5;

const YELLOW: Color = Color(0xffff_ff00);
const PURPLE: Color = Color(0xff6d_28d9);
const GREEN: Color = Color(0xff00_ff00);

/// The map lies nowhere on the earth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "TAK shows the earth, and the scenario does not say where on it the map lies; needed is map.origin with \
     latitude_degrees and longitude_degrees, or a map of areas, such as KML"
)]
pub struct NotOnEarth;

/// Where the robots are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Outdoors, as far as is known.
    Field,
    /// In a simulation: every name says so.
    Simulation,
}

/// What is known of a mission beforehand.
#[derive(Clone, Debug)]
pub struct Mission<'a> {
    /// Its name, which all names of its events contain.
    pub name: &'a str,
    /// Its scenario.
    pub scenario: &'a Scenario,
    /// Where its robots are.
    pub source: Source,
    /// Mission seconds per second, above 0.
    pub real_time_factor: f64,
}

/// A running mission, folded from the coordinator's records.
///
/// Its size is bounded by the map and the team, however long the mission takes.
#[derive(Clone, Debug)]
pub struct Picture {
    mission: String,
    source: Source,
    real_time_factor: f64,
    frame: Georeference,
    places: Places,
    is_of_subjects: bool,
    team: Vec<Robot>,
    fold: MissionFold,
    finders: Finders,
    robots: BTreeMap<RobotId, Unit>,
    /// Cells that were ever declared: they keep their number.
    found: BTreeMap<Cell, Found>,
    drawn: Vec<Shape>,
    /// Cells that the operator has added to the search area, and their shapes.
    added: (BTreeSet<Cell>, Vec<Shape>),
    /// The no-go zones by the operator's orders.
    closed: Vec<Shape>,
    /// What maps show that does not become stale soon.
    shown: BTreeSet<String>,
    /// What maps are to remove, and how often that is still to be sent.
    removals: BTreeMap<String, u32>,
}

/// A robot.
#[derive(Clone, Debug, Default)]
struct Unit {
    activity: Option<Activity>,
    path_meters: f64,
    /// The time of its last heartbeat by its own clock, nanoseconds.
    reported_ns: u64,
    /// The last cell that it entered, and when.
    entered: Option<(Cell, MissionTime)>,
    motion: Option<Motion>,
}

#[derive(Clone, Copy, Debug)]
struct Found {
    number: usize,
    /// When it was declared, Unix time, nanoseconds.
    unix_ns: u64,
}

impl Picture {
    /// A mission before its first record.
    ///
    /// # Errors
    /// If its map does not lie on the earth.
    pub fn new(mission: &Mission<'_>) -> Result<Self, NotOnEarth> {
        let Mission { name, scenario, source, real_time_factor } = *mission;
        let earth = scenario.earth().ok_or(NotOnEarth)?;
        let prior = single_precision(scenario);
        Ok(Self {
            mission: name.to_owned(),
            source,
            real_time_factor,
            frame: earth.frame,
            places: scenario.places(),
            is_of_subjects: scenario.subjects().is_some(),
            team: scenario.robots().to_vec(),
            fold: MissionFold::new(scenario.terrain(), &prior),
            finders: Finders::new(scenario.mission().detection_threshold),
            robots: BTreeMap::new(),
            found: BTreeMap::new(),
            drawn: shapes("area", &earth.areas),
            added: (BTreeSet::new(), Vec::new()),
            closed: Vec::new(),
            shown: BTreeSet::new(),
            removals: BTreeMap::new(),
        })
    }

    /// Applies a record of the coordinator. `unix_ns` is the Unix time at the mission time `now`, nanoseconds.
    pub fn take(&mut self, now: MissionTime, unix_ns: u64, record: &Record) {
        let change = self.fold.take(record);
        if !change.added.is_empty() {
            self.add(&change.added);
        }
        self.finders.credit(&self.fold, observation::Source::Operator, change.marked);
        match record {
            Record::Observation(observation) => {
                let cells = observation.readings.iter().map(|reading| reading.cell);
                self.finders.credit(&self.fold, observation.origin.source, cells);
            }
            Record::Heartbeat(heartbeat) => self.report(heartbeat),
            Record::Pose { robot, cell, time } => self.enter(*robot, *cell, *time),
            Record::Status(_) => self.declare(now, unix_ns),
            Record::Zones(report) if report.from == Participant::Coordinator => {
                let area = closed(self.fold.zones(), self.fold.terrain(), &self.frame);
                self.closed = shapes("order", area.as_slice());
            }
            _ => {}
        }
    }

    fn add(&mut self, cells: &[Cell]) {
        let (added, terrain) = (&mut self.added.0, self.fold.terrain());
        added.extend(cells);
        let is_added: Vec<bool> = terrain.grid().cells().map(|cell| added.contains(&cell)).collect();
        let purpose = Purpose::Search(region(terrain, &self.frame, &is_added));
        self.added.1 = shapes("added", &[Area { name: "Added by order".to_owned(), purpose }]);
    }

    fn report(&mut self, heartbeat: &Heartbeat) {
        let unit = self.robots.entry(heartbeat.robot).or_default();
        if heartbeat.time_ns >= unit.reported_ns {
            unit.reported_ns = heartbeat.time_ns;
            unit.activity = Some(heartbeat.activity);
            unit.path_meters = heartbeat.path_meters;
        }
    }

    /// The motion is that of the last step: robots report cells.
    fn enter(&mut self, robot: RobotId, cell: Cell, time: MissionTime) {
        let terrain = self.fold.terrain();
        let from = self.robots.get(&robot).and_then(|unit| unit.entered);
        let motion = from.filter(|&(from, since)| from != cell && time > since).and_then(|(from, since)| {
            let meters = terrain.grid().offset(from, cell).euclidean() * terrain.cell_meters();
            Some(Motion {
                course_degrees: course_degrees(self.places.center(from)?, self.places.center(cell)?),
                speed_meters_per_second: meters / time.since(since).as_secs_f64(),
            })
        });
        let unit = self.robots.entry(robot).or_default();
        unit.entered = Some((cell, time));
        unit.motion = motion.or(unit.motion);
    }

    /// Dates finds that are declared for the first time.
    fn declare(&mut self, now: MissionTime, unix_ns: u64) {
        for object in self.fold.declared() {
            let number = self.found.len() + 1;
            self.found.entry(object.cell).or_insert_with(|| {
                let seconds = now.since(MissionTime(object.time_ns)).as_secs_f64() / self.real_time_factor;
                let ago = Duration::try_from_secs_f64(seconds).unwrap_or_default().as_nanos();
                let unix_ns = unix_ns.saturating_sub(u64::try_from(ago).unwrap_or(u64::MAX));
                Found { number, unix_ns }
            });
        }
    }

    /// The events that show the mission now, at a Unix time in nanoseconds, if the next ones follow after a period: to be
    /// called only when they will be sent, since removals are sent a few times and then forgotten.
    ///
    /// Lost robots have no events, and become stale.
    pub fn events(&mut self, unix_ns: u64, period: Duration) -> Vec<Event> {
        let stale = period * STALE_PERIODS;
        let lasting: Vec<Event> =
            self.areas(unix_ns).chain(self.finds(unix_ns)).chain(self.clues(unix_ns)).collect();
        self.note(lasting.iter().map(|event| event.uid.clone()).collect());
        let removals = self.removals(unix_ns);
        self.units(unix_ns, stale).chain(lasting).chain(removals).collect()
    }

    /// Notes what is shown from now on; what was shown before is to be removed.
    fn note(&mut self, shown: BTreeSet<String>) {
        self.removals.retain(|uid, _| !shown.contains(uid));
        let gone = std::mem::replace(&mut self.shown, shown);
        let gone = gone.into_iter().filter(|uid| !self.shown.contains(uid));
        self.removals.extend(gone.map(|uid| (uid, REMOVALS)));
    }

    fn removals(&mut self, time_unix_ns: u64) -> Vec<Event> {
        let point = self.frame.south_west();
        let removal = |(uid, left): (&String, &mut u32)| {
            *left -= 1;
            Event {
                uid: format!("{uid}.removal"),
                kind: "t-x-d-d",
                how: "m-g",
                time_unix_ns,
                stale: LASTING,
                point,
                error_meters: None,
                detail: Detail::Removal { uid: uid.clone() },
            }
        };
        let events = self.removals.iter_mut().map(removal).collect();
        self.removals.retain(|_, left| *left > 0);
        events
    }

    fn areas(&self, time_unix_ns: u64) -> impl Iterator<Item = Event> {
        self.drawn.iter().chain(&self.added.1).chain(&self.closed).map(move |shape| Event {
            uid: self.uid(&shape.name),
            kind: shape.kind,
            how: "h-e",
            time_unix_ns,
            stale: LASTING,
            point: shape.point,
            error_meters: None,
            detail: shape.detail.clone(),
        })
    }

    /// Robots that are alive and have said where they are.
    fn units(&self, time_unix_ns: u64, stale: Duration) -> impl Iterator<Item = Event> {
        let is_alive = |robot| self.fold.status().is_none_or(|status| status.alive.contains(&robot));
        self.team.iter().filter(move |robot| is_alive(robot.id)).filter_map(move |robot| {
            let (cell, _) = self.fold.tracks().of(robot.id)?.pose?;
            let unit = self.robots.get(&robot.id).cloned().unwrap_or_default();
            Some(Event {
                uid: self.uid(&format!("robot-{}", robot.id)),
                // A drone with rotors, and a vehicle: the standard has no unmanned one on the ground.
                kind: if robot.class.flies { "a-f-A-M-H-Q" } else { "a-f-G-E-V" },
                how: "m-g",
                time_unix_ns,
                stale,
                point: self.places.center(cell)?,
                error_meters: Some(self.error_meters()),
                detail: Detail::Unit {
                    callsign: self.callsign("Robot", robot.id),
                    remarks: remarks(&unit, &robot.class),
                    motion: unit.motion(),
                },
            })
        })
    }

    /// Those that are declared: the operator's dismissal ends that, until new readings speak for it again.
    fn finds(&self, time_unix_ns: u64) -> impl Iterator<Item = Event> {
        let finds = self.fold.finds().into_iter().filter(|find| find.is_declared);
        finds.filter_map(move |find| {
            let found = *self.found.get(&find.cell)?;
            let is_confirmed = find.operator == Some(Decision::Confirmed);
            let position = self.fold.position(find.cell);
            Some(Event {
                uid: self.uid(&format!("find-{}", find.cell.number())),
                kind: "b-m-p-s-m",
                how: "m-f",
                time_unix_ns,
                stale: LASTING,
                point: self.places.object_point(find.cell, position)?,
                error_meters: Some(
                    position.map_or_else(|| self.error_meters(), ObjectPosition::accuracy_meters),
                ),
                detail: Detail::Marker {
                    callsign: self.callsign("Find", found.number),
                    remarks: self.told(&find, self.object(find.cell)?, found),
                    color: if is_confirmed { GREEN } else { YELLOW },
                },
            })
        })
    }

    /// The operator's clues that count.
    fn clues(&self, time_unix_ns: u64) -> impl Iterator<Item = Event> {
        self.fold.marks().clues().filter_map(move |(number, id, clue, marked)| {
            let radius_meters = self.places.meters(clue.radius_cells());
            Some(Event {
                uid: self.uid(&format!("clue-{id}")),
                kind: "b-m-p-s-m",
                how: "h-e",
                time_unix_ns,
                stale: LASTING,
                point: self.places.center(clue.cell)?,
                error_meters: Some(radius_meters.max(self.error_meters())),
                detail: Detail::Marker {
                    callsign: self.callsign("Clue", number),
                    remarks: marked.said(&self.places),
                    color: PURPLE,
                },
            })
        })
    }

    /// The error of a position that is known by its cell: half a diagonal.
    fn error_meters(&self) -> f64 {
        self.fold.terrain().cell_meters() * std::f64::consts::FRAC_1_SQRT_2
    }

    fn object(&self, cell: Cell) -> Option<&Detection> {
        self.fold.declared().iter().find(|object| object.cell == cell)
    }

    /// A find in words: how probable, whether confirmed, and when which robot found it.
    fn told(&self, find: &Find, object: &Detection, found: Found) -> String {
        let known = self.fold.position(find.cell).map(|it| accuracy(it.accuracy_meters()));
        let known = known.map_or_else(String::new, |known| format!(" ({known})"));
        let place = format!("{}{known}", self.places.cell(find.cell));
        let what = if self.is_of_subjects {
            of_subject(&place, object.probability, find.operator)
        } else {
            let operator = match find.operator {
                Some(Decision::Confirmed) => "confirmed by the operator",
                Some(Decision::Dismissed) => "dismissed by the operator and declared again by later readings",
                Some(Decision::Undone) | None => "not confirmed",
            };
            // Rounded down: no find is certain.
            let percent = (1000.0 * object.probability).floor().min(999.0) / 10.0;
            format!("object ({percent:.1} %) at {place}, {operator}")
        };
        let finder = match self.finders.of(find.cell) {
            Some(observation::Source::Robot(robot)) => format!("by robot {robot}"),
            Some(observation::Source::Operator) => "marked by the operator".to_owned(),
            None => "by several observations".to_owned(),
        };
        format!("{what}. Found {finder} at {}", utc(found.unix_ns))
    }

    fn uid(&self, name: &str) -> String {
        format!("dragnet.{}.{name}", self.mission)
    }

    fn callsign(&self, what: &str, number: impl std::fmt::Display) -> String {
        let simulated = if self.source == Source::Simulation { ", simulated" } else { "" };
        format!("{what} {number} ({}{simulated})", self.mission)
    }
}

impl Unit {
    /// That of its last step, unless it stands.
    fn motion(&self) -> Option<Motion> {
        let is_under_way = self.activity.is_none_or(Activity::is_under_way);
        let motion = self.motion?;
        let speed_meters_per_second = if is_under_way { motion.speed_meters_per_second } else { 0.0 };
        Some(Motion { speed_meters_per_second, ..motion })
    }
}

/// What a robot does and what it has spent of its budget, in words. Messages do not carry its battery.
fn remarks(unit: &Unit, class: &Class) -> String {
    let activity = match unit.activity {
        None | Some(Activity::Searching) => "it searches",
        Some(other) => other.reason(),
    };
    let budget =
        class.budget.meters().map_or_else(String::new, |meters| format!(" of at most {meters:.0} m"));
    let class = class.name.as_ref().map_or_else(String::new, |name| format!("{name}: "));
    format!("{class}{activity}; {:.0} m driven{budget}", unit.path_meters)
}

/// The direction of a near point from true north, clockwise, degrees, 0 to 360.
fn course_degrees(from: GeoPoint, to: GeoPoint) -> f64 {
    let north = to.latitude_degrees - from.latitude_degrees;
    let east = (to.longitude_degrees - from.longitude_degrees) * from.latitude_degrees.to_radians().cos();
    east.atan2(north).to_degrees().rem_euclid(360.0)
}

/// The prior, as recordings have it.
#[expect(clippy::cast_possible_truncation, reason = "recordings have single precision")]
fn single_precision(scenario: &Scenario) -> Vec<f32> {
    let cells = scenario.terrain().grid().cells();
    cells.map(|cell| scenario.prior().probability(cell) as f32).collect()
}

#[cfg(test)]
mod tests;
