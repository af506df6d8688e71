//! An agent that passes its routes, the cells that are closed, and its belief to its vehicle.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Arc;

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::object_position::{ObjectPosition, ObjectPositions};
use dragnet_vehicle::pilot::Event as PilotEvent;
use tokio::sync::{mpsc, watch};

use super::SHOW;
use crate::pictures::Shelf;

/// An agent's outputs for its vehicle.
#[derive(Debug)]
pub struct AgentOutputs {
    /// Routes and closed cells.
    pub(crate) events: mpsc::UnboundedReceiver<PilotEvent>,
    pub(crate) known: watch::Receiver<Arc<Known>>,
    /// For pictures of the vehicle's finds.
    pub(crate) shelf: Arc<Shelf>,
}

/// What an agent knows of the objects.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) belief: Belief,
    pub(crate) positions: Arc<ObjectPositions>,
}

/// An agent with the channels to its vehicle.
pub struct Embodied {
    agent: Agent,
    events: mpsc::UnboundedSender<PilotEvent>,
    closed: BTreeSet<Cell>,
    known: watch::Sender<Arc<Known>>,
    shelf: Arc<Shelf>,
    shown: MissionTime,
}

impl Embodied {
    /// Wraps an agent that has restored its stored state.
    #[must_use]
    pub fn new(agent: Agent) -> (Self, AgentOutputs) {
        let (events, received) = mpsc::unbounded_channel();
        let (known, watched) = watch::channel(Arc::new(Known::of(&agent)));
        let shelf = Arc::new(Shelf::new(agent.id()));
        let outputs = AgentOutputs { events: received, known: watched, shelf: Arc::clone(&shelf) };
        let (closed, shown) = (BTreeSet::new(), MissionTime::START);
        (Self { agent, events, closed, known, shelf, shown }, outputs)
    }
}

impl Known {
    fn of(agent: &Agent) -> Self {
        let positions = Arc::clone(agent.replica().knowledge().positions());
        Self { belief: agent.belief().clone(), positions }
    }

    fn is_of(&self, agent: &Agent) -> bool {
        self.belief.digest() == agent.digest() && self.positions == *agent.replica().knowledge().positions()
    }
}

impl StateMachine for Embodied {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let may_close = matches!(event, Event::Received { message: Message::Zones(_), .. });
        let effects = self.agent.handle(now, event)?;
        self.shelf.note(now);
        // Without a vehicle the robot is about to stop.
        if may_close {
            let closed: BTreeSet<Cell> = self.agent.closed().collect();
            if closed != self.closed {
                self.closed.clone_from(&closed);
                let _ = self.events.send(PilotEvent::Closed(closed));
            }
        }
        if let Some(route) = &effects.route {
            let _ = self.events.send(PilotEvent::Route(route.clone()));
        }
        // Copying a belief costs time proportional to the map, and messages are many.
        if now >= self.shown + SHOW {
            self.shown = now;
            if !self.known.borrow().is_of(&self.agent) {
                self.known.send_replace(Arc::new(Known::of(&self.agent)));
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

    fn position(&self, cell: Cell) -> Option<&ObjectPosition> {
        self.agent.position(cell)
    }

    fn digest(&self) -> Digest {
        self.agent.digest()
    }

    fn observations(&self) -> u64 {
        self.agent.observations()
    }
}
