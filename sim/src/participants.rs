//! Those who take part in a simulated mission, wherever they run.

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;

/// The team as the simulator drives it: in this process, or behind a network.
///
/// A published message is opaque here: the simulator decides when, and whether, it reaches whom, and need not know what is
/// in it.
pub trait Participants {
    /// A published message, or its name.
    type MessageRef: Clone;
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
        event: Event<Self::MessageRef>,
    ) -> Result<Effects<Self::MessageRef>, Self::Error>;

    /// Digest of a participant's evidence.
    ///
    /// # Errors
    /// If it cannot go on.
    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, Self::Error>;
}

impl<C: Participants> Participants for &mut C {
    type MessageRef = C::MessageRef;
    type Error = C::Error;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        event: Event<C::MessageRef>,
    ) -> Result<Effects<C::MessageRef>, C::Error> {
        (**self).step(who, now, event)
    }

    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, C::Error> {
        (**self).digest(who, now)
    }
}

/// Minds of this process.
pub struct LocalParticipants<'a> {
    robots: &'a mut [Agent],
    coordinator: Option<&'a mut dyn StateMachine>,
}

impl<'a> LocalParticipants<'a> {
    /// Robots, numbered from 1 in this order, and their coordinator, if there is one.
    #[must_use]
    pub const fn new(robots: &'a mut [Agent], coordinator: Option<&'a mut dyn StateMachine>) -> Self {
        Self { robots, coordinator }
    }

    fn mind(&mut self, who: Participant) -> Result<&mut dyn StateMachine, ParticipantError> {
        let absent = ParticipantError { who, reason: "it does not take part".to_owned() };
        match who {
            Participant::Robot(robot) => {
                let robot = self.robots.get_mut(robot.index()).ok_or(absent)?;
                Ok(robot)
            }
            Participant::Coordinator => match &mut self.coordinator {
                Some(coordinator) => Ok(*coordinator),
                None => Err(absent),
            },
        }
    }
}

impl Participants for LocalParticipants<'_> {
    type MessageRef = Message;
    type Error = ParticipantError;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        self.mind(who)?.handle(now, event)
    }

    fn digest(&mut self, who: Participant, _: MissionTime) -> Result<Digest, ParticipantError> {
        Ok(self.mind(who)?.digest())
    }
}
