//! A simulation whose robots are moved by the caller, between two of its events.

use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use super::{Participant, Simulation, StepContext};
use crate::participants::Participants;
use crate::world::World;

impl<C: Participants, S: FnMut(MissionTime, StepContext)> Simulation<C, S> {
    /// The same, without counting what is sent: to know their sizes, messages have to be encoded.
    pub(crate) fn without_traffic(self) -> Self {
        Self { is_traffic_counted: false, ..self }
    }

    /// Every robot observes from its start cell.
    pub(crate) fn begin(&mut self) -> Result<(), C::Error> {
        self.start()
    }

    /// Sends a robot to a neighboring cell; it observes when it arrives. If robots keep apart and another one is in its way, it
    /// stays where it is: returns whether it goes.
    pub(crate) fn send_off(&mut self, now: MissionTime, robot: RobotId, to: Cell) -> bool {
        self.world.set_route(robot, vec![to]);
        let time = self.world.set_off(robot);
        match time {
            Some(time) => self.travel(now, robot, time),
            None => self.world.set_route(robot, Vec::new()),
        }
        time.is_some()
    }

    /// Runs all events that are due until a time, and then until no robot moves. Returns the time reached.
    pub(crate) fn run_on(&mut self, until: MissionTime) -> Result<MissionTime, C::Error> {
        let mut now = until;
        while self.is_any_moving() || self.queue.due().is_some_and(|due| due <= until) {
            let Some((due, sim_event)) = self.queue.next() else { break };
            now = now.max(due);
            self.happen(due, sim_event)?;
        }
        Ok(now)
    }

    fn is_any_moving(&self) -> bool {
        self.members.iter().any(|member| match member.participant {
            Participant::Robot(robot) => self.world.body(robot).is_moving(),
            Participant::Coordinator => false,
        })
    }

    /// Whether a robot has not crashed.
    pub(crate) fn is_up(&self, robot: RobotId) -> bool {
        self.members[self.place(Participant::Robot(robot))].is_up
    }

    pub(crate) const fn world(&self) -> &World {
        &self.world
    }

    pub(crate) const fn participants(&self) -> &C {
        &self.participants
    }

    pub(crate) const fn participants_mut(&mut self) -> &mut C {
        &mut self.participants
    }
}
