//! The robot as a state machine that a clock and a network, real or simulated, can drive.

use std::num::NonZeroUsize;

use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::object_position::ObjectPosition;

use crate::agent::Agent;

impl StateMachine for Agent {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        Ok(self.react(now, event))
    }

    fn receive(
        &mut self,
        now: MissionTime,
        from: Participant,
        message: &Message,
    ) -> Result<Effects<Message>, ParticipantError> {
        Ok(Agent::receive(self, now, from, message))
    }

    fn release(&mut self, held: NonZeroUsize) {
        Agent::release(self, held);
    }

    fn is_found(&self, cell: Cell) -> bool {
        Agent::is_found(self, cell)
    }

    fn position(&self, cell: Cell) -> Option<&ObjectPosition> {
        self.replica().knowledge().positions().of(cell)
    }

    fn digest(&self) -> Digest {
        self.replica().knowledge().digest()
    }

    fn observations(&self) -> u64 {
        self.replica().log().len()
    }
}
