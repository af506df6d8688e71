//! Those who take part in a simulated mission, wherever they run.

use std::time::{Duration, Instant};

use dragnet_agent::agent::{self, Agent};
use dragnet_proto::message::{Activity, Audience, Message, Participant};
use dragnet_proto::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::RobotId;

/// The team as the simulator drives it: in this process, or behind Zenoh.
///
/// What is published is a parcel: the simulator decides when, and whether, it reaches whom, and need not know what is
/// in it.
pub trait Crew {
    /// A published message, or its name.
    type Parcel: Clone;
    /// Why a participant cannot go on.
    type Error;

    /// Tells a participant what happens to it, and hears what it does.
    ///
    /// # Errors
    /// If it cannot go on.
    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        stimulus: Stimulus<Self::Parcel>,
    ) -> Result<Reaction<Self::Parcel>, Self::Error>;

    /// Digest of a participant's evidence.
    ///
    /// # Errors
    /// If it cannot go on.
    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, Self::Error>;
}

/// What happens to a participant.
#[derive(Clone, Debug)]
pub enum Stimulus<P> {
    /// The mission starts.
    Start,
    /// A robot stands in a cell and took these readings.
    Sensed {
        /// Where it stands.
        cell: Cell,
        /// What it saw.
        readings: Vec<Reading>,
    },
    /// A message arrives.
    Delivered {
        /// Who published it.
        from: Participant,
        /// The message.
        parcel: P,
    },
    /// The time that it asked for has come.
    Woke,
    /// A robot has left the network.
    Lost(RobotId),
}

/// What a participant does.
#[derive(Clone, Debug)]
pub struct Reaction<P> {
    /// What it publishes, in order.
    pub published: Vec<(Audience, P)>,
    /// A robot's new route, if there is one: cells to enter from now on; without a cell, stay.
    pub route: Option<Vec<Cell>>,
    /// When to be woken.
    pub wake_at: MissionTime,
    /// What a robot does.
    pub activity: Activity,
    /// How long the decision took that it made just now, if it made one.
    pub decision: Option<Duration>,
}

/// Robots of this process, without a coordinator: the fastest crew.
pub struct Robots {
    agents: Vec<Agent>,
}

impl Robots {
    /// Robots numbered from 1 in this order.
    #[must_use]
    pub const fn new(agents: Vec<Agent>) -> Self {
        Self { agents }
    }

    /// The robots, by number.
    #[must_use]
    pub fn agents(&self) -> &[Agent] {
        &self.agents
    }

    /// Tells one robot what happens to it.
    pub fn step(
        &mut self,
        robot: RobotId,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Reaction<Message> {
        let agent = &mut self.agents[usize::from(robot.0) - 1];
        let decisions = agent.decisions();
        let start = Instant::now();
        let actions = match stimulus {
            Stimulus::Start => Vec::new(),
            Stimulus::Sensed { cell, readings } => agent.handle(now, agent::Event::Sensed { cell, readings }),
            Stimulus::Delivered { from, parcel } => {
                agent.handle(now, agent::Event::Received { from, message: parcel })
            }
            Stimulus::Woke => agent.handle(now, agent::Event::Woke),
            Stimulus::Lost(robot) => agent.handle(now, agent::Event::Lost(robot)),
        };
        let elapsed = start.elapsed();
        let mut reaction = Reaction {
            published: Vec::new(),
            route: None,
            wake_at: agent.wake_at(),
            activity: agent.activity(),
            decision: (agent.decisions() > decisions).then_some(elapsed),
        };
        for action in actions {
            match action {
                agent::Action::Publish(audience, message) => reaction.published.push((audience, message)),
                agent::Action::Follow(route) => reaction.route = Some(route),
            }
        }
        reaction
    }
}

impl Crew for Robots {
    type Parcel = Message;
    type Error = std::convert::Infallible;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Result<Reaction<Message>, Self::Error> {
        Ok(match who {
            Participant::Robot(robot) => self.step(robot, now, stimulus),
            Participant::Coordinator => Reaction {
                published: Vec::new(),
                route: None,
                wake_at: MissionTime(u64::MAX),
                activity: Activity::Cleared,
                decision: None,
            },
        })
    }

    fn digest(&mut self, who: Participant, _: MissionTime) -> Result<Digest, Self::Error> {
        Ok(match who {
            Participant::Robot(robot) => self.agents[usize::from(robot.0) - 1].belief().digest(),
            Participant::Coordinator => Digest(0),
        })
    }
}
