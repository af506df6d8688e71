//! Those who take part in a simulated mission, wherever they run.

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::participant::{Mind, MindError, Reaction, Stimulus};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;

/// The team as the simulator drives it: in this process, or behind a network.
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

impl<C: Crew> Crew for &mut C {
    type Parcel = C::Parcel;
    type Error = C::Error;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        stimulus: Stimulus<C::Parcel>,
    ) -> Result<Reaction<C::Parcel>, C::Error> {
        (**self).step(who, now, stimulus)
    }

    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, C::Error> {
        (**self).digest(who, now)
    }
}

/// Minds of this process.
pub struct LocalCrew<'a> {
    robots: &'a mut [Agent],
    coordinator: Option<&'a mut dyn Mind>,
}

impl<'a> LocalCrew<'a> {
    /// Robots, numbered from 1 in this order, and their coordinator, if there is one.
    #[must_use]
    pub const fn new(robots: &'a mut [Agent], coordinator: Option<&'a mut dyn Mind>) -> Self {
        Self { robots, coordinator }
    }

    fn mind(&mut self, who: Participant) -> Result<&mut dyn Mind, MindError> {
        let absent = MindError { who, reason: "it is not in the crew".to_owned() };
        match who {
            Participant::Robot(robot) => {
                let place = usize::from(robot.0).checked_sub(1);
                let robot = place.and_then(|place| self.robots.get_mut(place)).ok_or(absent)?;
                Ok(robot)
            }
            Participant::Coordinator => match &mut self.coordinator {
                Some(coordinator) => Ok(*coordinator),
                None => Err(absent),
            },
        }
    }
}

impl Crew for LocalCrew<'_> {
    type Parcel = Message;
    type Error = MindError;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Result<Reaction<Message>, MindError> {
        self.mind(who)?.experience(now, stimulus)
    }

    fn digest(&mut self, who: Participant, _: MissionTime) -> Result<Digest, MindError> {
        Ok(self.mind(who)?.digest())
    }
}
