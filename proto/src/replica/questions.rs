//! Questions under way: who was asked for what, so that nobody is asked without end, and nobody's claims take the place
//! of others'.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::Origin;

/// Who was asked so often and brought nothing is not asked again before others had their chance to be: somebody may claim
/// to know more, and always be the first to claim it.
const MOST_TRIES: u32 = 3;
/// One participant is asked about no more origins at a time: whoever invents origins is not asked about all of them.
pub(super) const MOST_TO_ONE: usize = 256;

/// The questions of one participant.
#[derive(Clone, Debug)]
pub(super) struct Questions {
    /// How long an answer is waited for before the question is asked again.
    patience: Duration,
    /// The last question about each origin; one whose answer brought something is no longer kept.
    asked: BTreeMap<Origin, Question>,
    /// The same by who was asked.
    to: BTreeMap<Participant, Asked>,
    #[cfg(test)]
    looked_through: u64,
}

#[derive(Clone, Copy, Debug)]
struct Question {
    at: MissionTime,
    whom: Participant,
    /// How often this one was asked, one time after another, and brought nothing.
    tries: u32,
}

/// About what somebody was asked.
#[derive(Clone, Debug, Default)]
struct Asked {
    origins: BTreeSet<Origin>,
    /// When those that had waited long enough were last let go: at the same time there are no further ones.
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

    /// Whether it is time to ask somebody about an origin, and there is room for the question.
    pub(super) fn may_ask(&mut self, now: MissionTime, whom: Participant, of: Origin) -> bool {
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

    /// The question about an origin need not be kept any longer.
    pub(super) fn answered(&mut self, of: Origin) {
        if let Some(question) = self.asked.remove(&of)
            && let Some(asked) = self.to.get_mut(&question.whom)
        {
            asked.origins.remove(&of);
        }
    }

    /// Looks through the questions to one participant once at a time, however many there are to ask.
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
    /// Whether it is time to put the question to this one, after it was put in vain.
    fn may_follow(&self, now: MissionTime, whom: Participant, patience: Duration) -> bool {
        // Others are heard within a heartbeat, which is twice the patience.
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

    /// Asks one participant, if it may be asked, about so many invented origins.
    fn ask(questions: &mut Questions, now: MissionTime, whom: u16, incarnations: std::ops::Range<u64>) {
        for incarnation in incarnations {
            let of = Origin { source: RobotId::new(9).unwrap().into(), incarnation };
            if questions.may_ask(now, robot(whom), of) {
                questions.ask(now, robot(whom), of);
            }
        }
    }

    #[test]
    fn a_long_list_is_looked_through_once() {
        let mut questions = Questions::new(PATIENCE);
        ask(&mut questions, MissionTime::START, 2, 0..10_000);
        assert_eq!(questions.looked_through, MOST_TO_ONE as u64);
        // All of them have waited long enough.
        ask(&mut questions, MissionTime::START + PATIENCE, 2, 10_000..20_000);
        assert_eq!(questions.looked_through, 2 * MOST_TO_ONE as u64);
        assert_eq!(questions.len(), MOST_TO_ONE);
    }

    #[test]
    fn each_participant_has_its_own_room() {
        let mut questions = Questions::new(PATIENCE);
        ask(&mut questions, MissionTime::START, 2, 0..1000);
        ask(&mut questions, MissionTime::START, 3, 1000..1010);
        assert_eq!(questions.len(), MOST_TO_ONE + 10);
        // What one was asked in vain another is asked, and makes room.
        ask(&mut questions, MissionTime::START + PATIENCE, 3, 0..10);
        ask(&mut questions, MissionTime::START + PATIENCE.mul_f64(1.5), 2, 2000..2010);
        assert_eq!(questions.len(), MOST_TO_ONE + 20);
    }
}
