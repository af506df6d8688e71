//! The participants of a simulated mission, wherever they run.

mod shared;

use std::sync::Arc;

use dragnet_agent::agent::Agent;
use dragnet_proto::convert::Codec;
use dragnet_proto::message::{Activity, Message};
use dragnet_proto::radio::Load;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_proto::step::MessageRef;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;

pub use shared::SharedParticipants;

/// The participants, as driven by the simulator: in this process, or over a network.
///
/// A published message is opaque here: the simulator determines when, and whether, it reaches each receiver, without
/// knowing its content.
pub trait Participants {
    /// A published message, or a reference to it.
    type MessageRef: Clone + Published;
    /// Why a participant failed.
    type Error;

    /// Passes an event to a participant; returns its effects.
    ///
    /// # Errors
    /// If it fails.
    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Self::MessageRef>,
    ) -> Result<Effects<Self::MessageRef>, Self::Error>;

    /// Passes events that happen at one time to as many robots, which cannot hear of each other's; returns their effects
    /// in this order.
    ///
    /// # Errors
    /// If one of them fails.
    fn step_together(
        &mut self,
        steps: Vec<(Participant, MissionTime, Event<Self::MessageRef>)>,
    ) -> Result<Vec<Effects<Self::MessageRef>>, Self::Error> {
        steps.into_iter().map(|(participant, now, event)| self.step(participant, now, event)).collect()
    }

    /// Delivers one message to several participants, by number and the coordinator last, each at its own time; returns
    /// their reactions in this order.
    ///
    /// # Errors
    /// If one of them fails.
    fn deliver(
        &mut self,
        from: Participant,
        message: &Self::MessageRef,
        to: &[(Participant, MissionTime)],
    ) -> Result<Vec<Reaction<Self::MessageRef>>, Self::Error> {
        to.iter()
            .map(|&(participant, now)| {
                let event = Event::Received { from, message: message.clone() };
                self.step(participant, now, event).map(Reaction::from)
            })
            .collect()
    }

    /// Digest of a participant's evidence.
    ///
    /// # Errors
    /// If it fails.
    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, Self::Error>;
}

/// The effects of a message as far as the simulator carries them out: those of most messages are no more than these.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction<M> {
    /// As [`Effects::wake_at`].
    pub wake_at: MissionTime,
    /// As [`Effects::activity`].
    pub activity: Activity,
    /// All effects, if anything is published, decided or driven.
    pub effects: Option<Box<Effects<M>>>,
}

impl<M> From<Effects<M>> for Reaction<M> {
    fn from(effects: Effects<M>) -> Self {
        let Effects { wake_at, activity, .. } = effects;
        let is_quiet = effects.published.is_empty() && effects.route.is_none() && effects.decision.is_none();
        Self { wake_at, activity, effects: if is_quiet { None } else { Some(Box::new(effects)) } }
    }
}

/// A published message as the network sees it.
pub trait Published {
    /// Its kind, priority and size in a mission's encoding.
    fn load(&self, codec: &Codec) -> Load;
}

impl Published for Message {
    fn load(&self, codec: &Codec) -> Load {
        Load::new(self, codec.encoded_len(self))
    }
}

impl<P: Published> Published for Arc<P> {
    fn load(&self, codec: &Codec) -> Load {
        (**self).load(codec)
    }
}

impl Published for MessageRef {
    fn load(&self, _: &Codec) -> Load {
        self.load
    }
}

impl<C: Participants> Participants for &mut C {
    type MessageRef = C::MessageRef;
    type Error = C::Error;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<C::MessageRef>,
    ) -> Result<Effects<C::MessageRef>, C::Error> {
        (**self).step(participant, now, event)
    }

    fn step_together(
        &mut self,
        steps: Vec<(Participant, MissionTime, Event<C::MessageRef>)>,
    ) -> Result<Vec<Effects<C::MessageRef>>, C::Error> {
        (**self).step_together(steps)
    }

    fn deliver(
        &mut self,
        from: Participant,
        message: &C::MessageRef,
        to: &[(Participant, MissionTime)],
    ) -> Result<Vec<Reaction<C::MessageRef>>, C::Error> {
        (**self).deliver(from, message, to)
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, C::Error> {
        (**self).digest(participant, now)
    }
}

/// Participants of this process.
pub struct LocalParticipants<'a> {
    robots: &'a mut [Agent],
    coordinator: Option<&'a mut dyn StateMachine>,
}

impl<'a> LocalParticipants<'a> {
    /// Participants made of these robots, which have the numbers from 1 in this order, and of their coordinator, if
    /// there is one.
    #[must_use]
    pub const fn new(robots: &'a mut [Agent], coordinator: Option<&'a mut dyn StateMachine>) -> Self {
        Self { robots, coordinator }
    }

    pub(crate) fn absent(participant: Participant) -> ParticipantError {
        ParticipantError { participant, reason: "it does not take part".to_owned() }
    }

    fn machine(&mut self, participant: Participant) -> Result<&mut dyn StateMachine, ParticipantError> {
        let absent = || Self::absent(participant);
        match participant {
            Participant::Robot(robot) => {
                let robot = self.robots.get_mut(robot.index()).ok_or_else(absent)?;
                Ok(robot)
            }
            Participant::Coordinator => match &mut self.coordinator {
                Some(coordinator) => Ok(*coordinator),
                None => Err(absent()),
            },
        }
    }
}

impl Participants for LocalParticipants<'_> {
    type MessageRef = Message;
    type Error = ParticipantError;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        self.machine(participant)?.handle(now, event)
    }

    fn digest(&mut self, participant: Participant, _: MissionTime) -> Result<Digest, ParticipantError> {
        Ok(self.machine(participant)?.digest())
    }
}
