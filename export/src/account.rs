//! The state of a recorded mission at a time, with its position on the earth.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use dragnet_coordinator::finds::Find;
use dragnet_coordinator::fold::MissionFold;
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::segment::{SegmentRow, Segments};
use dragnet_coordinator::track::Track;
use dragnet_proto::marks::Marks;
use dragnet_proto::message::Detection;
use dragnet_proto::picture::Picture;
use dragnet_proto::verdict::{Decision, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::map_file::{Area, Earth, GeoPoint, Georeference, Purpose};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::mark::{Clue, Searched};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::RobotId;
use dragnet_search::reach::{Reach, Sight};
use dragnet_search::subjects::Standing;
use dragnet_search::terrain::Terrain;
use geo::{MultiLineString, MultiPolygon};

use crate::ExportError;
use crate::bands::region;

pub use dragnet_coordinator::segment::Coverage;
pub use dragnet_coordinator::visits::Visit;

/// Speed for recordings without it.
const USUAL_SPEED_METERS_PER_SECOND: f64 = 2.0;

/// The state of a recorded mission at a time.
#[derive(Clone, Debug)]
pub struct Account {
    /// The mission's name.
    pub name: String,
    /// The mission's start, Unix time, nanoseconds.
    pub start_unix_ns: u64,
    /// The time up to which the recording was read.
    pub until: MissionTime,
    /// The map's position on the earth.
    pub frame: Georeference,
    /// The map, with cells that the operator added.
    pub terrain: Terrain,
    /// Objects that are declared, in the order of their declaration.
    pub found: Vec<Detection>,
    /// Objects that the operator has dismissed and that are not declared any more, by cell.
    pub dismissed: Vec<Find>,
    /// The operator's verdicts on both.
    pub verdicts: Verdicts,
    /// The operator's marks.
    pub marks: Marks,
    /// The best picture of each find, as far as robots have sent any.
    pub pictures: BTreeMap<Cell, Arc<Picture>>,
    /// The positions of finds, as far as robots know them.
    pub positions: BTreeMap<Cell, ObjectPosition>,
    /// The folder of their files, as the exported file names it: beside it.
    pub pictures_folder: String,
    /// The cells of each robot, in the order of its own clock; repeated where it waited.
    pub tracks: BTreeMap<RobotId, Vec<Visit>>,
    /// The plans of robots that move: position and cells to enter from there.
    pub plans: BTreeMap<RobotId, Plan>,
    /// Probability of detection of each cell, 0 to 1, shape `[cells]`; 0 where nothing is searched.
    pub pod: Vec<f64>,
    /// The whole search.
    pub total: Coverage,
    /// The drawn areas, and how thoroughly each was searched if robots can enter it and a cell of it is searched; and last
    /// the no-go zone by the operator's order, if there is one.
    pub areas: Vec<(Area, Option<Coverage>)>,
    /// The numbers of all areas that were searched, and of the whole search last.
    pub segments: Vec<SegmentRow>,
    /// The posterior of the subjects by which cells are declared, if their number is known.
    pub subject: Option<Standing>,
    /// Speed of a robot.
    speeds_meters_per_second: Vec<f64>,
}

/// The plan of a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Its last known cell.
    pub from: Cell,
    /// Cells that it enters, in order; at least one.
    pub path: Vec<Cell>,
}

impl Account {
    /// Reads a recording up to the time `until`, or to its end. `origin` is the position of the map's south-western
    /// corner, for a recording without a position on the earth.
    ///
    /// # Errors
    /// If the recording has no position on the earth and `origin` is `None`, or if both are given.
    pub fn new(
        playback: &Playback,
        origin: Option<GeoPoint>,
        until: Option<MissionTime>,
    ) -> Result<Self, ExportError> {
        let earth = earth(playback, origin)?;
        let mut fold = MissionFold::of(playback);
        // Messages after the search belong to it too.
        let taken = until.unwrap_or_else(|| playback.end());
        for (_, record) in playback.records.iter().take_while(|(time, _)| *time <= taken) {
            fold.take(record);
        }
        let until = until.unwrap_or_else(|| playback.searched_until());
        let detection_threshold = playback.detection_threshold();
        let pod = fold.probabilities_of_detection(detection_threshold);
        let frame = earth.frame;
        let subject = playback.subjects().map(|it| it.posterior(fold.belief()));
        let sensors = playback.sensors().unwrap_or_default();
        let segments = Segments::new(Some(&earth), &fold, playback.subjects(), detection_threshold, sensors);
        let table = segments.table(&fold, &pod, subject.as_ref());
        let terrain = fold.terrain().clone();
        let declared: BTreeSet<Cell> = fold.declared().iter().map(|object| object.cell).collect();
        let reach = reach(&fold, &playback.sights().unwrap_or_default());
        let standing =
            subject.as_ref().map(|it| it.standing(&terrain, &reach, |cell| declared.contains(&cell)));
        let closed = closed(fold.zones(), &terrain, &frame).map(|area| (area, None));
        let rows = segments.rows(&table);
        let areas = earth.areas.into_iter().zip(table.areas).chain(closed).collect();
        Ok(Self {
            name: playback.run.get("scenario").cloned().unwrap_or_else(|| "recording".to_owned()),
            start_unix_ns: playback.start_unix_ns,
            until,
            frame,
            found: found(&fold),
            dismissed: fold.finds().into_iter().filter(|find| !find.is_declared).collect(),
            verdicts: fold.verdicts().clone(),
            marks: fold.marks().clone(),
            pictures: fold.pictures().clone(),
            positions: positions(&fold),
            pictures_folder: "pictures".to_owned(),
            plans: plans(&fold),
            total: table.total,
            segments: rows,
            areas,
            tracks: fold.visits().robots().map(|(robot, it)| (robot, it.to_vec())).collect(),
            terrain,
            pod,
            subject: standing,
            speeds_meters_per_second: playback.of_robots("speed_meters_per_second").unwrap_or_default(),
        })
    }

    /// Speed of a robot, meters per second.
    #[must_use]
    pub fn speed_meters_per_second(&self, robot: RobotId) -> f64 {
        let known = self.speeds_meters_per_second.get(robot.index());
        known.copied().unwrap_or(USUAL_SPEED_METERS_PER_SECOND)
    }

    /// The path of a find's picture, from the exported file on, if there is one: `pictures/find-3-12.jpg` in row 3, column 12.
    #[must_use]
    pub fn picture_file(&self, cell: Cell) -> Option<String> {
        let Position { row, column } = self.terrain.grid().position(cell);
        self.pictures.contains_key(&cell).then(|| format!("{}/find-{row}-{column}.jpg", self.pictures_folder))
    }

    /// What the operator has decided about a find: `confirmed` or `dismissed`.
    #[must_use]
    pub fn operator(&self, cell: Cell) -> Option<&'static str> {
        self.verdicts.decision(cell).and_then(Decision::word)
    }

    /// The operator's clues that count, with their numbers, times and notes.
    pub(crate) fn clues(&self) -> impl Iterator<Item = (usize, MissionTime, Clue, String)> {
        self.marks
            .clues()
            .map(|(number, id, clue, marked)| (number, MissionTime(id), clue, marked.note.clone()))
    }

    /// What others have searched, likewise.
    pub(crate) fn searches(&self) -> impl Iterator<Item = (usize, MissionTime, Searched, String)> {
        let searches = self.marks.searches();
        searches.map(|(number, id, search, marked)| (number, MissionTime(id), search, marked.note.clone()))
    }

    /// The outline of cells.
    pub(crate) fn outline(&self, cells: &BTreeSet<Cell>) -> MultiPolygon<f64> {
        let is_inside: Vec<bool> = self.terrain.grid().cells().map(|cell| cells.contains(&cell)).collect();
        region(&self.terrain, &self.frame, &is_inside)
    }

    /// A clue's radius, meters.
    pub(crate) fn radius_meters(&self, clue: Clue) -> f64 {
        clue.radius_cells() * self.terrain.cell_meters()
    }

    /// Where a find is: its position if that is known, otherwise the center of its cell.
    #[must_use]
    pub fn place(&self, cell: Cell) -> GeoPoint {
        let position = self.positions.get(&cell);
        position.map_or_else(|| self.point(cell), |position| self.frame.point(position.meters()))
    }

    /// The center of a cell.
    #[must_use]
    pub fn point(&self, cell: Cell) -> GeoPoint {
        let position = self.terrain.grid().position(cell);
        let middle = |index: u32| (f64::from(index) + 0.5) * self.terrain.cell_meters();
        self.frame.point((middle(position.column), middle(position.row)))
    }
}

pub(crate) fn earth(playback: &Playback, origin: Option<GeoPoint>) -> Result<Earth, ExportError> {
    match (&playback.earth, origin) {
        (Some(earth), None) => Ok(earth.clone()),
        (None, Some(origin)) => Ok(Earth {
            // The frame of a ROS map has its x axis to the east.
            frame: Georeference::of_map(origin, &playback.terrain).turned(playback.origin.yaw_radians),
            areas: Vec::new(),
            expected_objects: playback.prior.iter().map(|&it| f64::from(it)).filter(|it| *it >= 0.0).sum(),
        }),
        (None, None) => Err(ExportError::NoOrigin),
        (Some(earth), Some(_)) => {
            let GeoPoint { latitude_degrees, longitude_degrees } = earth.frame.south_west();
            Err(ExportError::TwoOrigins { latitude_degrees, longitude_degrees })
        }
    }
}

/// What robots of these sights can observe; everything without them, as in older recordings.
fn reach(fold: &MissionFold, sights: &[Sight]) -> Reach {
    let terrain = fold.terrain();
    let mut reach = Reach::unknown(terrain.grid());
    for (robot, visits) in fold.visits().robots() {
        let Some(&sight) = sights.get(robot.index()) else { continue };
        for visit in visits {
            reach.add_robot(terrain, sight, visit.cell);
        }
    }
    reach
}

fn found(fold: &MissionFold) -> Vec<Detection> {
    let mut found = fold.declared().to_vec();
    found.sort_by_key(|object| (object.time_ns, object.cell));
    found
}

fn positions(fold: &MissionFold) -> BTreeMap<Cell, ObjectPosition> {
    let finds = fold.finds().into_iter();
    finds.filter_map(|find| Some((find.cell, *fold.position(find.cell)?))).collect()
}

fn plans(fold: &MissionFold) -> BTreeMap<RobotId, Plan> {
    let plan = |(robot, track): (RobotId, &Track)| {
        let path = track.plan.as_ref()?.path.clone();
        let (from, _) = track.pose?;
        (!path.is_empty()).then_some((robot, Plan { from, path: path.to_vec() }))
    };
    fold.tracks().robots().filter_map(plan).collect()
}

/// The no-go zone by the operator's order, as an area of the next search.
pub(crate) fn closed(zones: &Zones, terrain: &Terrain, frame: &Georeference) -> Option<Area> {
    zones.cells(Zone::NoGo).next()?;
    let is_closed: Vec<bool> =
        terrain.grid().cells().map(|cell| zones.of(cell) == Some(Zone::NoGo)).collect();
    let region = region(terrain, frame, &is_closed);
    let purpose = Purpose::NoGo(region, MultiLineString::new(Vec::new()));
    Some(Area { name: "No-go by order".to_owned(), purpose })
}
