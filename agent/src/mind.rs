//! The agent as a participant that a clock and a network, real or simulated, can drive.

use std::num::NonZeroUsize;
use std::time::Instant;

use dragnet_proto::message::Message;
use dragnet_proto::participant::{Mind, MindError, Reaction, Stimulus};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;

use crate::agent::{Action, Agent, Event};

impl Mind for Agent {
    fn experience(
        &mut self,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Result<Reaction<Message>, MindError> {
        let decisions = self.decisions();
        // Only measured: no decision depends on it.
        let start = Instant::now();
        let actions = match stimulus {
            // A person speaks to the coordinator, and hears there of two robots of one number.
            Stimulus::Start | Stimulus::Commanded(_) | Stimulus::Doubled(_) => Vec::new(),
            Stimulus::Sensed { cell, readings } => self.handle(now, Event::Sensed { cell, readings }),
            Stimulus::Delivered { from, parcel } => {
                self.handle(now, Event::Received { from, message: parcel })
            }
            Stimulus::Woke => self.handle(now, Event::Woke),
            Stimulus::Came => self.handle(now, Event::Came),
            Stimulus::Lost(robot) => self.handle(now, Event::Lost(robot)),
            Stimulus::Halted => self.handle(now, Event::Halted),
            Stimulus::Released => self.handle(now, Event::Released),
        };
        let elapsed = start.elapsed();
        let mut reaction = Reaction {
            kept: Vec::new(),
            published: Vec::new(),
            route: None,
            wake_at: self.wake_at(),
            activity: self.activity(),
            decision: (self.decisions() > decisions).then_some(elapsed),
            repeats: Vec::new(),
            refused: Vec::new(),
        };
        for action in actions {
            match action {
                Action::Keep(observation) => reaction.kept.push(observation),
                Action::Publish(audience, message) => reaction.published.push((audience, message)),
                Action::Repeat(request) => reaction.repeats.push(request),
                Action::Follow(route) => reaction.route = Some(route),
                Action::Refuse(refused) => reaction.refused.push(refused),
            }
        }
        Ok(reaction)
    }

    fn release(&mut self, held: NonZeroUsize) {
        Agent::release(self, held);
    }

    fn is_found(&self, cell: Cell) -> bool {
        Agent::is_found(self, cell)
    }

    fn digest(&self) -> Digest {
        self.belief().digest()
    }

    fn observations(&self) -> u64 {
        self.inbox().log().len()
    }
}
