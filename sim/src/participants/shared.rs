//! Participants of a large team in this process: a message is shared by all its receivers, never copied, and several
//! threads may deliver it.

use std::sync::Arc;

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::{LocalParticipants, Participants};

/// For fewer receivers one thread delivers a message sooner than it could wake another.
const LEAST_RECEIVERS: usize = 64;

/// Robots and their coordinator, if there is one, like [`LocalParticipants`]. Their effects are the same for every
/// number of threads: a message that several participants receive at one time changes each of them independently.
pub struct SharedParticipants<'a> {
    participants: LocalParticipants<'a>,
    /// The threads besides the caller's.
    helpers: Option<ThreadPool>,
    threads: usize,
}

type Delivered = Result<Effects<Arc<Message>>, ParticipantError>;

impl<'a> SharedParticipants<'a> {
    /// Robots, numbered from 1 in this order, and their coordinator, if there is one. If no other thread can be started,
    /// the caller's does it all.
    #[must_use]
    pub fn new(
        robots: &'a mut [Agent],
        coordinator: Option<&'a mut dyn StateMachine>,
        threads: usize,
    ) -> Self {
        let is_worth_it = threads > 1 && robots.len() > LEAST_RECEIVERS;
        let helpers = ThreadPoolBuilder::new().num_threads(threads.saturating_sub(1).max(1));
        Self {
            participants: LocalParticipants::new(robots, coordinator),
            helpers: if is_worth_it { helpers.build().ok() } else { None },
            threads: threads.max(1),
        }
    }
}

impl Participants for SharedParticipants<'_> {
    type MessageRef = Arc<Message>;
    type Error = ParticipantError;

    fn step(&mut self, participant: Participant, now: MissionTime, event: Event<Arc<Message>>) -> Delivered {
        let machine = self.participants.machine(participant)?;
        match event.into_message() {
            Ok((from, message)) => receive(machine, now, from, &message),
            Err(event) => Ok(machine.handle(now, event)?.map(Arc::new)),
        }
    }

    fn deliver(
        &mut self,
        from: Participant,
        message: &Arc<Message>,
        to: &[(Participant, MissionTime)],
    ) -> Result<Vec<Effects<Arc<Message>>>, ParticipantError> {
        let robots: Vec<(usize, MissionTime)> =
            to.iter().map_while(|&(participant, now)| Some((index(participant)?, now))).collect();
        let in_order = robots.is_sorted_by(|(a, _), (b, _)| a < b);
        let (Some(helpers), true) = (&self.helpers, in_order && robots.len() > LEAST_RECEIVERS) else {
            return to
                .iter()
                .map(|&(participant, now)| {
                    receive(self.participants.machine(participant)?, now, from, message)
                })
                .collect();
        };
        let share = robots.len().div_ceil(self.threads).max(LEAST_RECEIVERS / 2);
        let mut delivered: Vec<Vec<Delivered>> = Vec::new();
        delivered.resize_with(robots.len().div_ceil(share), Vec::new);
        let mut shares = Vec::new();
        let (mut agents, mut first) = (&mut *self.participants.robots, 0);
        for (receivers, delivered) in robots.chunks(share).zip(&mut delivered) {
            let end = receivers.last().map_or(first, |&(index, _)| index + 1);
            let (mine, others) = agents.split_at_mut(end - first);
            shares.push((mine, first, receivers, delivered));
            (agents, first) = (others, end);
        }
        helpers.in_place_scope(|scope| {
            let own = shares.pop();
            for (agents, first, receivers, delivered) in shares {
                scope.spawn(move |_| *delivered = deliver_to(agents, first, receivers, from, message));
            }
            if let Some((agents, first, receivers, delivered)) = own {
                *delivered = deliver_to(agents, first, receivers, from, message);
            }
        });
        let mut effects = Vec::with_capacity(to.len());
        for delivered in delivered.into_iter().flatten() {
            effects.push(delivered?);
        }
        for &(participant, now) in &to[robots.len()..] {
            effects.push(receive(self.participants.machine(participant)?, now, from, message)?);
        }
        Ok(effects)
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, ParticipantError> {
        self.participants.digest(participant, now)
    }
}

/// A robot's index in its team.
fn index(participant: Participant) -> Option<usize> {
    match participant {
        Participant::Robot(robot) => Some(robot.index()),
        Participant::Coordinator => None,
    }
}

/// Delivers a message to those of these agents that receive it, by index in the team; `first` is the index of the first
/// agent.
fn deliver_to(
    agents: &mut [Agent],
    first: usize,
    receivers: &[(usize, MissionTime)],
    from: Participant,
    message: &Message,
) -> Vec<Delivered> {
    receivers.iter().map(|&(index, now)| receive(&mut agents[index - first], now, from, message)).collect()
}

fn receive(
    machine: &mut dyn StateMachine,
    now: MissionTime,
    from: Participant,
    message: &Message,
) -> Delivered {
    Ok(machine.receive(now, from, message)?.map(Arc::new))
}
