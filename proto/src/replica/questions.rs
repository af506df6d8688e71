//! Pending sync requests: they bound how often a participant is asked, and keep one participant's claims from blocking
//! others.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::Origin;

/// A participant that was asked this often without a new observation is not asked again before others had their turn:
/// it may always claim, as the first one, to know more.
const MOST_TRIES: u32 = 3;
/// The maximum number of origins about which one participant is asked at a time, against invented origins.
pub(super) const MOST_TO_ONE: usize = 256;

/// The pending requests of one participant.
#[derive(Clone, Debug)]
pub(super) struct Questions {
    /// Time after which an unanswered request is repeated.
    patience: Duration,
    /// The last request about each origin; successful ones are removed.
    asked: BTreeMap<Origin, Question>,
    /// The same by the participant that was asked.
    to: BTreeMap<Participant, Asked>,
    #[cfg(test)]
    looked_through: u64,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    at: MissionTime,
    whom: Participant,
    /// Consecutive requests to this participant without a new observation.
    tries: u32,
}

/// Origins that a participant was asked about.
#[derive(Clone, Debug, Default)]
struct Asked {
    origins: BTreeSet<Origin>,
    /// When expired requests were last removed: at the same time there are no further ones.
    tidied: Option<MissionTime>,
}

impl Questions {
    pub(super) const fn new(patience: Duration) -> Self {
        Self {
            patience,
            asked: BTreeMap::new(),
            to: BTreeMap::new(),
            #[cfg(test)]
            looked_through: 0,
        }
    }

    /// Whether a participant may now be asked about an origin.
    pub(super) fn may_request(&mut self, now: MissionTime, whom: Participant, of: Origin) -> bool {
        match self.asked.get(&of) {
            Some(question) if !question.may_follow(now, whom, self.patience) => false,
            Some(question) if question.whom == whom => true,
            _ => self.has_room(now, whom),
        }
    }

    pub(super) fn ask(&mut self, now: MissionTime, whom: Participant, of: Origin) {
        let before = self.asked.get(&of).filter(|question| question.whom == whom);
        let tries = before.map_or(1, |question| question.tries.saturating_add(1));
        self.answered(of);
        self.asked.insert(of, Question { at: now, whom, tries });
        self.to.entry(whom).or_default().origins.insert(of);
    }

    /// Removes the request about an origin.
    pub(super) fn answered(&mut self, of: Origin) {
        if let Some(question) = self.asked.remove(&of)
            && let Some(asked) = self.to.get_mut(&question.whom)
        {
            asked.origins.remove(&of);
        }
    }

    /// Scans the requests to one participant once per time, however many requests follow.
    fn has_room(&mut self, now: MissionTime, whom: Participant) -> bool {
        let asked = self.to.entry(whom).or_default();
        if asked.origins.len() >= MOST_TO_ONE && asked.tidied != Some(now) {
            asked.tidied = Some(now);
            #[cfg(test)]
            {
                self.looked_through += asked.origins.len() as u64;
            }
            let is_waiting = |of: &Origin| self.asked.get(of).is_some_and(|it| now < it.at + self.patience);
            let (kept, given_up) = std::mem::take(&mut asked.origins).into_iter().partition(is_waiting);
            asked.origins = kept;
            let given_up: BTreeSet<Origin> = given_up;
            for of in given_up {
                self.asked.remove(&of);
            }
        }
        asked.origins.len() < MOST_TO_ONE
    }

    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.asked.len()
    }
}

impl Question {
    /// Whether this participant may now be asked, after an unsuccessful request.
    fn may_follow(&self, now: MissionTime, whom: Participant, patience: Duration) -> bool {
        // Others send a heartbeat within twice the patience.
        let waits = if self.whom == whom && self.tries >= MOST_TRIES { 3 } else { 1 };
        now >= self.at + patience * waits
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::observation::RobotId;

    use super::*;

    const PATIENCE: Duration = Duration::from_secs(1);

    fn robot(number: u16) -> Participant {
        Participant::Robot(RobotId::new(number).unwrap())
    }

    /// Asks one participant, if allowed, about a number of invented origins.
    fn ask(questions: &mut Questions, now: MissionTime, whom: u16, incarnations: std::ops::Range<u64>) {
        for incarnation in incarnations {
            let of = Origin { source: RobotId::new(9).unwrap().into(), incarnation };
            if questions.may_request(now, robot(whom), of) {
                questions.ask(now, robot(whom), of);
            }
        }
    }

    #[test]
    fn a_long_list_is_scanned_once() {
        let mut questions = Questions::new(PATIENCE);
        ask(&mut questions, MissionTime::START, 2, 0..10_000);
        assert_eq!(questions.looked_through, MOST_TO_ONE as u64);
        // All requests have expired.
        ask(&mut questions, MissionTime::START + PATIENCE, 2, 10_000..20_000);
        assert_eq!(questions.looked_through, 2 * MOST_TO_ONE as u64);
        assert_eq!(questions.len(), MOST_TO_ONE);
    }

    #[test]
    fn each_participant_has_its_own_queue() {
        let mut questions = Questions::new(PATIENCE);
        ask(&mut questions, MissionTime::START, 2, 0..1000);
        ask(&mut questions, MissionTime::START, 3, 1000..1010);
        assert_eq!(questions.len(), MOST_TO_ONE + 10);
        // An unsuccessful request is moved to another participant, and makes room.
        ask(&mut questions, MissionTime::START + PATIENCE, 3, 0..10);
        ask(&mut questions, MissionTime::START + PATIENCE.mul_f64(1.5), 2, 2000..2010);
        assert_eq!(questions.len(), MOST_TO_ONE + 20);
    }
}
