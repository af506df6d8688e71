//! Participants of a large team in this process: a message is shared by all its receivers, never copied, and several
//! threads may deliver it.

use std::hint::black_box;
use std::sync::{Arc, Mutex, PoisonError};

use dragnet_agent::agent::Agent;
use dragnet_proto::knowledge::SharedKnowledge;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::{LocalParticipants, Participants, Reaction};

/// Receivers that one thread takes at a time; so few are delivered to sooner than another thread would wake.
const AT_A_TIME: usize = 64;

/// Robots and their coordinator, if there is one, like [`LocalParticipants`]. They share what they know. Their effects are
/// the same for every number of threads: what happens to several participants at one time changes each of them
/// independently.
pub struct SharedParticipants<'a> {
    participants: LocalParticipants<'a>,
    /// The threads besides the caller's.
    helpers: Option<ThreadPool>,
}

type Stepped = Result<Effects<Arc<Message>>, ParticipantError>;
type Reactions = Vec<Reaction<Arc<Message>>>;

/// What a thread has to do.
type Job<'j> = Box<dyn FnOnce() + Send + 'j>;

impl<'a> SharedParticipants<'a> {
    /// Robots, numbered from 1 in this order, and their coordinator, if there is one. If no other thread can be started,
    /// the caller's does it all.
    #[must_use]
    pub fn new(
        robots: &'a mut [Agent],
        coordinator: Option<&'a mut dyn StateMachine>,
        threads: usize,
    ) -> Self {
        let knowledge = SharedKnowledge::default();
        for robot in robots.iter_mut() {
            robot.share(&knowledge);
        }
        let is_worth_it = threads > 1 && robots.len() > AT_A_TIME;
        let helpers = ThreadPoolBuilder::new().num_threads(threads.saturating_sub(1).max(1));
        Self {
            participants: LocalParticipants::new(robots, coordinator),
            helpers: if is_worth_it { helpers.build().ok() } else { None },
        }
    }
}

impl Participants for SharedParticipants<'_> {
    type MessageRef = Arc<Message>;
    type Error = ParticipantError;

    fn step(&mut self, participant: Participant, now: MissionTime, event: Event<Arc<Message>>) -> Stepped {
        step(self.participants.machine(participant)?, now, event)
    }

    fn step_together(
        &mut self,
        steps: Vec<(Participant, MissionTime, Event<Arc<Message>>)>,
    ) -> Result<Vec<Effects<Arc<Message>>>, ParticipantError> {
        let Some(helpers) = self.helpers.as_ref().filter(|_| steps.len() > 1) else {
            return steps.into_iter().map(|(of, now, event)| self.step(of, now, event)).collect();
        };
        let mut agents: Vec<Option<&mut Agent>> = self.participants.robots.iter_mut().map(Some).collect();
        let mut stepped: Vec<Option<Stepped>> = Vec::new();
        stepped.resize_with(steps.len(), || None);
        let mut jobs: Vec<Job<'_>> = Vec::new();
        for ((participant, now, event), stepped) in steps.into_iter().zip(&mut stepped) {
            let agent = index(participant).and_then(|index| agents.get_mut(index)?.take());
            let agent = agent.ok_or_else(|| LocalParticipants::absent(participant))?;
            jobs.push(Box::new(move || *stepped = Some(step(agent, now, event))));
        }
        work(helpers, jobs);
        stepped.into_iter().flatten().collect()
    }

    fn deliver(
        &mut self,
        from: Participant,
        message: &Arc<Message>,
        to: &[(Participant, MissionTime)],
    ) -> Result<Reactions, ParticipantError> {
        let robots: Vec<(usize, MissionTime)> =
            to.iter().map_while(|&(participant, now)| Some((index(participant)?, now))).collect();
        let others = &to[robots.len()..];
        let in_order = robots.is_sorted_by(|(a, _), (b, _)| a < b);
        match &self.helpers {
            Some(helpers) if in_order && others.len() < 2 && robots.len() > AT_A_TIME => {
                let LocalParticipants { robots: agents, coordinator } = &mut self.participants;
                let coordinator = coordinator.as_deref_mut();
                deliver_together(helpers, agents, coordinator, from, message, &robots, others)
            }
            _ => {
                let mut reactions = deliver_to(self.participants.robots, 0, &robots, from, message);
                for &(participant, now) in others {
                    let machine = self.participants.machine(participant)?;
                    reactions.push(machine.receive(now, from, message)?.map(Arc::new).into());
                }
                Ok(reactions)
            }
        }
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

fn step(machine: &mut dyn StateMachine, now: MissionTime, event: Event<Arc<Message>>) -> Stepped {
    let effects = match event.into_message() {
        Ok((from, message)) => machine.receive(now, from, &message)?,
        Err(event) => machine.handle(now, event)?,
    };
    Ok(effects.map(Arc::new))
}

/// Does all jobs: each thread, the caller's too, takes the next that is left.
fn work(helpers: &ThreadPool, jobs: Vec<Job<'_>>) {
    let jobs = Mutex::new(jobs.into_iter());
    let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(job) = next() {
            job();
        }
    };
    helpers.in_place_scope(|scope| {
        for _ in 0..helpers.current_num_threads() {
            scope.spawn(|_| work());
        }
        work();
    });
}

/// Delivers a message to robots, in order, and to the coordinator, if it is the other receiver, by several threads.
fn deliver_together(
    helpers: &ThreadPool,
    mut agents: &mut [Agent],
    coordinator: Option<&mut (dyn StateMachine + '_)>,
    from: Participant,
    message: &Arc<Message>,
    robots: &[(usize, MissionTime)],
    others: &[(Participant, MissionTime)],
) -> Result<Reactions, ParticipantError> {
    let mut delivered: Vec<Reactions> = Vec::new();
    delivered.resize_with(robots.len().div_ceil(AT_A_TIME), Vec::new);
    let mut last = None;
    let mut jobs: Vec<Job<'_>> = Vec::new();
    if let Some(&(participant, now)) = others.first() {
        let machine = coordinator.ok_or_else(|| LocalParticipants::absent(participant))?;
        let last = &mut last;
        // It has more to do than a robot.
        jobs.push(Box::new(move || {
            *last = Some(machine.receive(now, from, message));
        }));
    }
    let mut first = 0;
    for (receivers, delivered) in robots.chunks(AT_A_TIME).zip(&mut delivered) {
        let end = receivers.last().map_or(first, |&(index, _)| index + 1);
        let (mine, others) = agents.split_at_mut(end - first);
        jobs.push(Box::new(move || *delivered = deliver_to(mine, first, receivers, from, message)));
        (agents, first) = (others, end);
    }
    work(helpers, jobs);
    let mut reactions: Reactions = delivered.into_iter().flatten().collect();
    if let Some(effects) = last {
        reactions.push(effects?.map(Arc::new).into());
    }
    Ok(reactions)
}

/// Delivers a message to those of these agents that receive it, by index in the team; `first` is the index of the first
/// agent.
fn deliver_to(
    agents: &mut [Agent],
    first: usize,
    receivers: &[(usize, MissionTime)],
    from: Participant,
    message: &Message,
) -> Reactions {
    if let Participant::Robot(robot) = from {
        // What each receiver knows of the sender is far from the processor: all of it is fetched at one time.
        black_box(receivers.iter().filter_map(|&(index, _)| agents[index - first].heard(robot)).max());
    }
    let mut reactions = Vec::with_capacity(receivers.len());
    for &(index, now) in receivers {
        let effects = agents[index - first].receive(now, from, message);
        reactions.push(effects.map(Arc::new).into());
    }
    reactions
}
