//! The inbox: takes in each observation exactly once, and asks for what is missing.
//!
//! Robots and coordinator keep the same kind of inbox. Whoever is heard of having more of any robot's observations,
//! that robot's or another's, is asked for them, so that what a lost robot saw spreads from whoever heard it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use dragnet_search::observation::{Entry, Observation, ObservationLog, Origin, Version};

use crate::message::{LogReply, LogRequest, Message, Participant};
use crate::time::MissionTime;

/// What one participant knows of all observations.
#[derive(Clone, Debug)]
pub struct Inbox {
    owner: Participant,
    /// How long an answer is waited for before the question is asked again.
    patience: Duration,
    log: ObservationLog,
    asked: BTreeMap<Origin, MissionTime>,
}

/// What a message brought.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Received {
    /// Observations that were not known: their readings count now.
    pub new: Vec<Arc<Observation>>,
    /// What to answer or to ask, and whom.
    pub replies: Vec<(Participant, Message)>,
    /// Observations refused since another of the same name is known.
    pub conflicting: usize,
}

impl Inbox {
    /// An empty inbox.
    #[must_use]
    pub fn new(owner: Participant, patience: Duration) -> Self {
        Self { owner, patience, log: ObservationLog::default(), asked: BTreeMap::new() }
    }

    /// All observations known.
    #[must_use]
    pub const fn log(&self) -> &ObservationLog {
        &self.log
    }

    /// Takes in an observation of the owner's own.
    pub fn record(&mut self, observation: Arc<Observation>) -> Entry {
        self.log.insert(observation)
    }

    /// Takes in a message from another participant.
    pub fn receive(&mut self, now: MissionTime, from: Participant, message: &Message) -> Received {
        let mut received = Received::default();
        match message {
            Message::Observation(observation) => {
                self.take(observation, &mut received);
                if self.log.has_gap(observation.origin) {
                    self.ask(now, from, observation.origin, &mut received);
                }
            }
            Message::Heartbeat(heartbeat) => self.compare(now, from, &heartbeat.versions, &mut received),
            Message::MissionStatus(status) => self.compare(now, from, &status.versions, &mut received),
            Message::LogRequest(request) => self.answer(*request, &mut received),
            Message::LogReply(reply) => self.take_repeated(now, from, reply, &mut received),
            Message::Intent(_) => {}
        }
        received
    }

    /// Asks for what somebody else knows.
    fn compare(
        &mut self,
        now: MissionTime,
        from: Participant,
        versions: &[Version],
        received: &mut Received,
    ) {
        for version in versions {
            if version.may_help(self.log.version(version.origin)) {
                self.ask(now, from, version.origin, received);
            }
        }
    }

    fn take_repeated(
        &mut self,
        now: MissionTime,
        from: Participant,
        reply: &LogReply,
        received: &mut Received,
    ) {
        for observation in &reply.observations {
            self.take(observation, received);
        }
        // A full reply may have left some out.
        if let Some(last) = reply.observations.last()
            && reply.observations.len() == LogReply::MAX_OBSERVATIONS
        {
            self.ask_from(now, from, last.origin, last.sequence + 1, received);
        }
    }

    fn take(&mut self, observation: &Arc<Observation>, received: &mut Received) {
        match self.log.insert(Arc::clone(observation)) {
            Entry::New => received.new.push(Arc::clone(observation)),
            Entry::Known => {}
            Entry::Conflicting => received.conflicting += 1,
        }
    }

    fn ask(&mut self, now: MissionTime, whom: Participant, of: Origin, received: &mut Received) {
        if self.asked.get(&of).is_some_and(|&asked| now < asked + self.patience) {
            return;
        }
        self.ask_from(now, whom, of, self.log.next(of), received);
    }

    fn ask_from(
        &mut self,
        now: MissionTime,
        whom: Participant,
        of: Origin,
        first: u64,
        received: &mut Received,
    ) {
        self.asked.insert(of, now);
        let request = LogRequest { from: self.owner, of, first };
        received.replies.push((whom, Message::LogRequest(request)));
    }

    fn answer(&self, request: LogRequest, received: &mut Received) {
        let observations: Vec<Arc<Observation>> =
            self.log.since(request.of, request.first).take(LogReply::MAX_OBSERVATIONS).cloned().collect();
        if !observations.is_empty() {
            received.replies.push((request.from, Message::LogReply(LogReply { observations })));
        }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;
    use dragnet_search::evidence::Digest;
    use dragnet_search::observation::RobotId;

    use super::*;
    use crate::directive::Directive;
    use crate::message::{Activity, Heartbeat, Intent};

    const SECOND: Duration = Duration::from_secs(1);

    fn robot(number: u16) -> Participant {
        Participant::Robot(RobotId(number))
    }

    fn observation(robot: u16, sequence: u64) -> Arc<Observation> {
        let from = Grid::new(1, 1).unwrap().cells().next().unwrap();
        Arc::new(Observation {
            origin: Origin::first(RobotId(robot)),
            sequence,
            time_ns: 0,
            from,
            readings: Vec::new(),
        })
    }

    fn heartbeat(versions: Vec<Version>) -> Message {
        let cell = Grid::new(1, 1).unwrap().cells().next().unwrap();
        let intent = Intent { origin: Origin::first(RobotId(2)), decision: 0, time_ns: 0, path: Vec::new() };
        Message::Heartbeat(Heartbeat {
            robot: RobotId(2),
            time_ns: 0,
            activity: Activity::Searching,
            cell,
            path_meters: 0.0,
            intent,
            versions,
            digest: Digest(0),
            directive: Directive::default(),
        })
    }

    /// Hands every reply to the inbox that it is for until none is left; returns how many there were.
    fn settle(
        now: MissionTime,
        inboxes: &mut [Inbox],
        first: Vec<(Participant, Participant, Message)>,
    ) -> usize {
        let mut pending = first;
        let mut count = 0;
        while let Some((from, to, message)) = pending.pop() {
            count += 1;
            let inbox = inboxes.iter_mut().find(|inbox| inbox.owner == to).unwrap();
            let replies = inbox.receive(now, from, &message).replies;
            pending.extend(replies.into_iter().map(|(whom, reply)| (to, whom, reply)));
        }
        count
    }

    #[test]
    fn a_gap_is_repaired_by_whoever_has_it_even_for_a_lost_robot() {
        let mut inboxes = [Inbox::new(robot(1), SECOND), Inbox::new(robot(2), SECOND)];
        // Robot 3 is lost; robot 2 heard all of it, robot 1 nothing: more than fits one reply.
        for sequence in 0..150 {
            inboxes[1].receive(MissionTime::START, robot(3), &Message::Observation(observation(3, sequence)));
        }
        let versions = inboxes[1].log().versions().collect();
        settle(MissionTime::START, &mut inboxes, vec![(robot(2), robot(1), heartbeat(versions))]);
        assert_eq!(inboxes[0].log().next(Origin::first(RobotId(3))), 150);
    }

    #[test]
    fn a_question_is_not_repeated_before_its_answer_is_due() {
        let mut inbox = Inbox::new(robot(1), SECOND);
        let late = Message::Observation(observation(2, 4));
        let ask = |inbox: &mut Inbox, now| inbox.receive(now, robot(2), &late).replies.len();
        assert_eq!(ask(&mut inbox, MissionTime::START), 1);
        assert_eq!(ask(&mut inbox, MissionTime(999_999_999)), 0);
        assert_eq!(ask(&mut inbox, MissionTime::START + SECOND), 1);
    }

    #[test]
    fn what_comes_twice_counts_once() {
        let mut inbox = Inbox::new(robot(1), SECOND);
        let message = Message::Observation(observation(2, 0));
        assert_eq!(inbox.receive(MissionTime::START, robot(2), &message).new.len(), 1);
        assert_eq!(inbox.receive(MissionTime::START, robot(2), &message).new.len(), 0);
    }
}
