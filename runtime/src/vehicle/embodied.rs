//! An agent that passes its routes and its belief to its vehicle.

use std::num::NonZeroUsize;
use std::sync::Arc;

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use tokio::sync::{mpsc, watch};

use super::SHOW;

/// An agent's outputs for its vehicle.
#[derive(Debug)]
pub struct AgentOutputs {
    pub(crate) routes: mpsc::UnboundedReceiver<Vec<Cell>>,
    pub(crate) beliefs: watch::Receiver<Arc<Belief>>,
}

/// An agent with the channels to its vehicle.
pub struct Embodied {
    agent: Agent,
    routes: mpsc::UnboundedSender<Vec<Cell>>,
    beliefs: watch::Sender<Arc<Belief>>,
    shown: MissionTime,
}

impl Embodied {
    /// Wraps an agent that has restored its stored state.
    #[must_use]
    pub fn new(agent: Agent) -> (Self, AgentOutputs) {
        let (routes, received) = mpsc::unbounded_channel();
        let (beliefs, watched) = watch::channel(Arc::new(agent.belief().clone()));
        let agent_config = AgentOutputs { routes: received, beliefs: watched };
        (Self { agent, routes, beliefs, shown: MissionTime::START }, agent_config)
    }
}

impl StateMachine for Embodied {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let effects = self.agent.handle(now, event)?;
        if let Some(route) = &effects.route {
            // Without a vehicle the robot is about to stop.
            let _ = self.routes.send(route.clone());
        }
        // Copying a belief costs time proportional to the map, and messages are many.
        if now >= self.shown + SHOW {
            self.shown = now;
            if self.beliefs.borrow().digest() != self.agent.digest() {
                self.beliefs.send_replace(Arc::new(self.agent.belief().clone()));
            }
        }
        Ok(effects)
    }

    fn release(&mut self, held: NonZeroUsize) {
        self.agent.release(held);
    }

    fn is_found(&self, cell: Cell) -> bool {
        self.agent.is_found(cell)
    }

    fn digest(&self) -> Digest {
        self.agent.digest()
    }

    fn observations(&self) -> u64 {
        self.agent.observations()
    }
}
