//! The state of a mission from its records: the belief with added areas and marks, finds, positions and plans.
//!
//! The live page, `replay`, `export` and Python all use this fold, so that they show the same state.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::finds::{Find, finds};
use dragnet_proto::directive::added_prior;
use dragnet_proto::marks::Marks;
use dragnet_proto::message::{Detection, MissionStatus};
use dragnet_proto::picture::Picture;
use dragnet_proto::verdict::Verdicts;
use dragnet_proto::zones::Zones;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::detection::probability_of_detection;
use dragnet_search::object_position::{ObjectPosition, ObjectPositions};
use dragnet_search::observation::{Observation, RobotId, Source};
use dragnet_search::terrain::Terrain;

use crate::mission::Record;
use crate::playback::{Playback, prior_belief};
use crate::track::Tracks;
use crate::visits::{Visit, Visits};

/// The state of a mission after its records so far.
#[derive(Clone, Debug)]
pub struct MissionFold {
    terrain: Terrain,
    belief: Belief,
    /// The log-odds before any reading or added cell, shape `[cells]`.
    prior: Arc<[f64]>,
    /// Prior probability in cells that the operator adds.
    added_prior: f64,
    tracks: Tracks,
    status: Option<MissionStatus>,
    verdicts: Verdicts,
    zones: Zones,
    marks: Marks,
    /// The best picture of each find.
    pictures: BTreeMap<Cell, Arc<Picture>>,
    visits: Visits,
    positions: ObjectPositions,
    /// Of the cells that marks concern: probability that the searches of others would have detected an object.
    pod_of_others: BTreeMap<Cell, f64>,
}

/// The changes caused by a record.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// The robot that has moved, and its cell.
    pub moved: Option<(RobotId, Cell)>,
    /// Cells that were added to the search area.
    pub added: Vec<Cell>,
    /// Cells with a new verdict of the operator.
    pub judged: Vec<Cell>,
    /// Cells that new marks of the operator concern.
    pub marked: Vec<Cell>,
}

impl MissionFold {
    /// The state of a mission before its first record. `prior` has shape `[cells]`: probabilities, 0 where nothing is
    /// searched.
    #[must_use]
    pub fn new(terrain: &Terrain, prior: &[f32]) -> Self {
        let belief = prior_belief(terrain, prior);
        Self {
            added_prior: added_prior(&belief, terrain),
            terrain: terrain.clone(),
            prior: belief.shared_prior(),
            belief,
            tracks: Tracks::default(),
            status: None,
            verdicts: Verdicts::default(),
            zones: Zones::default(),
            marks: Marks::default(),
            pictures: BTreeMap::new(),
            visits: Visits::default(),
            positions: ObjectPositions::default(),
            pod_of_others: BTreeMap::new(),
        }
    }

    /// The state of a recorded mission before its first record.
    #[must_use]
    pub fn of(playback: &Playback) -> Self {
        Self::new(&playback.terrain, &playback.prior)
    }

    /// Applies the next record.
    pub fn take(&mut self, record: &Record) -> Change {
        match record {
            Record::Observation(observation) => self.observe(observation),
            Record::Intent(intent) => {
                self.tracks.plans(intent);
                Change::default()
            }
            Record::Heartbeat(heartbeat) => {
                self.tracks.plans(&heartbeat.intent);
                let time = MissionTime(heartbeat.time_ns);
                let has_moved = self.tracks.at(heartbeat.robot, heartbeat.cell, time);
                Change { moved: has_moved.then_some((heartbeat.robot, heartbeat.cell)), ..Change::default() }
            }
            Record::Status(status) => self.stand(status),
            // Those of robots say what they have received.
            Record::Verdicts(report) if report.from != Participant::Coordinator => Change::default(),
            Record::Verdicts(report) => {
                let judged = self.verdicts.take(report.verdicts.iter(), &mut self.belief);
                Change { judged, ..Change::default() }
            }
            Record::Marks(report) => {
                if report.from != Participant::Coordinator {
                    return Change::default();
                }
                let (grid, now) = (self.terrain.grid(), MissionTime(report.time_ns));
                let marked = self.marks.merge_into(now, &report.marks, grid, &self.prior, &mut self.belief);
                let marked = marked.unwrap_or_default();
                self.pod_of_others.extend(self.marks.probability_of_detection(&marked));
                Change { marked: marked.into_iter().collect(), ..Change::default() }
            }
            Record::Zones(report) => {
                if report.from == Participant::Coordinator {
                    self.zones = report.zones.clone();
                }
                Change::default()
            }
            // Orders are what robots are to do: what they do is in their plans. The others follow from the records above.
            Record::Orders(_)
            | Record::Pose { .. }
            | Record::Plan { .. }
            | Record::Belief(_)
            | Record::Began { .. } => Change::default(),
            Record::Picture(picture) => {
                self.pictures.insert(picture.facts.cell, Arc::clone(picture));
                Change::default()
            }
        }
    }

    /// In recordings of earlier versions marks of the operator are observations: evidence, but not part of a track.
    fn observe(&mut self, observation: &Observation) -> Change {
        for reading in &observation.readings {
            self.belief.add(reading);
        }
        self.positions.add(observation);
        let Source::Robot(robot) = observation.origin.source else { return Change::default() };
        let time = MissionTime(observation.time_ns);
        self.visits.add(self.terrain.grid(), robot, Visit { time, cell: observation.from });
        let has_moved = self.tracks.at(robot, observation.from, time);
        Change { moved: has_moved.then_some((robot, observation.from)), ..Change::default() }
    }

    fn stand(&mut self, status: &MissionStatus) -> Change {
        let added = status.directive.added.iter().copied();
        let added = self.belief.search_also(&mut self.terrain, added, self.added_prior);
        let robots: Vec<RobotId> = self.tracks.robots().map(|(robot, _)| robot).collect();
        for robot in robots.into_iter().filter(|robot| !status.alive.contains(robot)) {
            self.tracks.lapses(robot);
        }
        self.status = Some(status.clone());
        Change { added, ..Change::default() }
    }

    /// The map, with the cells that the operator has added.
    #[must_use]
    pub const fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// The belief after all readings so far; its prior includes the added cells.
    #[must_use]
    pub const fn belief(&self) -> &Belief {
        &self.belief
    }

    /// The best picture of each find, if robots have sent any.
    #[must_use]
    pub const fn pictures(&self) -> &BTreeMap<Cell, Arc<Picture>> {
        &self.pictures
    }

    /// The position of the object that is declared in a cell, if a robot knows it.
    #[must_use]
    pub fn position(&self, cell: Cell) -> Option<&ObjectPosition> {
        self.positions.of(cell)
    }

    /// Positions and plans of robots.
    #[must_use]
    pub const fn tracks(&self) -> &Tracks {
        &self.tracks
    }

    /// Where robots have observed.
    #[must_use]
    pub const fn visits(&self) -> &Visits {
        &self.visits
    }

    /// The last status.
    #[must_use]
    pub const fn status(&self) -> Option<&MissionStatus> {
        self.status.as_ref()
    }

    /// The operator's zones.
    #[must_use]
    pub const fn zones(&self) -> &Zones {
        &self.zones
    }

    /// The operator's marks.
    #[must_use]
    pub const fn marks(&self) -> &Marks {
        &self.marks
    }

    /// Probability that the searches of others, as the operator has marked them, would have detected an object in a cell.
    #[must_use]
    pub fn pod_of_others(&self, cell: Cell) -> f64 {
        self.pod_of_others.get(&cell).copied().unwrap_or(0.0)
    }

    /// Probability that robots and others would have detected an object in a cell by now, with this detection threshold.
    #[must_use]
    pub fn probability_of_detection(&self, cell: Cell, detection_threshold: f64) -> f64 {
        let (prior, evidence) = (self.belief.prior_log_odds_nats(cell), self.belief.evidence().of(cell));
        let missed = 1.0 - probability_of_detection(prior, evidence, detection_threshold);
        1.0 - missed * (1.0 - self.pod_of_others(cell))
    }

    /// The same of each cell, shape `[cells]`.
    #[must_use]
    pub fn probabilities_of_detection(&self, detection_threshold: f64) -> Vec<f64> {
        let cells = self.terrain.grid().cells();
        cells.map(|cell| self.probability_of_detection(cell, detection_threshold)).collect()
    }

    /// The operator's verdicts.
    #[must_use]
    pub const fn verdicts(&self) -> &Verdicts {
        &self.verdicts
    }

    /// Declared and dismissed objects.
    #[must_use]
    pub fn finds(&self) -> Vec<Find> {
        finds(self.declared(), &self.verdicts)
    }

    /// Objects that are declared now.
    #[must_use]
    pub fn declared(&self) -> &[Detection] {
        self.status.as_ref().map_or(&[], |status| &status.declared)
    }
}
