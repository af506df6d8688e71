//! The liveliness tokens of a mission's participants, as one of them sees them.
//!
//! A process has one token, and two for a moment when its claim rises: the new one comes before the old one goes.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_proto::sender::Claim;
use dragnet_scenario::participant::Participant;

/// Maximum number of known tokens of one participant: more processes of it are not credible.
const MOST_TOKENS: usize = 16;

/// All tokens that are there.
#[derive(Debug, Default)]
pub(crate) struct Tokens {
    of: BTreeMap<Participant, BTreeSet<Claim>>,
}

/// What a change of tokens means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// This process of the participant has joined, or is from now on the one that goes on.
    Came(u64),
    /// Its last process has left, this one.
    Left(u64),
}

impl Tokens {
    /// A token has come: of a process that joins, or whose claim rises.
    pub(crate) fn come(&mut self, participant: Participant, claim: Claim) -> Option<Change> {
        let before = self.foremost(participant);
        let tokens = self.of.entry(participant).or_default();
        let is_known = tokens.iter().any(|token| token.identity == claim.identity);
        if !tokens.contains(&claim) && tokens.len() >= MOST_TOKENS {
            return None;
        }
        let rises = tokens.insert(claim) && is_known;
        let is_the_same = rises && self.foremost(participant) == before;
        (!is_the_same).then_some(Change::Came(claim.identity))
    }

    /// A token has gone. Its process may have another one; and if other processes of the participant remain, the
    /// foremost of them counts as joined, for those that knew this one.
    pub(crate) fn leave(&mut self, participant: Participant, claim: Claim) -> Option<Change> {
        let before = self.foremost(participant);
        let tokens = self.of.get_mut(&participant)?;
        if !tokens.remove(&claim) {
            return None;
        }
        let is_still_here = tokens.iter().any(|token| token.identity == claim.identity);
        if tokens.is_empty() {
            self.of.remove(&participant);
        }
        match self.foremost(participant) {
            None => Some(Change::Left(claim.identity)),
            Some(first) if is_still_here && Some(first) == before => None,
            Some(first) => Some(Change::Came(first)),
        }
    }

    /// The claims of a participant's processes.
    pub(crate) fn claims(&self, participant: Participant) -> impl Iterator<Item = Claim> {
        self.of.get(&participant).into_iter().flatten().copied()
    }

    /// The identity of the process of a participant that goes on.
    pub(crate) fn foremost(&self, participant: Participant) -> Option<u64> {
        self.claims(participant).max().map(|claim| claim.identity)
    }

    /// Participants with several processes, including the one with this claim.
    pub(crate) fn doubled(&self, own: Option<(Participant, Claim)>) -> BTreeSet<Participant> {
        let is_double = |participant: &Participant| {
            let own = own.filter(|(me, _)| me == participant).map(|(_, claim)| claim);
            let claims = self.claims(*participant).chain(own);
            claims.map(|claim| claim.identity).collect::<BTreeSet<u64>>().len() > 1
        };
        self.of.keys().copied().filter(is_double).collect()
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::observation::RobotId;

    use super::*;

    const ONE: Participant = Participant::Robot(RobotId::FIRST);

    const fn claim(seniority: u8, identity: u64) -> Claim {
        Claim { seniority, identity }
    }

    #[test]
    fn a_process_whose_claim_rises_neither_comes_nor_leaves() {
        let mut tokens = Tokens::default();
        assert_eq!(tokens.come(ONE, claim(0, 7)), Some(Change::Came(7)));
        assert_eq!(tokens.come(ONE, claim(1, 7)), None);
        assert_eq!(tokens.doubled(None), BTreeSet::new(), "two tokens, one process");
        assert_eq!(tokens.leave(ONE, claim(0, 7)), None);
        assert_eq!(tokens.leave(ONE, claim(0, 7)), None, "not there");
        assert_eq!(tokens.leave(ONE, claim(1, 7)), Some(Change::Left(7)));
        assert_eq!(tokens.leave(ONE, claim(1, 7)), None, "not there");
    }

    #[test]
    fn the_foremost_of_several_processes_is_named_whenever_it_changes() {
        let mut tokens = Tokens::default();
        tokens.come(ONE, claim(0, 3));
        assert_eq!(tokens.come(ONE, claim(0, 7)), Some(Change::Came(7)));
        assert_eq!(tokens.foremost(ONE), Some(7));
        assert_eq!(tokens.come(ONE, claim(1, 3)), Some(Change::Came(3)));
        assert_eq!((tokens.leave(ONE, claim(0, 3)), tokens.foremost(ONE)), (None, Some(3)));
        assert_eq!(tokens.leave(ONE, claim(1, 3)), Some(Change::Came(7)));
        assert_eq!(tokens.leave(ONE, claim(0, 7)), Some(Change::Left(7)));
    }

    #[test]
    fn two_processes_are_two_also_if_one_is_the_own() {
        let mut tokens = Tokens::default();
        tokens.come(ONE, claim(2, 3));
        assert_eq!(tokens.doubled(None), BTreeSet::new());
        assert_eq!(tokens.doubled(Some((Participant::Coordinator, claim(0, 7)))), BTreeSet::new());
        assert_eq!(tokens.doubled(Some((ONE, claim(0, 7)))), BTreeSet::from([ONE]));
        tokens.come(ONE, claim(0, 7));
        assert_eq!(tokens.doubled(None), BTreeSet::from([ONE]));
    }

    #[test]
    fn invented_processes_are_few() {
        let mut tokens = Tokens::default();
        let came = (0..1000).filter(|&identity| tokens.come(ONE, claim(0, identity)).is_some()).count();
        assert_eq!(came, MOST_TOKENS);
        assert_eq!(tokens.leave(ONE, claim(0, 999)), None);
    }
}
