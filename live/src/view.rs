//! The view: the contents of the page, folded from the coordinator's records one by one.
//!
//! It has no socket and no clock. Running and recorded missions use the same fold ([`dragnet_coordinator::fold`]), so
//! that the page shows the same state of both at the same mission time. The view adds the contents that only a page
//! shows: trails, the curve, and message rates.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use dragnet_coordinator::ending::Resting;
use dragnet_coordinator::finds::Finders;
use dragnet_coordinator::fold::{Change, MissionFold};
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::segment::{SegmentRow, Segments};
use dragnet_coordinator::standstill::Standstills;
use dragnet_coordinator::track::Track;
use dragnet_proto::message::{Activity, Detection, Heartbeat, MissionStatus};
use dragnet_proto::orders::RobotOrder;
use dragnet_scenario::Scenario;
use dragnet_scenario::map_file::Earth;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::{Belief, entropy_nats};
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Observation, RobotId, Source};
use dragnet_search::reach::{Reach, Sight};
use dragnet_search::sensor::Sensor;
use dragnet_search::subjects::{Standing, SubjectPosterior, Subjects};
use dragnet_search::terrain::Terrain;

use crate::curve::Curve;
use crate::orders::Orders;
use crate::searched::Searched;

/// The span of mission time over which message rates are computed.
const MESSAGE_SPAN: Duration = Duration::from_secs(10);
/// Number of cells of each robot's trail.
const TRAIL_CELLS: usize = 400;

/// Facts about a mission from before its start.
#[derive(Clone, Debug)]
pub struct About {
    /// Its name.
    pub name: String,
    /// The map.
    pub terrain: Arc<Terrain>,
    /// The prior probability of an object, shape `[cells]`, in single precision as in recordings.
    pub prior: Vec<f32>,
    /// What each robot sees from where, by [`RobotId::index`]; empty for older recordings, and then no cell is shown as
    /// out of reach.
    pub sights: Vec<Sight>,
    /// The sensor of each robot, by [`RobotId::index`]; empty for older recordings, and then the effort is unknown.
    pub sensors: Vec<Sensor>,
    /// The speed of each robot, by [`RobotId::index`]; empty for older recordings.
    pub speeds_meters_per_second: Vec<f64>,
    /// That the number of objects is known, if so.
    pub subjects: Option<Subjects>,
    /// Detection threshold.
    pub detection_threshold: f64,
    /// The robots of the team.
    pub team: Vec<RobotId>,
    /// The objects, if known, as in simulation.
    pub objects: Option<Vec<Cell>>,
    /// The map's position on the earth and the areas drawn on it, if known.
    pub earth: Option<Earth>,
}

impl About {
    /// The facts about a scenario's mission; `objects` are the objects, if known.
    #[must_use]
    pub fn of(scenario: &Scenario, objects: Option<Vec<Cell>>) -> Self {
        Self {
            name: scenario.name().to_owned(),
            terrain: Arc::new(scenario.terrain().clone()),
            prior: Self::prior_of(scenario.terrain(), scenario.prior()),
            sights: scenario.robots().iter().map(|robot| robot.class.sight()).collect(),
            sensors: scenario.robots().iter().map(|robot| robot.class.sensor.as_ref().clone()).collect(),
            speeds_meters_per_second: scenario
                .robots()
                .iter()
                .map(|robot| robot.class.speed_meters_per_second)
                .collect(),
            subjects: scenario.subjects(),
            detection_threshold: scenario.mission().detection_threshold,
            team: scenario.robots().iter().map(|robot| robot.id).collect(),
            objects,
            earth: scenario.earth(),
        }
    }

    /// The segments of the mission.
    fn segments(&self, fold: &MissionFold) -> Segments {
        let sensors = self.sensors.clone();
        Segments::new(self.earth.as_ref(), fold, self.subjects, self.detection_threshold, sensors)
    }

    /// The prior of a belief in the form of [`About::prior`].
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "recordings have single precision")]
    pub fn prior_of(terrain: &Terrain, prior: &Belief) -> Vec<f32> {
        terrain.grid().cells().map(|cell| prior.probability(cell) as f32).collect()
    }
}

/// The contents of the page.
#[derive(Clone, Debug)]
pub struct View {
    about: Arc<About>,
    fold: MissionFold,
    /// Cells that robots can observe, if their sensor radius is known.
    reach: Option<Reach>,
    now: MissionTime,
    robots: BTreeMap<RobotId, Walk>,
    entropy_nats: f64,
    searched: Searched,
    segments: Segments,
    /// What they are now, computed once for all viewers when it is asked for.
    segment_rows: OnceLock<Vec<SegmentRow>>,
    finders: Finders,
    curve: Curve,
    observations: u64,
    /// The operator's marks that recordings of earlier versions hold as observations.
    marks: u64,
    orders: Orders,
    resting: Resting,
    standstills: Standstills,
    /// Arrival times of messages, in the last [`MESSAGE_SPAN`].
    received: VecDeque<MissionTime>,
}

/// A robot's trail, and its last heartbeat.
#[derive(Clone, Debug, Default)]
pub struct Walk {
    /// The last cells that it was in.
    pub trail: VecDeque<Cell>,
    /// Number of cells that it was in, including those beyond the trail.
    pub steps: u64,
    /// Distance driven, meters.
    pub path_meters: f64,
    /// Its activity.
    pub activity: Option<Activity>,
    /// The time of its last heartbeat by its own clock, nanoseconds.
    reported_ns: u64,
}

/// The state of a robot on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It belongs to the team, and no message of it has arrived yet.
    Awaited,
    /// Its messages no longer arrive.
    Lost,
    /// It follows a plan.
    Searching,
    /// The operator has paused the search.
    Paused,
    /// The search is over.
    Cleared,
    /// Its budget is spent.
    Spent,
    /// No way is open: to no cell, or not to its base.
    Stuck,
    /// Its teammates are to observe all that is left, or to pass first.
    Waiting,
    /// It drives to its base.
    Returning,
    /// The operator has called it back, and it is at its base.
    Recalled,
    /// It drives to the cell to which the operator has sent it.
    Sent,
    /// It is in that cell, and waits for the next order.
    Holding,
    /// It leaves a no-go zone.
    Leaving,
    /// It makes way for its teammates.
    GivingWay,
}

impl State {
    /// Whether it follows a plan.
    const fn is_under_way(self) -> bool {
        matches!(
            self,
            Self::Searching | Self::Returning | Self::Recalled | Self::Sent | Self::Leaving | Self::GivingWay
        )
    }
}

impl View {
    /// A mission that has not started.
    #[must_use]
    pub fn new(about: Arc<About>) -> Self {
        let fold = MissionFold::new(&about.terrain, &about.prior);
        let mut view = Self {
            entropy_nats: fold.belief().entropy_nats(&about.terrain),
            now: MissionTime::START,
            searched: Searched::new(&fold, about.detection_threshold),
            segments: about.segments(&fold),
            segment_rows: OnceLock::new(),
            finders: Finders::new(about.detection_threshold),
            robots: about.team.iter().map(|&robot| (robot, Walk::default())).collect(),
            curve: Curve::default(),
            observations: 0,
            marks: 0,
            orders: Orders::default(),
            resting: Resting::default(),
            standstills: Standstills::new(about.terrain.cell_meters(), &about.speeds_meters_per_second),
            received: VecDeque::new(),
            reach: (!about.sights.is_empty()).then(|| Reach::unknown(about.terrain.grid())),
            fold,
            about,
        };
        view.plot();
        view
    }

    /// Applies a record of the coordinator at its time.
    pub fn take(&mut self, now: MissionTime, record: &Record) {
        self.pass(now);
        let seen = match record {
            Record::Observation(observation) => observation.readings.iter().map(|it| it.cell).collect(),
            Record::Verdicts(report) => report.verdicts.iter().map(|(cell, _)| cell).collect(),
            _ => Vec::new(),
        };
        self.orders.take(self.now, record);
        let before = self.entropy_of(&seen);
        let Change { moved, added, marked, .. } = self.fold.take(record);
        self.entropy_nats += self.entropy_of(&seen) - before + self.entropy_of(&added);
        self.searched.add(&self.fold, added.iter().copied());
        if !added.is_empty() {
            self.segments.cover(self.fold.terrain());
        }
        self.searched.update(&self.fold, &[seen, added].concat());
        if !marked.is_empty() {
            self.mark(&marked);
        }
        if matches!(
            record,
            Record::Observation(_) | Record::Status(_) | Record::Verdicts(_) | Record::Marks(_)
        ) {
            self.segment_rows = OnceLock::new();
        }
        if let Some((robot, cell)) = moved {
            self.walk(robot, cell);
        }
        match record {
            Record::Observation(observation) => self.observe(observation),
            Record::Intent(_) => self.received.push_back(self.now),
            Record::Heartbeat(heartbeat) => {
                self.resting.beat(heartbeat);
                self.standstills.beat(self.now, heartbeat);
                self.receive(heartbeat);
            }
            Record::Status(_) | Record::Verdicts(_) | Record::Marks(_) => self.plot(),
            // These follow from the records above, or are of [`Orders`] and the fold alone.
            Record::Orders(_)
            | Record::Zones(_)
            | Record::Pose { .. }
            | Record::Plan { .. }
            | Record::Picture(_)
            | Record::Belief(_)
            | Record::Began { .. } => {}
        }
    }

    /// Advances the time, which never goes back.
    pub fn pass(&mut self, now: MissionTime) {
        self.now = self.now.max(now);
        while self.received.front().is_some_and(|&received| received + MESSAGE_SPAN <= self.now) {
            self.received.pop_front();
        }
    }

    /// The operator's marks concern these cells.
    fn mark(&mut self, cells: &[Cell]) {
        // Marks are few: they may move any number of cells.
        self.entropy_nats = self.belief().entropy_nats(self.terrain());
        self.searched.update(&self.fold, cells);
        self.finders.credit(&self.fold, Source::Operator, cells.iter().copied());
    }

    fn observe(&mut self, observation: &Observation) {
        let cells = observation.readings.iter().map(|reading| reading.cell);
        self.finders.credit(&self.fold, observation.origin.source, cells);
        if let Source::Robot(robot) = observation.origin.source {
            self.received.push_back(self.now);
            self.observations += 1;
            self.robots.entry(robot).or_default();
            if let (Some(reach), Some(&sight)) = (&mut self.reach, self.about.sights.get(robot.index())) {
                reach.add_robot(self.fold.terrain(), sight, observation.from);
            }
        } else {
            self.marks += 1;
        }
        self.plot();
    }

    /// The entropy of these cells, all different, nats.
    fn entropy_of(&self, cells: &[Cell]) -> f64 {
        let searched = cells.iter().filter(|&&cell| self.fold.terrain().is_searched(cell));
        searched.map(|&cell| entropy_nats(self.fold.belief().log_odds_nats(cell))).sum()
    }

    fn walk(&mut self, robot: RobotId, cell: Cell) {
        let walk = self.robots.entry(robot).or_default();
        walk.trail.push_back(cell);
        walk.steps += 1;
        if walk.trail.len() > TRAIL_CELLS {
            walk.trail.pop_front();
        }
    }

    fn receive(&mut self, heartbeat: &Heartbeat) {
        self.received.push_back(self.now);
        let walk = self.robots.entry(heartbeat.robot).or_default();
        if heartbeat.time_ns >= walk.reported_ns {
            walk.reported_ns = heartbeat.time_ns;
            walk.activity = Some(heartbeat.activity);
            walk.path_meters = heartbeat.path_meters;
        }
    }

    fn plot(&mut self) {
        self.curve.push(self.now.as_seconds(), [self.entropy_nats, self.progress()]);
    }

    /// Recall if the objects are known, counting those in reach; otherwise the number of declared objects.
    pub(crate) fn progress(&self) -> f64 {
        match &self.about.objects {
            Some(objects) => {
                let in_reach = || objects.iter().filter(|&&cell| !self.is_out_of_reach(cell));
                let is_found = |cell: &&Cell| self.belief().is_found(**cell, self.about.detection_threshold);
                let count = in_reach().count();
                if count == 0 { 1.0 } else { in_reach().filter(is_found).count() as f64 / count as f64 }
            }
            None => self.declared().len() as f64,
        }
    }

    /// Facts about the mission from before its start.
    #[must_use]
    pub fn about(&self) -> &About {
        &self.about
    }

    /// The state that follows from the records so far.
    #[must_use]
    pub const fn fold(&self) -> &MissionFold {
        &self.fold
    }

    /// The map, with the cells that the operator has added.
    #[must_use]
    pub const fn terrain(&self) -> &Terrain {
        self.fold.terrain()
    }

    /// The belief.
    #[must_use]
    pub const fn belief(&self) -> &Belief {
        self.fold.belief()
    }

    /// Where the subjects are, if their number is known.
    #[must_use]
    pub fn subject(&self) -> Option<SubjectPosterior> {
        self.about.subjects.map(|it| it.posterior(self.belief()))
    }

    /// The posterior of the subjects by which cells are declared, if their number is known.
    #[must_use]
    pub fn standing(&self) -> Option<Standing> {
        let declared: BTreeSet<Cell> = self.declared().iter().map(|object| object.cell).collect();
        let everywhere = Reach::unknown(self.terrain().grid());
        let reach = self.reach.as_ref().unwrap_or(&everywhere);
        Some(self.subject()?.standing(self.terrain(), reach, |cell| declared.contains(&cell)))
    }

    /// The robots that are not known to be back, if the mission is ending.
    #[must_use]
    pub fn ending(&self) -> Option<Vec<RobotId>> {
        let is_called = |robot| self.orders.current(robot) == RobotOrder::Return;
        self.resting.awaited(self.about.team.iter().copied(), &self.status()?.directive, is_called)
    }

    /// Cells that robots can observe, if their sensor radius is known.
    #[must_use]
    pub const fn reach(&self) -> Option<&Reach> {
        self.reach.as_ref()
    }

    /// Whether a cell is searched and out of reach of all robots.
    #[must_use]
    pub fn is_out_of_reach(&self, cell: Cell) -> bool {
        self.terrain().is_searched(cell) && self.reach.as_ref().is_some_and(|reach| !reach.covers(cell))
    }

    /// Whose observation made a cell reach the detection threshold, if it does.
    #[must_use]
    pub fn finder(&self, cell: Cell) -> Option<Source> {
        self.finders.of(cell)
    }

    /// The probability of detection of a cell, 0 to 1; `None` if it was never observed.
    #[must_use]
    pub fn pod(&self, cell: Cell) -> Option<f64> {
        let is_seen = self.belief().evidence().of(cell).precision > 0 || self.searched.pod(cell) > 0.0;
        (is_seen && self.terrain().is_searched(cell)).then(|| self.searched.pod(cell))
    }

    /// How thoroughly each segment was searched, and the whole search last, with the posterior of the subjects, if
    /// their number is known.
    #[must_use]
    pub fn segments(&self, subject: Option<&SubjectPosterior>) -> &[SegmentRow] {
        let table = || self.segments.table(&self.fold, self.searched.pods(), subject);
        self.segment_rows.get_or_init(|| self.segments.rows(&table()))
    }

    /// The probability of detection of the whole search: the mean over its cells, weighted by their prior.
    #[must_use]
    pub fn total_pod(&self) -> f64 {
        self.searched.total()
    }

    /// The mission's time.
    #[must_use]
    pub const fn now(&self) -> MissionTime {
        self.now
    }

    /// Entropy of the whole map, nats.
    #[must_use]
    pub const fn entropy_nats(&self) -> f64 {
        self.entropy_nats
    }

    /// The last status.
    #[must_use]
    pub const fn status(&self) -> Option<&MissionStatus> {
        self.fold.status()
    }

    /// Numbers of observations of robots and of operator marks.
    #[must_use]
    pub fn counts(&self) -> (u64, u64) {
        (self.observations, self.marks + self.fold.marks().standing().count() as u64)
    }

    /// The operator's last commands, and who has them.
    #[must_use]
    pub const fn orders(&self) -> &Orders {
        &self.orders
    }

    /// Declared objects.
    #[must_use]
    pub fn declared(&self) -> &[Detection] {
        self.fold.declared()
    }

    /// Each robot, by number: its trail, its track, and its state.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, &Walk, Track, State)> + '_ {
        self.robots.iter().map(|(&robot, walk)| {
            let track = self.fold.tracks().of(robot).cloned().unwrap_or_default();
            (robot, walk, track, self.state(robot, walk))
        })
    }

    /// For how long a robot that drives has entered no cell, if that is longer than usual.
    #[must_use]
    pub fn stands_for(&self, robot: RobotId, state: State) -> Option<Duration> {
        let standstill = self.standstills.of(robot).filter(|_| state.is_under_way());
        standstill.map(|standstill| standstill.lasts)
    }

    /// When a robot is expected in each cell of its plan, seconds of mission time; empty if its speed is unknown, or it does
    /// not drive.
    #[must_use]
    pub fn expected_seconds(&self, robot: RobotId, track: &Track, state: State) -> Vec<u64> {
        let speed = self.about.speeds_meters_per_second.get(robot.index());
        let Some(speed) = speed.filter(|_| state.is_under_way()) else { return Vec::new() };
        let terrain = self.terrain();
        let expected = track.expected(self.now, terrain.grid(), speed / terrain.cell_meters());
        expected.into_iter().map(|(_, time)| time.0 / 1_000_000_000).collect()
    }

    fn state(&self, robot: RobotId, walk: &Walk) -> State {
        let is_alive = self.status().is_none_or(|status| status.alive.contains(&robot));
        match walk.activity {
            None if walk.steps == 0 => State::Awaited,
            _ if !is_alive => State::Lost,
            None | Some(Activity::Searching) => State::Searching,
            Some(Activity::Paused) => State::Paused,
            Some(Activity::Cleared) => State::Cleared,
            Some(Activity::Spent) => State::Spent,
            Some(Activity::Stuck) => State::Stuck,
            Some(Activity::Waiting) => State::Waiting,
            Some(Activity::Returning) => State::Returning,
            Some(Activity::Recalled) => State::Recalled,
            Some(Activity::Sent) => State::Sent,
            Some(Activity::Holding) => State::Holding,
            Some(Activity::Leaving) => State::Leaving,
            Some(Activity::GivingWay) => State::GivingWay,
        }
    }

    /// Messages of robots per second of mission time.
    #[must_use]
    pub fn messages_per_second(&self) -> f64 {
        let span = self.now.as_seconds().clamp(1.0, MESSAGE_SPAN.as_secs_f64());
        self.received.len() as f64 / span
    }

    pub(crate) fn curve(&self) -> &[[f64; 3]] {
        self.curve.points()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_proto::directive::Directive;
    use dragnet_proto::message::Intent;
    use dragnet_search::evidence::Digest;

    use super::*;

    #[test]
    fn a_robot_that_drives_and_enters_no_cell_stands_until_it_is_lost() {
        let text = "name = 'lane'\nmap = { shape = 'all_traversable', rows = 1, columns = 4, cell_meters = 10.0 }\n\
                    objects.count = 1\nsensor.radius = 2\n[mission]\nbudget_seconds = 900.0\nspeed_meters_per_second = 10.0\n";
        let scenario = Scenario::from_text(Path::new("lane.toml"), text.to_owned()).unwrap();
        let mut view = View::new(Arc::new(About::of(&scenario, None)));
        let cell = scenario.terrain().grid().cells().next().unwrap();
        let (robot, time_ns) = (RobotId::FIRST, 0);
        let intent = Intent { robot, incarnation: 0, decision: 1, time_ns, path: vec![cell].into() };
        let heartbeat = Heartbeat {
            robot,
            time_ns,
            activity: Activity::Searching,
            cell,
            path_meters: 10.0,
            intent,
            versions: Vec::new().into(),
            digest: Digest(0),
            directive: Directive::default(),
        };
        let mut told = Vec::new();
        for minute in 0..3 {
            for second in (0..60).step_by(5) {
                let now = MissionTime::START + Duration::from_secs(60 * minute + second);
                view.take(now, &Record::Heartbeat(heartbeat.clone()));
            }
            told.extend(view.stands_for(robot, State::Searching).map(|lasts| lasts.as_secs()));
        }
        assert_eq!(told, [115, 175]);
        assert_eq!(view.stands_for(robot, State::Lost), None);
    }
}
