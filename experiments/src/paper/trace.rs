//! A search with the belief at each decision.

use std::ops::ControlFlow;

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError};
use dragnet_scenario::Scenario;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_sim::episode::{self, Observer};
use dragnet_sim::simulation::End;

/// The track and the beliefs of the one robot of a scenario.
pub(super) struct Trace {
    /// Cells that it was in, in order, that of the start first.
    pub(super) track: Vec<Cell>,
    /// For each of them the number of searched cells that it is certain of, shape `[track]`: their probability is at
    /// least `tau` or at most `1 - tau`.
    pub(super) certain: Vec<usize>,
    /// Before the first decision, and at each waypoint; no more than requested.
    pub(super) stops: Vec<Stop>,
}

/// A cell where a robot decided.
pub(super) struct Stop {
    /// Number of cells entered before.
    pub(super) entered: usize,
    pub(super) belief: Belief,
}

/// Runs a robot until it has reached this many waypoints, or rests.
pub(super) fn watch(scenario: &Scenario, seed: u64, waypoints: usize) -> Result<Trace, ParticipantError> {
    let mut robots = episode::team(scenario, seed, Agent::new);
    let mut tracer = Tracer {
        scenario,
        belief: scenario.prior().clone(),
        trace: Trace { track: Vec::new(), certain: Vec::new(), stops: Vec::new() },
        waypoints,
    };
    episode::watch(scenario, seed, End::Resting, &mut robots, &mut tracer)?;
    Ok(tracer.trace)
}

impl Trace {
    /// The stop at a waypoint, by its number from 1; the last one, if the robot rested before.
    pub(super) fn at(&self, waypoint: usize) -> &Stop {
        &self.stops[waypoint.min(self.waypoints())]
    }

    /// Number of waypoints that it reached.
    pub(super) fn waypoints(&self) -> usize {
        self.stops.len() - 1
    }

    /// Number of cells on a track that the robot entered repeatedly.
    pub(super) fn entered_again(&self, entered: usize) -> usize {
        let mut cells = self.track[..=entered].to_vec();
        cells.sort_unstable();
        cells.dedup();
        entered + 1 - cells.len()
    }
}

/// Adds up the readings of one robot: if there is no other, its belief is the merged one.
struct Tracer<'a> {
    scenario: &'a Scenario,
    belief: Belief,
    trace: Trace,
    waypoints: usize,
}

impl Tracer<'_> {
    fn certain(&self) -> usize {
        let (terrain, tau) = (self.scenario.terrain(), self.scenario.mission().detection_threshold);
        let probabilities = terrain.searched_cells().map(|cell| self.belief.probability(cell));
        probabilities.filter(|&probability| probability >= tau || probability <= 1.0 - tau).count()
    }
}

impl Observer for Tracer<'_> {
    fn happens(&mut self, event: &Event<Message>) {
        if let Event::Sensed { cell, readings } = event {
            for reading in readings {
                self.belief.add(reading);
            }
            self.trace.track.push(*cell);
            self.trace.certain.push(self.certain());
        }
    }

    /// A single robot has a new path where it decides, and where it rests.
    fn reacts(&mut self, effects: &Effects<Message>) -> ControlFlow<()> {
        if effects.route.is_some() {
            let entered = self.trace.track.len() - 1;
            self.trace.stops.push(Stop { entered, belief: self.belief.clone() });
        }
        if self.trace.stops.len() > self.waypoints {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::policy::PolicyName;

    use super::super::map::{Map, Size};
    use super::*;

    #[test]
    fn a_trace_ends_at_its_waypoint_with_the_belief_of_the_robot() {
        let scenario = Map::OpenAsterisk.scenario(Size::Thirty).unwrap();
        let scenario = scenario.with_policy(PolicyName::Greedy).unwrap();
        let trace = watch(&scenario, 1000, 3).unwrap();
        assert_eq!((trace.waypoints(), trace.stops[0].entered), (3, 0));
        assert!(trace.stops.is_sorted_by(|a, b| a.entered < b.entered));
        assert_eq!(trace.track.len(), trace.at(3).entered + 1);
        assert!(trace.certain.last() > trace.certain.first());

        let whole = watch(&scenario, 1000, usize::MAX - 1).unwrap();
        let episode = episode::run(&scenario, 1000, End::Resting).unwrap();
        assert_eq!(whole.stops.last().unwrap().belief.digest(), episode.outcome.digest);
        assert_eq!(whole.track[..trace.track.len()], trace.track);
    }

    #[test]
    fn a_cell_counts_as_entered_again_from_the_second_time_on() {
        let grid = Map::OpenAsterisk.scenario(Size::Thirty).unwrap().terrain().grid();
        let cells: Vec<Cell> = grid.cells().take(3).collect();
        let there_and_back = Trace {
            track: [0, 1, 2, 1, 0, 1].map(|place| cells[place]).to_vec(),
            certain: Vec::new(),
            stops: Vec::new(),
        };
        assert_eq!([2, 3, 5].map(|entered| there_and_back.entered_again(entered)), [0, 1, 3]);
    }
}
