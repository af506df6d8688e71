//! Where the robots' bodies were at all times, and how near two of them came: computed from their arrivals alone.

use std::time::Duration;

use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use super::Violation;
use crate::faults::Faults;

/// By how much a distance may be below what it is to be.
const ROUNDING_METERS: f64 = 1e-6;

/// The tracks of all robots.
pub(super) struct Bodies<'a> {
    scenario: &'a Scenario,
    /// How many times as long as planned each takes.
    slowness: Vec<f64>,
    /// Of each robot: when it came where. The first entry is its start.
    tracks: Vec<Vec<(MissionTime, Cell)>>,
}

/// A robot in the plane over some time: from one point to another, at constant speed. Meters and seconds.
#[derive(Clone, Copy)]
struct Leg {
    during: (f64, f64),
    from: (f64, f64),
    to: (f64, f64),
}

/// The shortest distance of two robots, and when it was.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Nearest {
    meters: f64,
    seconds: f64,
    robots: (RobotId, RobotId),
}

impl<'a> Bodies<'a> {
    pub(super) fn new(scenario: &'a Scenario, faults: &Faults) -> Self {
        let robots = scenario.robots();
        let slowness = robots.iter().map(|robot| faults.slowness(robot.id)).collect();
        Self { scenario, slowness, tracks: vec![Vec::new(); robots.len()] }
    }

    /// A robot is in a cell, since now or before.
    pub(super) fn is_in(&mut self, now: MissionTime, robot: RobotId, cell: Cell) {
        let track = &mut self.tracks[robot.index()];
        if track.last().is_none_or(|&(_, last)| last != cell) {
            track.push((now, cell));
        }
    }

    /// Checks that no two robots came nearer than they are to keep, until a time.
    pub(super) fn check(&self, until: MissionTime) -> Result<(), Violation> {
        let separation = self.scenario.separation();
        if !separation.is_kept() {
            return Ok(());
        }
        let least = f64::from(separation.cells()) * self.scenario.terrain().cell_meters();
        match self.nearest(until) {
            Some(Nearest { meters, seconds, robots: (a, b) }) if meters < least - ROUNDING_METERS => {
                let what = format!("it was {meters:.3} m from robot {b} and is to keep {least:.3} m");
                let at = MissionTime::START + Duration::from_secs_f64(seconds);
                Err(Violation::Broken { at, participant: Participant::Robot(a), what })
            }
            _ => Ok(()),
        }
    }

    /// How near two robots came that both fly or both do not, until a time.
    fn nearest(&self, until: MissionTime) -> Option<Nearest> {
        let robots = self.scenario.robots();
        let legs: Vec<Vec<Leg>> = (0..robots.len()).map(|place| self.legs(place, until)).collect();
        let mut nearest: Option<Nearest> = None;
        for (place, a) in robots.iter().enumerate() {
            for (other, b) in robots.iter().enumerate().skip(place + 1) {
                if a.class.flies != b.class.flies {
                    continue;
                }
                for (meters, seconds) in distances(&legs[place], &legs[other]) {
                    if nearest.is_none_or(|nearest| meters < nearest.meters) {
                        nearest = Some(Nearest { meters, seconds, robots: (a.id, b.id) });
                    }
                }
            }
        }
        nearest
    }

    fn legs(&self, place: usize, until: MissionTime) -> Vec<Leg> {
        let (terrain, class) = (self.scenario.terrain(), &self.scenario.robots()[place].class);
        let step = terrain.cell_meters() / class.speed_meters_per_second * self.slowness[place];
        let mut legs = Vec::new();
        for pair in self.tracks[place].windows(2) {
            let ((came, from), (arrived, to)) = (pair[0], pair[1]);
            let set_off = arrived.as_seconds() - step * terrain.grid().offset(from, to).euclidean();
            let (here, there) = (terrain.center_meters(from), terrain.center_meters(to));
            legs.push(Leg { during: (came.as_seconds(), set_off), from: here, to: here });
            legs.push(Leg { during: (set_off, arrived.as_seconds()), from: here, to: there });
        }
        if let Some(&(came, last)) = self.tracks[place].last() {
            let here = terrain.center_meters(last);
            legs.push(Leg { during: (came.as_seconds(), until.as_seconds()), from: here, to: here });
        }
        legs
    }
}

/// The shortest distance of two robots, and its time, of every two legs that overlap in time.
fn distances(a: &[Leg], b: &[Leg]) -> Vec<(f64, f64)> {
    let (mut of_a, mut of_b) = (a.iter().peekable(), b.iter().peekable());
    let mut distances = Vec::new();
    while let (Some(a), Some(b)) = (of_a.peek(), of_b.peek()) {
        let (from, to) = (a.during.0.max(b.during.0), a.during.1.min(b.during.1));
        if from <= to {
            distances.push(nearest_of(a, b, (from, to)));
        }
        if a.during.1 <= b.during.1 {
            of_a.next()
        } else {
            of_b.next()
        };
    }
    distances
}

/// The relative position of two robots is linear in time: the nearest point of a segment to the origin.
fn nearest_of(a: &Leg, b: &Leg, (from, to): (f64, f64)) -> (f64, f64) {
    let apart = |time: f64| {
        let ((east_a, north_a), (east_b, north_b)) = (a.at(time), b.at(time));
        (east_a - east_b, north_a - north_b)
    };
    let (first, last) = (apart(from), apart(to));
    let (east, north) = (last.0 - first.0, last.1 - first.1);
    let length = east * east + north * north;
    let share = if length > 0.0 { -(first.0 * east + first.1 * north) / length } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    ((first.0 + share * east).hypot(first.1 + share * north), from + share * (to - from))
}

impl Leg {
    fn at(&self, time: f64) -> (f64, f64) {
        let lasts = self.during.1 - self.during.0;
        let share = if lasts > 0.0 { ((time - self.during.0) / lasts).clamp(0.0, 1.0) } else { 1.0 };
        let between = |from: f64, to: f64| from + share * (to - from);
        (between(self.from.0, self.to.0), between(self.from.1, self.to.1))
    }
}
