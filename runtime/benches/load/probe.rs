//! A robot whose merges are timed: from the publication of an observation to its merge by another robot.

use std::collections::HashMap;
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Origin, RobotId};

/// The measurements of all probes of a team.
#[derive(Default)]
pub(crate) struct Measured {
    published: HashMap<(Origin, u64), Instant>,
    pub(crate) merges: Vec<Duration>,
    pub(crate) delivered: u64,
    pub(crate) digests: HashMap<RobotId, Digest>,
    pub(crate) observations: HashMap<RobotId, u64>,
}

impl Measured {
    /// Whether this many robots have the same evidence, from this many observations.
    pub(crate) fn agree(&self, robots: usize, observations: u64) -> bool {
        let first = self.digests.values().next();
        self.digests.len() == robots
            && self.digests.values().all(|digest| Some(digest) == first)
            && self.observations.values().all(|&known| known >= observations)
    }

    pub(crate) fn published(&self) -> u64 {
        self.published.len() as u64
    }
}

pub(crate) struct Probe {
    pub(crate) robot: RobotId,
    pub(crate) agent: Agent,
    pub(crate) measured: Arc<Mutex<Measured>>,
}

impl StateMachine for Probe {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let is_direct = matches!(
            &event,
            Event::Received { from: Participant::Robot(_), message: Message::Observation(_) }
        );
        let is_delivery = matches!(event, Event::Received { .. });
        let effects = self.agent.handle(now, event)?;
        let merged = Instant::now();
        let measured = &mut *self.measured.lock().unwrap();
        measured.delivered += u64::from(is_delivery);
        for observation in
            effects.kept.iter().filter(|observation| observation.origin.source != self.robot.into())
        {
            // Repaired observations took as long as they were missing; they count as well.
            let published = measured.published.get(&(observation.origin, observation.sequence));
            measured.merges.extend(published.map(|&published| merged - published));
        }
        if is_direct || !effects.kept.is_empty() {
            measured.digests.insert(self.robot, self.agent.digest());
            measured.observations.insert(self.robot, self.agent.observations());
        }
        // From here on it is the robot's time again, not that of the measurement.
        let published = Instant::now();
        for (_, message) in &effects.published {
            if let Message::Observation(observation) = message {
                measured.published.insert((observation.origin, observation.sequence), published);
            }
        }
        Ok(effects)
    }

    fn release(&mut self, held: NonZeroUsize) {
        self.agent.release(held);
    }

    fn digest(&self) -> Digest {
        self.agent.digest()
    }

    fn observations(&self) -> u64 {
        self.agent.observations()
    }
}
