//! The robot as a state machine that a clock and a network, real or simulated, can drive.

use std::num::NonZeroUsize;
use std::time::Instant;

use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;

use crate::agent::{Action, Agent};

impl StateMachine for Agent {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let decisions = self.decisions();
        // Only measured: no decision depends on it.
        let start = Instant::now();
        let actions = self.react(now, event);
        let elapsed = start.elapsed();
        let mut effects = Effects {
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
                Action::Keep(observation) => effects.kept.push(observation),
                Action::Publish(audience, message) => effects.published.push((audience, message)),
                Action::Repeat(request) => effects.repeats.push(request),
                Action::Follow(route) => effects.route = Some(route),
                Action::Refuse(refused) => effects.refused.push(refused),
            }
        }
        Ok(effects)
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
        self.replica().log().len()
    }
}
