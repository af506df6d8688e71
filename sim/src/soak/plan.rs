//! The search of a seed, and its faults.

use std::fmt::Write;
use std::iter;
use std::ops::Range;
use std::path::Path;
use std::time::Duration;

use dragnet_proto::command::Command;
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::Zone;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Scenario, ScenarioError};
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::generated::Generated;
use dragnet_search::mark::{Clue, Mark, Searched};
use dragnet_search::observation::RobotId;
use dragnet_search::policy::PolicyName;
use dragnet_search::seed::{Purpose, Stream, stream};
use rand::RngExt;

use crate::faults::{Crash, Faults, Memory, OneWayLoss};

/// Sides of a map, cells: small, so that thousands of seeds take minutes.
const SIDES: std::ops::RangeInclusive<u32> = 8..=14;
const ROBOTS: std::ops::RangeInclusive<u16> = 2..=5;
/// The time of a mission, seconds.
const BUDGET: std::ops::RangeInclusive<u64> = 300..=900;

/// The search of a seed, with the faults of its network, and those of its participants.
///
/// # Errors
/// Never; the type is that of all scenarios.
pub fn plan(seed: u64) -> Result<(Scenario, Faults), ScenarioError> {
    let mut random = stream(seed, Purpose::Soak, 0);
    let (robots, budget) = (random.random_range(ROBOTS), random.random_range(BUDGET));
    let mut text = scenario(&mut random, seed, (robots, budget));
    text.push_str(&unlike_robot(seed, robots));
    let scenario = |text| Scenario::from_text(Path::new(&format!("soak-{seed}.toml")), text);
    let apart = format!("robots.separation_meters = {:?}\n", separation(seed));
    // On few cells not all robots find room.
    let scenario = scenario(apart + &text).or_else(|_| scenario(text))?;
    let mut draw = Draw { random: &mut random, robots, budget: Duration::from_secs(budget) };
    let mut faults = draw.faults();
    faults.commands = draw.commands(scenario.terrain().grid());
    faults.commands.extend(call_back(seed, budget));
    faults.commands.extend(order_robots(seed, robots, scenario.terrain().grid(), budget));
    faults.commands.extend(zones(seed, scenario.terrain().grid(), budget));
    Ok((scenario, faults))
}

fn scenario(random: &mut Stream, seed: u64, (robots, budget): (u16, u64)) -> String {
    let shape = Generated::ALL[random.random_range(0..Generated::ALL.len())].as_str();
    let policy = PolicyName::ALL[random.random_range(0..PolicyName::ALL.len())].as_str();
    let (rows, columns) = (random.random_range(SIDES), random.random_range(SIDES));
    let start = if random.random() { "random" } else { "scattered" };
    let heartbeat = random.random_range(2..=10_u32);
    // In every third search everybody comes home.
    let is_to_return = stream(seed, Purpose::Soak, 2).random_ratio(1, 3);
    let mut text = format!(
        "name = 'soak'\n\
         map = {{ shape = '{shape}', rows = {rows}, columns = {columns}, seed = {} }}\n\
         sensor.radius = {}\n\
         objects.density = {:?}\n\
         robots.count = {robots}\n\
         robots.policy = '{policy}'\n\
         robots.start = '{start}'\n\
         mission = {{ budget_seconds = {budget}.0, heartbeat_seconds = {heartbeat}.0, liveness_timeout_seconds = {}.0, \
         return_to_base = {is_to_return} }}\n\
         [network]\n",
        random.random_range(0..1000_u32),
        random.random_range(1..=3_u32),
        random.random_range(0.02..0.3),
        4 * heartbeat,
    );
    let mut fault = |key: &str, most: f64| {
        if random.random_bool(0.7) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{key} = {:?}", random.random_range(0.0..most));
        }
    };
    fault("loss", 0.6);
    fault("delay_seconds", 2.0);
    fault("jitter_seconds", 20.0);
    fault("duplication", 0.4);
    let _ = writeln!(text, "reorder = 0.2\nreorder_seconds = {:?}", random.random_range(1.0..60.0));
    if random.random_bool(0.5) {
        let (from, to) = interval(random, budget);
        let alone = random.random_range(1..=robots);
        let with = if random.random() { "" } else { ", 'coordinator'" };
        let _ = writeln!(
            text,
            "[[network.partitions]]\nfrom_seconds = {from:?}\nto_seconds = {to:?}\ngroups = [[{alone}{with}]]"
        );
    }
    text
}

/// In every third search robots keep apart, by one cell or by two.
fn separation(seed: u64) -> f64 {
    let mut random = stream(seed, Purpose::Soak, 7);
    if random.random_ratio(1, 3) { random.random_range(1.0..60.0) } else { 0.0 }
}

/// In every second search one robot is of another class.
fn unlike_robot(seed: u64, robots: u16) -> String {
    let mut random = stream(seed, Purpose::Soak, 1);
    if random.random() {
        return String::new();
    }
    format!(
        "[[robots.robot]]\nnumber = {}\nclass = 'drone'\n\
         [classes.drone]\nspeed_meters_per_second = {:?}\nflies = {}\n\
         sensor = {{ radius = {}, noise_variance = {:?} }}\n",
        random.random_range(1..=robots),
        random.random_range(0.5..8.0),
        random.random::<bool>(),
        random.random_range(1..=4_u32),
        random.random_range(0.002..0.1),
    )
}

/// In every fourth search the operator calls the robots back, half of the time to end the mission, and lets half of them
/// search again.
fn call_back(seed: u64, budget: u64) -> Vec<(MissionTime, Command)> {
    let mut random = stream(seed, Purpose::Soak, 3);
    if !random.random_ratio(1, 4) {
        return Vec::new();
    }
    let (back, on) = interval(&mut random, budget);
    let at = |seconds| MissionTime::START + Duration::from_secs_f64(seconds);
    let on = random.random::<bool>().then(|| (at(on), Command::Team(TeamOrder::Search)));
    let order = if random.random() { TeamOrder::Return } else { TeamOrder::End };
    iter::once((at(back), Command::Team(order))).chain(on).collect()
}

/// In every third search the operator gives orders to single robots.
fn order_robots(seed: u64, robots: u16, grid: Grid, budget: u64) -> Vec<(MissionTime, Command)> {
    let mut random = stream(seed, Purpose::Soak, 4);
    if !random.random_ratio(1, 3) {
        return Vec::new();
    }
    let last = u32::try_from(grid.cell_count()).unwrap_or(u32::MAX);
    let count = random.random_range(1..=6);
    let order = |_| {
        let at = MissionTime::START + Duration::from_secs_f64(interval(&mut random, budget).1);
        let robot = RobotId::new(random.random_range(1..=robots))?;
        let there = grid.cell_numbered(random.random_range(0..last))?;
        let orders = [RobotOrder::Go(there), RobotOrder::Search, RobotOrder::Pause, RobotOrder::Return];
        // Half of them go somewhere.
        let order = orders[random.random_range(0..6_usize).saturating_sub(2)];
        Some((at, Command::Robot(robot, order)))
    };
    (0..count).filter_map(order).collect()
}

/// In every third search the operator closes, skips and opens rectangles.
fn zones(seed: u64, grid: Grid, budget: u64) -> Vec<(MissionTime, Command)> {
    let mut random = stream(seed, Purpose::Soak, 5);
    if !random.random_ratio(1, 3) {
        return Vec::new();
    }
    let side = |random: &mut Stream, length: u32| {
        let first = random.random_range(0..length);
        first..(first + random.random_range(1..=length / 2)).min(length)
    };
    let zone = |_| {
        let at = MissionTime::START + Duration::from_secs_f64(interval(&mut random, budget).1);
        let rows = side(&mut random, grid.rows());
        let columns = side(&mut random, grid.columns());
        let places = rows.flat_map(|row| columns.clone().map(move |column| Position { row, column }));
        // Half of them are no-go zones.
        let zone = [Zone::NoGo, Zone::NoGo, Zone::Skip, Zone::Open][random.random_range(0..4_usize)];
        (at, Command::Zone(zone, places.filter_map(|place| grid.cell(place)).collect()))
    };
    (0..stream(seed, Purpose::Soak, 6).random_range(1..=4)).map(zone).collect()
}

/// An interval of a mission, seconds.
fn interval(random: &mut Stream, budget: u64) -> (f64, f64) {
    let from = budget as f64 * random.random_range(0.0..0.6);
    (from, from + budget as f64 * random.random_range(0.05..0.4))
}

struct Draw<'a> {
    random: &'a mut Stream,
    robots: u16,
    budget: Duration,
}

impl Draw<'_> {
    fn faults(&mut self) -> Faults {
        let mut faults = Faults::default();
        for robot in RobotId::first(self.robots) {
            let participant = Participant::Robot(robot);
            if self.random.random_bool(0.4) {
                // At least one robot restarts, so that there is a search to the end.
                let crash = self.crash(robot == RobotId::FIRST);
                faults.crashes.insert(participant, crash);
            }
            if self.random.random_bool(0.4) {
                faults.clocks.insert(participant, Duration::from_millis(self.random.random_range(1..30_000)));
            }
            if self.random.random_bool(0.3) {
                faults.full.insert(robot, self.interval());
            }
            if self.random.random_bool(0.3) {
                faults.slowness.insert(robot, self.random.random_range(1.0..4.0));
            }
        }
        if self.random.random_bool(0.4) {
            let crash = self.crash(true);
            faults.crashes.insert(Participant::Coordinator, crash);
        }
        if self.random.random_bool(0.5) {
            faults.mute.extend(self.mute());
        }
        if self.random.random_bool(0.25) {
            faults.liar = RobotId::new(self.random.random_range(1..=self.robots));
        }
        faults
    }

    /// An operator who pauses the search for a while, marks cells, adds some and decides about finds, or does nothing.
    fn commands(&mut self, grid: Grid) -> Vec<(MissionTime, Command)> {
        let mut commands = Vec::new();
        if self.random.random_bool(0.5) {
            let (pause, resume) = interval(self.random, self.budget.as_secs());
            commands.push((pause, Command::Team(TeamOrder::Pause)));
            commands.push((resume, Command::Team(TeamOrder::Search)));
        }
        if self.random.random_bool(0.5) {
            for _ in 0..self.random.random_range(1..=6) {
                let mark = if self.random.random() {
                    let (cell, radius_hundredths) =
                        (self.cells(grid, 1)[0], self.random.random_range(0..=300));
                    Mark::Clue(Clue { cell, ratio_thousandths: 55_000, radius_hundredths })
                } else {
                    let cells = self.cells(grid, 3).into_iter().collect();
                    Mark::Searched(Searched { cells, pod_thousandths: self.random.random_range(1..=999) })
                };
                let (made, withdrawn) = interval(self.random, self.budget.as_secs());
                commands.push((made, Command::Mark(mark, "by hand".to_owned())));
                if self.random.random() {
                    let id = MissionTime::START + Duration::from_secs_f64(made);
                    commands.push((withdrawn, Command::Unmark(id.0)));
                }
            }
        }
        if self.random.random_bool(0.3) {
            let command = Command::Search(self.cells(grid, 40));
            commands.push((self.time(), command));
        }
        if self.random.random_bool(0.4) {
            let cells = self.cells(grid, 2);
            for _ in 0..self.random.random_range(1..=5) {
                let decision = Decision::ALL[self.random.random_range(0..Decision::ALL.len())];
                let command = Command::Judge(decision, cells[self.random.random_range(0..cells.len())]);
                commands.push((self.time(), command));
            }
        }
        let at = |seconds| MissionTime::START + Duration::from_secs_f64(seconds);
        commands.into_iter().map(|(seconds, command)| (at(seconds), command)).collect()
    }

    /// A time of a mission, seconds.
    fn time(&mut self) -> f64 {
        interval(self.random, self.budget.as_secs()).0
    }

    fn cells(&mut self, grid: Grid, count: usize) -> Vec<Cell> {
        let last = u32::try_from(grid.cell_count()).unwrap_or(u32::MAX);
        let any = |_| grid.cell_numbered(self.random.random_range(0..last));
        (0..count).filter_map(any).collect()
    }

    fn crash(&mut self, will_return: bool) -> Crash {
        let at = MissionTime::START + self.budget.mul_f64(self.random.random_range(0.02..0.7));
        let away = Duration::from_millis(self.random.random_range(1_000..200_000));
        let memory = if self.random.random_bool(0.6) { Memory::Kept } else { Memory::Lost };
        let back = (will_return || self.random.random_bool(0.75)).then(|| (at + away, memory));
        Crash { at, back }
    }

    fn mute(&mut self) -> Option<OneWayLoss> {
        let from = self.random.random_range(1..=self.robots);
        let other = self.random.random_range(1..self.robots);
        let to = if other < from { other } else { other + 1 };
        let [from, to] = [RobotId::new(from)?, RobotId::new(to)?].map(Participant::Robot);
        Some(OneWayLoss { from, to, during: self.interval() })
    }

    fn interval(&mut self) -> Range<MissionTime> {
        let (begin, end) = interval(self.random, self.budget.as_secs());
        let [begin, end] = [begin, end].map(|time| MissionTime::START + Duration::from_secs_f64(time));
        begin..end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_seed_is_a_search_with_faults_of_its_own() {
        let (mut crashes, mut mute, mut commands, mut unlike, mut flying, mut returning) = (0, 0, 0, 0, 0, 0);
        for seed in 0..200 {
            let (scenario, faults) = plan(seed).unwrap();
            assert!((2..=5).contains(&scenario.robots().len()));
            crashes += faults.crashes.len();
            mute += faults.mute.len();
            commands += faults.commands.len();
            unlike += usize::from(scenario.only_class().is_none());
            returning += usize::from(scenario.mission().return_reserve.is_some());
            flying += usize::from(scenario.robots().iter().any(|robot| robot.class.flies));
            assert_eq!(plan(seed).unwrap().1, faults);
        }
        assert!(crashes > 200 && mute > 50 && commands > 300, "{crashes} {mute} {commands}");
        assert!(unlike > 80 && flying > 30 && returning > 40, "{unlike} {flying} {returning}");
    }
}
