//! The replica: counts each valid observation exactly once, in the order of its origin, and requests missing ones.
//!
//! The operator's verdicts and marks are merged as they come: each message holds all that its sender knows.
//!
//! This is anti-entropy replication of append-only logs, the same at robots and coordinator. A participant whose
//! version vector reports more observations of any robot, its own or another's, is asked for them, so that the
//! observations of a lost robot spread from any participant that received them.
//!
//! If an observation is lost permanently, for example because a robot lost its storage before any participant had
//! received it, the log of its origin ends there: no participant counts later observations of that origin.

mod questions;

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use dragnet_scenario::Class;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Entry, Observation, ObservationLog, Origin, Source, Versions};

use self::questions::Questions;
use crate::knowledge::Knowledge;
use crate::message::{Message, SyncReply, SyncRequest};
use crate::validation::{Limits, Rejected, Rejection, RejectionKind};

/// Maximum number of incarnations of one robot. Incarnations are named by numbers of 64 bits: without a limit, invented
/// ones could fill any memory.
pub const MAX_STARTS: usize = 1024;

/// One participant's copy of all observations, and what it knows by them.
#[derive(Clone, Debug)]
pub struct Replica {
    owner: Participant,
    limits: Limits,
    /// The maximum number of observations in one reply.
    max_observations: usize,
    knowledge: Knowledge,
    questions: Questions,
    rejected: BTreeMap<RejectionKind, u64>,
}

/// The result of receiving a message.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Received {
    /// New observations, whose readings count from now on.
    pub new: Vec<Arc<Observation>>,
    /// Cells with a new verdict of the operator, which counts from now on.
    pub judged: Vec<Cell>,
    /// Cells that new marks of the operator concern, which count from now on; `None` if there are none.
    pub marked: Option<BTreeSet<Cell>>,
    /// Requests and replies to send.
    pub replies: Vec<(Participant, Message)>,
    /// Requests for observations that were released, to be answered from where they are stored.
    pub repeats: Vec<SyncRequest>,
    /// Rejected messages and observations.
    pub rejected: Vec<Rejected>,
}

impl Replica {
    /// A replica with this knowledge. A request is repeated if it is not answered within `patience`.
    #[must_use]
    pub fn new(owner: Participant, patience: Duration, limits: Limits, knowledge: Knowledge) -> Self {
        let (questions, rejected) = (Questions::new(patience), BTreeMap::new());
        Self { owner, limits, max_observations: SyncReply::MAX_OBSERVATIONS, knowledge, questions, rejected }
    }

    /// The same with replies of at most this number of observations, 1 to [`SyncReply::MAX_OBSERVATIONS`]: the whole team's.
    #[must_use]
    pub fn with_max_observations(self, most: usize) -> Self {
        Self { max_observations: most.clamp(1, SyncReply::MAX_OBSERVATIONS), ..self }
    }

    /// All observations known.
    #[must_use]
    pub fn log(&self) -> &ObservationLog {
        self.knowledge.log()
    }

    /// What it knows by the observations.
    #[must_use]
    pub const fn knowledge(&self) -> &Knowledge {
        &self.knowledge
    }

    /// The same, to share it or to search further cells; observations are counted by receiving and recording them.
    pub const fn knowledge_mut(&mut self) -> &mut Knowledge {
        &mut self.knowledge
    }

    /// Keeps at most the last `held` observations of each origin in memory: the others are stored elsewhere, from where
    /// requests for them, [`Received::repeats`], are answered.
    pub fn release(&mut self, held: NonZeroUsize) {
        self.knowledge.release(held);
    }

    /// Rejections, and their numbers.
    #[must_use]
    pub const fn rejected(&self) -> &BTreeMap<RejectionKind, u64> {
        &self.rejected
    }

    /// Records an observation that the owner made, or had stored. It is validated by the same limits as those of
    /// others: an observation that others reject must not count here either.
    ///
    /// # Errors
    /// If validation rejects it: the reason.
    pub fn record(&mut self, observation: &Arc<Observation>) -> Result<Entry, Rejected> {
        let of = observation.origin.source;
        self.offer(observation).map_err(|why| self.reject(self.owner, of, why))
    }

    /// Receives a message of another participant.
    pub fn receive(&mut self, now: MissionTime, from: Participant, message: &Message) -> Received {
        let mut received = Received::default();
        if let Participant::Robot(of) = from
            && !self.limits.knows(from)
        {
            received.rejected.push(self.reject(from, of.into(), Rejection::Stranger));
            return received;
        }
        match message {
            Message::Observation(observation) => {
                if self.take(now, from, observation, &mut received) == Some(Entry::Early) {
                    self.request(now, from, observation.origin, &mut received);
                }
            }
            Message::Heartbeat(heartbeat) => self.compare(now, from, &heartbeat.versions, &mut received),
            Message::MissionStatus(status) => self.compare(now, from, &status.versions, &mut received),
            Message::SyncRequest(request) => self.answer(*request, &mut received),
            Message::SyncReply(reply) => self.take_repeated(now, from, reply, &mut received),
            Message::Verdicts(report) => received.judged = self.knowledge.judge(now, &report.verdicts),
            Message::Marks(report) => {
                let grid = self.limits.terrain().grid();
                received.marked = self.knowledge.mark(now, &report.marks, grid);
            }
            Message::Intent(_) | Message::Orders(_) | Message::Zones(_) => {}
        }
        received
    }

    /// Requests the observations of another participant's version vector that are missing here.
    fn compare(&mut self, now: MissionTime, from: Participant, versions: &Versions, received: &mut Received) {
        for origin in self.log().missing(versions) {
            self.request(now, from, origin, received);
        }
    }

    fn take_repeated(
        &mut self,
        now: MissionTime,
        from: Participant,
        reply: &SyncReply,
        received: &mut Received,
    ) {
        for observation in &reply.observations {
            self.take(now, from, observation, received);
        }
        // A full reply may have left some out. After one without new observations the request is not repeated.
        if let Some(last) = received.new.last()
            && reply.observations.len() >= self.max_observations
        {
            self.ask_now(now, from, last.origin, received);
        }
    }

    /// Takes an observation; `None` if it was rejected.
    fn take(
        &mut self,
        now: MissionTime,
        from: Participant,
        observation: &Arc<Observation>,
        received: &mut Received,
    ) -> Option<Entry> {
        let dated = self.limits.check_date(now, observation);
        match dated.and_then(|()| self.offer(observation)) {
            Ok(entry) => {
                if entry == Entry::New {
                    self.questions.answered(observation.origin);
                    received.new.push(Arc::clone(observation));
                }
                Some(entry)
            }
            Err(why) => {
                received.rejected.push(self.reject(from, observation.origin.source, why));
                None
            }
        }
    }

    /// Only the next observation of an origin is validated: an early one is sent again, when those before it are known.
    fn offer(&mut self, observation: &Arc<Observation>) -> Result<Entry, Rejection> {
        if self.knowledge.follow(observation) {
            return Ok(Entry::New);
        }
        match self.log().entry(observation) {
            Entry::New => {
                let known = self.log().ends(observation.origin);
                if known.is_none() && self.log().incarnations(observation.origin.source) >= MAX_STARTS {
                    return Err(Rejection::TooManyStarts);
                }
                self.limits.check(observation, known)?;
                let sight = self.limits.class(observation.origin.source).map(Class::sight);
                self.knowledge.count(self.limits.terrain(), sight, observation);
                Ok(Entry::New)
            }
            Entry::Conflicting => Err(Rejection::Conflicting),
            entry @ (Entry::Known | Entry::Early) => Ok(entry),
        }
    }

    fn reject(&mut self, from: Participant, of: Source, why: Rejection) -> Rejected {
        let counted = RejectionKind {
            from: Some(from).filter(|&from| self.limits.knows(from)),
            of: Some(of).filter(|_| why != Rejection::Stranger),
            why,
        };
        *self.rejected.entry(counted).or_default() += 1;
        Rejected { from, of, why }
    }

    fn request(&mut self, now: MissionTime, whom: Participant, of: Origin, received: &mut Received) {
        let is_new = self.log().next(of) == 0;
        let is_pointless =
            !self.limits.counts(of.source) || is_new && self.log().incarnations(of.source) >= MAX_STARTS;
        if !is_pointless && self.questions.may_request(now, whom, of) {
            self.ask_now(now, whom, of, received);
        }
    }

    fn ask_now(&mut self, now: MissionTime, whom: Participant, of: Origin, received: &mut Received) {
        self.questions.ask(now, whom, of);
        let request = SyncRequest { from: self.owner, of, first: self.log().next(of) };
        received.replies.push((whom, Message::SyncRequest(request)));
    }

    fn answer(&self, request: SyncRequest, received: &mut Received) {
        let held = self.log().since(request.of, request.first);
        let observations = held[..held.len().min(self.max_observations)].to_vec();
        if !observations.is_empty() {
            received.replies.push((request.from, Message::SyncReply(SyncReply { observations })));
        } else if request.first < self.log().next(request.of) {
            received.repeats.push(request);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_scenario::Scenario;
    use dragnet_search::cell::Grid;
    use dragnet_search::evidence::Digest;
    use dragnet_search::intent::PlannedPath;
    use dragnet_search::observation::{RobotId, Version};

    use super::questions::MOST_TO_ONE;
    use super::*;
    use crate::directive::Directive;
    use crate::message::{Activity, Heartbeat, Intent};

    const SECOND: Duration = Duration::from_secs(1);

    fn robot(number: u16) -> Participant {
        Participant::Robot(RobotId::new(number).unwrap())
    }

    fn replica(number: u16) -> Replica {
        let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 2 }\nobjects.count = 1\nsensor.radius = 1\n\
                    mission = { budget_seconds = 60.0, speed_meters_per_second = 100.0 }\nrobots.count = 3\n";
        let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
        let knowledge = Knowledge::new(scenario.terrain(), scenario.prior().clone());
        Replica::new(robot(number), SECOND, Limits::of(&scenario), knowledge)
    }

    /// One a second.
    fn observation(robot: u16, sequence: u64) -> Arc<Observation> {
        let from = Grid::new(1, 1).unwrap().cells().next().unwrap();
        Arc::new(Observation {
            origin: Origin::first(RobotId::new(robot).unwrap()),
            sequence,
            time_ns: sequence.saturating_mul(1_000_000_000),
            from,
            readings: Vec::new(),
            positions: Box::default(),
        })
    }

    fn heartbeat(versions: Vec<Version>) -> Message {
        let cell = Grid::new(1, 1).unwrap().cells().next().unwrap();
        let intent = Intent {
            robot: RobotId::new(2).unwrap(),
            incarnation: 0,
            decision: 0,
            time_ns: 0,
            path: PlannedPath::default(),
        };
        Message::Heartbeat(Heartbeat {
            robot: RobotId::new(2).unwrap(),
            time_ns: 0,
            activity: Activity::Searching,
            cell,
            path_meters: 0.0,
            intent,
            versions: versions.into(),
            digest: Digest(0),
            directive: Directive::default(),
        })
    }

    /// Delivers every reply until none is left; returns how many there were.
    fn settle(
        now: MissionTime,
        inboxes: &mut [Replica],
        first: Vec<(Participant, Participant, Message)>,
    ) -> usize {
        let mut pending = first;
        let mut count = 0;
        while let Some((from, to, message)) = pending.pop() {
            count += 1;
            let replica = inboxes.iter_mut().find(|replica| replica.owner == to).unwrap();
            let replies = replica.receive(now, from, &message).replies;
            pending.extend(replies.into_iter().map(|(whom, reply)| (to, whom, reply)));
        }
        count
    }

    #[test]
    fn a_gap_is_repaired_from_any_participant_even_for_a_lost_robot() {
        let mut inboxes = [replica(1), replica(2)];
        // Robot 3 is lost; robot 2 received all of its observations, robot 1 none: more than fit into one reply.
        let now = MissionTime::START + 150 * SECOND;
        for sequence in 0..150 {
            inboxes[1].receive(now, robot(3), &Message::Observation(observation(3, sequence)));
        }
        let versions = inboxes[1].log().versions().to_vec();
        settle(now, &mut inboxes, vec![(robot(2), robot(1), heartbeat(versions))]);
        assert_eq!(inboxes[0].log().next(Origin::first(RobotId::new(3).unwrap())), 150);
    }

    #[test]
    fn requests_for_released_observations_are_handed_on() {
        let mut replica = replica(1);
        for sequence in 0..10 {
            replica.record(&observation(1, sequence)).unwrap();
        }
        replica.release(NonZeroUsize::new(4).unwrap());
        let mut ask = |first| {
            let request = SyncRequest { from: robot(2), of: Origin::first(RobotId::FIRST), first };
            let received = replica.receive(MissionTime::START, robot(2), &Message::SyncRequest(request));
            (received.replies.len(), received.repeats == [request])
        };
        assert_eq!(
            [0, 5, 6, 9, 10, 11].map(&mut ask),
            [(0, true), (0, true), (1, false), (1, false), (0, false), (0, false)]
        );
    }

    #[test]
    fn a_question_is_not_repeated_before_its_answer_is_due() {
        let mut replica = replica(1);
        let late = Message::Observation(observation(2, 4));
        let ask = |replica: &mut Replica, now| replica.receive(now, robot(2), &late).replies.len();
        assert_eq!(ask(&mut replica, MissionTime::START), 1);
        assert_eq!(ask(&mut replica, MissionTime(999_999_999)), 0);
        assert_eq!(ask(&mut replica, MissionTime::START + SECOND), 1);
    }

    #[test]
    fn repeated_messages_count_once() {
        let mut replica = replica(1);
        let message = Message::Observation(observation(2, 0));
        assert_eq!(replica.receive(MissionTime::START, robot(2), &message).new.len(), 1);
        assert_eq!(replica.receive(MissionTime::START, robot(2), &message).new.len(), 0);
    }

    #[test]
    fn in_any_order_of_arrival_the_same_observations_are_accepted() {
        // The fifth is from a cell that its robot cannot have reached.
        let mut published: Vec<Arc<Observation>> = (0..8).map(|sequence| observation(2, sequence)).collect();
        let mut false_reading = (*published[4]).clone();
        false_reading.origin = published[4].origin;
        false_reading.time_ns = 0;
        published[4] = Arc::new(false_reading);
        let believed = |order: &[usize]| {
            let mut replica = replica(1);
            for _ in 0..published.len() {
                for &place in order {
                    replica.receive(
                        MissionTime::START,
                        robot(2),
                        &Message::Observation(Arc::clone(&published[place])),
                    );
                }
            }
            (
                replica.log().next(published[0].origin),
                replica.rejected().keys().map(|it| it.why).collect::<Vec<_>>(),
            )
        };
        for order in [[0, 1, 2, 3, 4, 5, 6, 7], [7, 6, 5, 4, 3, 2, 1, 0], [4, 0, 5, 3, 1, 7, 6, 2]] {
            assert_eq!(believed(&order), (4, vec![Rejection::Backwards]), "{order:?}");
        }
    }

    #[test]
    fn a_full_reply_that_brings_nothing_is_not_asked_for_again() {
        let mut replica = replica(1);
        let observations: Vec<_> = (0..64).map(|sequence| observation(2, sequence)).collect();
        let reply = Message::SyncReply(SyncReply { observations });
        let now = MissionTime::START + 64 * SECOND;
        assert_eq!(replica.receive(now, robot(3), &reply).replies.len(), 1);
        assert_eq!(replica.receive(now, robot(3), &reply).replies.len(), 0);
    }

    #[test]
    fn invented_origins_fill_no_memory_and_raise_no_storm_of_questions() {
        let mut replica = replica(1);
        let invented = |robot| {
            move |incarnation| Version {
                origin: Origin { source: RobotId::new(robot).unwrap().into(), incarnation },
                next: u64::MAX,
            }
        };
        let versions = (0..60_000).map(invented(9)).chain((0..5000).map(invented(2))).collect();
        let received = replica.receive(MissionTime::START, robot(2), &heartbeat(versions));
        assert_eq!((received.replies.len(), replica.questions.len()), (MOST_TO_ONE, MOST_TO_ONE));
        // Others are asked all the same, at once.
        let reported = vec![Version { origin: Origin::first(RobotId::new(3).unwrap()), next: 1 }];
        assert_eq!(replica.receive(MissionTime::START, robot(3), &heartbeat(reported)).replies.len(), 1);
        for incarnation in 0..3000 {
            let mut start = (*observation(2, 0)).clone();
            start.origin.incarnation = incarnation;
            let reported = Message::Observation(Arc::new(start));
            replica.receive(MissionTime::START, robot(2), &reported);
        }
        assert_eq!(replica.log().len(), MAX_STARTS as u64);
        let counts: Vec<(Rejection, u64)> =
            replica.rejected().iter().map(|(it, &count)| (it.why, count)).collect();
        assert_eq!(counts, [(Rejection::TooManyStarts, 3000 - MAX_STARTS as u64)]);
    }

    #[test]
    fn messages_from_outside_the_team_are_ignored() {
        let mut replica = replica(1);
        for stranger in [4, 5, 6] {
            let received = replica.receive(
                MissionTime::START,
                robot(stranger),
                &Message::Observation(observation(2, 0)),
            );
            assert_eq!(received.rejected[0].why, Rejection::Stranger);
            replica.receive(MissionTime::START, robot(2), &Message::Observation(observation(stranger, 0)));
        }
        assert!(replica.log().is_empty());
        assert_eq!(replica.rejected().values().sum::<u64>(), 6);
        assert_eq!(replica.rejected().len(), 2, "however many there are, they take two entries");
    }

    #[test]
    fn a_participant_with_false_claims_does_not_block_requests_to_others() {
        let mut replica = replica(1);
        let versions = vec![Version { origin: Origin::first(RobotId::new(3).unwrap()), next: 9 }];
        let mut asked = Vec::new();
        for beat in 0..20 {
            // The faulty participant is always first; the other sends the same at the same time.
            for number in [2, 3] {
                let now = MissionTime::START + 2 * SECOND * beat;
                let replies = replica.receive(now, robot(number), &heartbeat(versions.clone())).replies;
                asked.extend(replies.into_iter().map(|(whom, _)| whom));
            }
        }
        assert!(asked.iter().filter(|&&whom| whom == robot(3)).count() >= 5, "{asked:?}");
    }
}
