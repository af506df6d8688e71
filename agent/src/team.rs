//! A robot's knowledge of its teammates: which are alive, and their plans.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::message::Intent;
use dragnet_proto::validation::Limits;
use dragnet_scenario::Class;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::intent::{PlannedPrecision, TeammatePlan};
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::observation::RobotId;
use dragnet_search::terrain::Terrain;

use crate::clearance::Other;

/// The teammates that messages have been received from.
#[derive(Clone, Debug, Default)]
pub struct Team {
    /// By [`RobotId::index`].
    mates: Vec<Option<Teammate>>,
    /// Number of changes of their plans.
    changes: u64,
    /// Where those that are lost were last.
    lost: BTreeMap<RobotId, Cell>,
}

#[derive(Clone, Debug)]
struct Teammate {
    last_received: MissionTime,
    /// Where it observed last.
    cell: Option<Cell>,
    /// When its newest message was sent that says where it is, and that cell.
    place: Option<(u64, Cell)>,
    /// The last plan received, without the cells entered since.
    plan: Option<Intent>,
    /// When it last made a plan or progress on it.
    last_progress: MissionTime,
    /// Whether that was too long ago: it may be stopped, and its plan does not count until it makes progress.
    is_stalled: bool,
}

impl Teammate {
    fn has_gone_on(&mut self, now: MissionTime) {
        self.last_progress = self.last_progress.max(now);
        self.is_stalled = false;
    }
}

/// What turns teammates' plans into planned observations.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The map.
    pub terrain: &'a Terrain,
    /// What is hidden from robots on the ground.
    pub line_of_sight: &'a LineOfSight,
    /// The robot's class.
    pub class: &'a Class,
    /// Classes of the team.
    pub limits: &'a Limits,
    /// Now.
    pub now: MissionTime,
}

impl Team {
    /// Number of changes of the team's plans: new plans, progress on them, and plans that lapsed.
    #[must_use]
    pub const fn changes(&self) -> u64 {
        self.changes
    }

    /// Whether any teammate has cells left to enter.
    #[must_use]
    pub fn is_anything_planned(&self) -> bool {
        self.plans_of_all().any(|plan| !plan.path.is_empty())
    }

    /// Whether a teammate is alive, as far as known.
    #[must_use]
    pub fn is_alive(&self, robot: RobotId) -> bool {
        self.heard(robot).is_some()
    }

    /// When a message of a teammate that is alive arrived last.
    #[must_use]
    pub fn heard(&self, robot: RobotId) -> Option<MissionTime> {
        Some(self.mates.get(robot.index())?.as_ref()?.last_received)
    }

    /// Records that a message of a teammate has arrived.
    pub fn received(&mut self, now: MissionTime, robot: RobotId) {
        self.mate(now, robot);
    }

    /// Records a teammate's plan: a newer plan replaces the older one, and a repeated plan reports progress. Returns
    /// whether anything changed.
    pub fn plans(&mut self, now: MissionTime, intent: &Intent) -> bool {
        let mate = self.mate(now, intent.robot);
        let known = mate.plan.as_ref();
        let is_newer = known.is_none_or(|known| intent.is_newer_than(known));
        if known.is_none_or(|known| intent.supersedes(known)) {
            mate.plan = Some(intent.clone());
            mate.has_gone_on(now);
            self.changes += 1;
        }
        is_newer
    }

    /// Records that a teammate has observed from a cell: its plan up to that cell is done.
    pub fn walked(&mut self, now: MissionTime, robot: RobotId, cell: Cell) {
        let mate = self.mate(now, robot);
        mate.cell = Some(cell);
        if let Some(plan) = &mut mate.plan
            && let Some(place) = plan.path.iter().position(|&planned| planned == cell)
        {
            plan.path.enter(place + 1);
            mate.has_gone_on(now);
            self.changes += 1;
        }
    }

    /// Records that a teammate's message of this time says that it is in a cell.
    pub fn is_at(&mut self, now: MissionTime, robot: RobotId, time_ns: u64, cell: Cell) {
        let mate = self.mate(now, robot);
        if mate.place.is_none_or(|(newest, _)| newest <= time_ns) {
            mate.place = Some((time_ns, cell));
        }
    }

    /// The ways of those teammates that a robot of the view's class could come too near to: of those that stand, and of those
    /// that made their plans before `since`. The others knew this robot's way.
    pub(crate) fn others(&self, view: View<'_>, since: (MissionTime, RobotId)) -> Vec<Other> {
        let other = |(robot, mate): (RobotId, &Teammate)| {
            let class = view.limits.class(robot.into())?;
            if class.flies != view.class.flies {
                return None;
            }
            let (_, cell) = mate.place?;
            let plan = mate.plan.as_ref().filter(|plan| !mate.is_stalled && !plan.path.is_empty());
            if plan.is_some_and(|plan| (MissionTime(plan.time_ns), robot) >= since) {
                return None;
            }
            let step = view.terrain.cell_meters() / class.speed_meters_per_second;
            let elapsed = view.now.since(mate.last_progress).as_secs_f64();
            Some(Other { cell, path: plan.map_or_else(Vec::new, |plan| plan.path.to_vec()), elapsed, step })
        };
        self.known().filter_map(other).collect()
    }

    /// Cells of teammates of the view's class, flying or not, that are not under way.
    pub(crate) fn standing(&self, view: View<'_>) -> impl Iterator<Item = Cell> {
        let stands =
            |mate: &&Teammate| mate.is_stalled || mate.plan.as_ref().is_none_or(|plan| plan.path.is_empty());
        self.known().filter(move |(_, mate)| stands(mate)).filter_map(move |(robot, mate)| {
            let class = view.limits.class(robot.into())?;
            (class.flies == view.class.flies).then_some(mate.place?.1)
        })
    }

    /// Removes a lost teammate and its plan.
    pub fn lost(&mut self, robot: RobotId) {
        if let Some(mate) = self.mates.get_mut(robot.index()).and_then(Option::take) {
            self.changes += 1;
            self.lost.extend(mate.place.map(|(_, cell)| (robot, cell)));
        }
    }

    /// Where the teammates of the view's class that are lost, flying or not, were last.
    pub(crate) fn last_places(&self, view: View<'_>) -> impl Iterator<Item = Cell> {
        let flies = move |&robot: &RobotId| Some(view.limits.class(robot.into())?.flies);
        self.lost
            .iter()
            .filter(move |(robot, _)| flies(robot) == Some(view.class.flies))
            .map(|(_, &cell)| cell)
    }

    /// Drops teammates that were silent for longer than `silence`, and disregards the plans of those that made no
    /// progress for longer than their `stillness`, which is no shorter.
    pub fn review(&mut self, now: MissionTime, silence: Duration, stillness: impl Fn(RobotId) -> Duration) {
        let mut is_any_silent = false;
        let numbered = (1..=u16::MAX).filter_map(RobotId::new).zip(&mut self.mates);
        for (robot, place) in numbered {
            let Some(mate) = place else { continue };
            if now > mate.last_received + silence {
                self.lost.extend(mate.place.map(|(_, cell)| (robot, cell)));
                *place = None;
                is_any_silent = true;
                continue;
            }
            let has_stalled = !mate.is_stalled
                && now > mate.last_progress + silence
                && now > mate.last_progress + stillness(robot);
            mate.is_stalled |= has_stalled;
            self.changes += u64::from(has_stalled);
        }
        self.changes += u64::from(is_any_silent);
    }

    /// Teammates that are alive.
    pub fn alive(&self) -> impl Iterator<Item = RobotId> + '_ {
        self.known().map(|(robot, _)| robot)
    }

    /// The observations on the paths of all plans.
    #[must_use]
    pub fn planned(&self, view: View<'_>) -> PlannedPrecision {
        let mut planned = PlannedPrecision::nothing(view.terrain);
        for (robot, mate) in self.known().filter(|(_, mate)| !mate.is_stalled) {
            let Some(plan) = &mate.plan else { continue };
            let elapsed = view.now.since(mate.last_progress).as_secs_f64();
            let class = view.limits.class(robot.into());
            let member = class.and_then(|_| u16::try_from(robot.index()).ok());
            let class = class.unwrap_or(view.class);
            let plan = TeammatePlan {
                member,
                cell: mate.cell,
                path: plan.path.clone(),
                driven_cells: elapsed * (class.speed_meters_per_second / view.terrain.cell_meters()),
                sensor: Arc::clone(&class.sensor),
                line_of_sight: if class.flies {
                    LineOfSight::everywhere()
                } else {
                    view.line_of_sight.clone()
                },
                pace: class.speed_meters_per_second / view.class.speed_meters_per_second,
            };
            planned.add_plan(view.terrain, plan);
        }
        planned
    }

    fn plans_of_all(&self) -> impl Iterator<Item = &Intent> {
        let mates = self.known().filter(|(_, mate)| !mate.is_stalled);
        mates.filter_map(|(_, mate)| mate.plan.as_ref())
    }

    fn known(&self) -> impl Iterator<Item = (RobotId, &Teammate)> {
        let numbered = (1..=u16::MAX).filter_map(RobotId::new).zip(&self.mates);
        numbered.filter_map(|(robot, mate)| Some((robot, mate.as_ref()?)))
    }

    fn mate(&mut self, now: MissionTime, robot: RobotId) -> &mut Teammate {
        self.lost.remove(&robot);
        if robot.index() >= self.mates.len() {
            self.mates.resize(robot.index() + 1, None);
        }
        let mate = self.mates[robot.index()].get_or_insert(Teammate {
            last_received: now,
            cell: None,
            place: None,
            plan: None,
            last_progress: now,
            is_stalled: false,
        });
        mate.last_received = mate.last_received.max(now);
        mate
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_scenario::Scenario;
    use dragnet_search::sensor::{Noise, Sensor};

    use super::*;

    const MATE: RobotId = RobotId::new(2).unwrap();

    struct Field {
        terrain: Terrain,
        classes: Vec<Arc<Class>>,
        limits: Limits,
        team: Team,
    }

    impl Field {
        fn new() -> Self {
            let terrain = Terrain::from_ascii("......", 1.0).unwrap();
            let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 1, columns = 6, cell_meters = 1.0 }\n\
                        objects.count = 1\nsensor.radius = 1\nrobots.count = 2\n\
                        mission = { budget_seconds = 60.0, speed_meters_per_second = 0.5 }\n";
            let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
            let classes = scenario.robots().iter().map(|robot| Arc::clone(&robot.class)).collect();
            Self { terrain, classes, limits: Limits::of(&scenario), team: Team::default() }
        }

        fn cells(&self, numbers: impl IntoIterator<Item = u32>) -> Vec<Cell> {
            numbers.into_iter().map(|number| self.terrain.grid().cell_numbered(number).unwrap()).collect()
        }

        fn plans(&mut self, decision: u64, path: impl IntoIterator<Item = u32>) {
            let path = self.cells(path);
            self.team.plans(
                MissionTime::START,
                &Intent { robot: MATE, incarnation: 0, decision, time_ns: 0, path: path.into() },
            );
        }

        fn view(&self, now: MissionTime) -> View<'_> {
            let (terrain, line_of_sight) = (&self.terrain, self.terrain.line_of_sight());
            View { terrain, line_of_sight, class: &self.classes[0], limits: &self.limits, now }
        }

        fn check(&self, expected: impl IntoIterator<Item = u32>) {
            let mut expected_precision = PlannedPrecision::nothing(&self.terrain);
            let path = self.cells(expected);
            expected_precision.add_path(&self.terrain, &self.classes[0].sensor, &path);
            let planned_precision = self.team.planned(self.view(MissionTime::START));
            for cell in self.terrain.grid().cells() {
                assert_eq!(planned_precision.precision(cell), expected_precision.precision(cell), "{cell:?}");
            }
            let paths = planned_precision.plans().iter().flat_map(|plan| plan.path.iter().copied());
            assert_eq!(paths.collect::<Vec<_>>(), path);
        }
    }

    #[test]
    fn a_plan_shrinks_as_it_is_walked_and_lapses_when_replaced_or_lost() {
        let mut field = Field::new();
        field.plans(0, 0..5);
        field.check(0..5);
        let third = field.cells([2])[0];
        field.team.walked(MissionTime::START, MATE, third);
        field.check(3..5);
        field.plans(1, [1]);
        field.check([1]);
        field.team.lost(MATE);
        field.check([]);
    }

    #[test]
    fn a_plan_that_comes_late_or_twice_brings_nothing_back() {
        let mut field = Field::new();
        field.plans(3, 0..5);
        field.plans(2, 0..2);
        field.check(0..5);
        field.plans(3, 4..5);
        field.plans(3, 0..5);
        field.check(4..5);
    }

    /// Its messages may be lost: it is taken to go on along the last plan.
    #[test]
    fn a_teammate_that_is_not_heard_goes_on_along_its_plan() {
        let mut field = Field::new();
        field.plans(0, 0..5);
        let at = |seconds: u64| MissionTime(seconds * 1_000_000_000);
        let first = field.cells([0])[0];
        field.team.walked(at(4), MATE, first);
        let planned_precision = field.team.planned(field.view(at(10)));
        let plan = &planned_precision.plans()[0];
        assert_eq!((plan.member, plan.cell), (Some(1), Some(first)));
        assert_eq!((plan.path.len(), plan.driven_cells), (4, 3.0));
    }

    #[test]
    fn the_plan_of_an_unlike_teammate_is_driven_at_its_speed_and_seen_with_its_sensor() {
        let mut field = Field::new();
        let (speed_meters_per_second, sensor) = (1.5, Sensor::new(3, 0.02, Noise::Gaussian).unwrap());
        let class =
            Class { speed_meters_per_second, sensor: Arc::new(sensor), ..(*field.classes[1]).clone() };
        field.classes[1] = Arc::new(class);
        let team = (1..).filter_map(RobotId::new).zip(field.classes.iter().cloned());
        field.limits = Limits::new(Arc::new(field.terrain.clone()), team, Duration::ZERO);
        field.plans(0, 0..5);
        let planned_precision = field.team.planned(field.view(MissionTime(2_000_000_000)));
        let plan = &planned_precision.plans()[0];
        assert_eq!((plan.driven_cells, plan.pace, plan.sensor.radius()), (3.0, 3.0, 3));
        let mut expected = PlannedPrecision::nothing(&field.terrain);
        expected.add_path(&field.terrain, &field.classes[1].sensor, &field.cells(0..5));
        let seen = |of: &PlannedPrecision| {
            field.terrain.grid().cells().map(|cell| of.precision(cell)).collect::<Vec<_>>()
        };
        assert_eq!(seen(&planned_precision), seen(&expected));
    }

    #[test]
    fn a_robot_that_is_silent_for_too_long_is_lost() {
        let mut field = Field::new();
        field.plans(0, 0..5);
        let (silence, stillness) = (Duration::from_secs(30), Duration::from_secs(90));
        field.team.review(MissionTime::START + silence, silence, |_| stillness);
        field.check(0..5);
        field.team.review(MissionTime(30_000_000_001), silence, |_| stillness);
        field.check([]);
        assert_eq!(field.team.alive().count(), 0);
    }

    #[test]
    fn the_plan_of_a_stalled_robot_does_not_count_until_it_goes_on() {
        let mut field = Field::new();
        field.plans(0, 0..5);
        let at = |seconds: u64| MissionTime(seconds * 1_000_000_000);
        let (silence, stillness) = (Duration::from_secs(30), Duration::from_secs(90));
        let (third, changes) = (field.cells([2])[0], field.team.changes());
        field.team.received(at(91), MATE);
        field.team.review(at(90), silence, |_| stillness);
        assert!(field.team.is_anything_planned());
        field.team.review(at(91), silence, |_| stillness);
        field.check([]);
        assert!(!field.team.is_anything_planned());
        field.team.review(at(92), silence, |_| stillness);
        assert_eq!(field.team.changes(), changes + 1, "reported once");
        field.team.walked(at(92), MATE, third);
        field.check(3..5);
        assert_eq!(field.team.changes(), changes + 2);
    }
}
