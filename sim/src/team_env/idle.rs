//! Robots that exchange observations as robots do, and leave it to the caller where they go.

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::policy::{Decision, Policy};
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;

use crate::participants::{LocalParticipants, Participants, Reaction};
use crate::single_robot_env::changes::ChangedCells;

/// Robots that do not move by themselves.
pub(super) struct IdleRobots {
    pub(super) robots: Vec<Agent>,
    /// Cells of each robot's belief that have changed since it was drawn last.
    pub(super) learned: Vec<ChangedCells>,
    /// Cells that robots have observed since the last reward, in order, possibly repeated.
    pub(super) sensed: Vec<Cell>,
}

impl IdleRobots {
    /// What an event brings about in a robot. Its computing time is not measured.
    fn handle(
        &mut self,
        participant: Participant,
        handle: impl FnOnce(&mut Agent) -> Effects<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let absent = || LocalParticipants::absent(participant);
        let Participant::Robot(robot) = participant else { return Err(absent()) };
        let mut effects = handle(self.robots.get_mut(robot.index()).ok_or_else(absent)?);
        // The observations that count in its belief from now on.
        let readings = effects.kept.iter().flat_map(|observation| &observation.readings);
        self.learned[robot.index()].extend(readings.map(|reading| reading.cell));
        effects.route = None;
        Ok(effects)
    }
}

impl Participants for IdleRobots {
    type MessageRef = Message;
    type Error = ParticipantError;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        if let Event::Sensed { readings, .. } = &event {
            self.sensed.extend(readings.iter().map(|reading| reading.cell));
        }
        self.handle(participant, |robot| robot.react(now, event))
    }

    fn deliver(
        &mut self,
        from: Participant,
        message: &Message,
        to: &[(Participant, MissionTime)],
    ) -> Result<Vec<Reaction<Message>>, ParticipantError> {
        let receive = |&(to, now)| self.handle(to, |robot: &mut Agent| robot.receive(now, from, message));
        to.iter().map(receive).map(|effects| effects.map(Reaction::from)).collect()
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, ParticipantError> {
        LocalParticipants::new(&mut self.robots, None).digest(participant, now)
    }
}

/// A policy that does not move.
pub(super) struct Still;

impl Policy for Still {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        Decision { chosen: situation.robot, path: Vec::new(), scores: Vec::new() }
    }
}
