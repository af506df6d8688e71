//! Which of several processes of one robot goes on: a state machine of one of them.
//!
//! Each process claims its robot's number in its liveliness token ([`Claim`]): a seniority, and an identity drawn when
//! it starts, which decides among equals. A process stands still, and publishes nothing, while it sees a token with a
//! greater claim. Its seniority is 0 when it starts, 1 once it has made an observation or has gone on for [`LEVEL`]
//! seconds, and rises by 1 each time that it has gone on for [`LEVEL`] times as long; while it stands it does not rise.
//!
//! So once the tokens have arrived, however late and in whatever order, exactly one of the processes that see each
//! other goes on: claims are totally ordered, and only the greatest one still changes. Which one is no matter of
//! messages, which may be lost and which a process sends only in a running mission, and no matter of clocks: a process
//! that searches is not stopped by one that is started later, of two that were started together each can go on, and
//! where two have searched for long without a connection the one that has for about [`LEVEL`] times as long does.
//!
//! The token of a process that has died stays until the lease of its session ends; a process that is restarted waits
//! for that. A connection that breaks takes the tokens beyond it along: then both go on until it is back.

use std::time::Duration;

use dragnet_proto::sender::Claim;

/// The base of seniority: the first level in seconds, and the factor between levels.
const LEVEL: u64 = 4;

/// One of the processes of a number.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Contender {
    claim: Claim,
    stands: bool,
    has_observed: bool,
    /// For how long it has gone on, until `updated`.
    went: Duration,
    updated: Duration,
}

impl Contender {
    /// A process that starts.
    pub(crate) const fn new(claim: Claim) -> Self {
        Self { claim, stands: false, has_observed: false, went: Duration::ZERO, updated: Duration::ZERO }
    }

    /// Its claim, as its token is to carry it.
    pub(crate) const fn claim(&self) -> Claim {
        self.claim
    }

    /// Whether it stands still, because of another process of its number.
    pub(crate) const fn stands(&self) -> bool {
        self.stands
    }

    /// It has made an observation.
    pub(crate) const fn observe(&mut self) {
        self.has_observed = true;
    }

    /// The only function besides [`Contender::observe`] that changes it: `now` is since it started, and `rivals` are the
    /// claims of the other processes of its number whose tokens are there.
    pub(crate) fn update(&mut self, now: Duration, rivals: impl IntoIterator<Item = Claim>) {
        if !self.stands {
            self.went += now.saturating_sub(self.updated);
        }
        self.updated = now;
        // By the claim that the others see: only then does it rise.
        self.stands = rivals.into_iter().any(|rival| rival > self.claim);
        if !self.stands {
            self.claim.seniority = self.claim.seniority.max(self.level());
        }
    }

    /// When its claim rises, if no other process comes.
    pub(crate) fn due(&self) -> Option<Duration> {
        let next = LEVEL.checked_pow(u32::from(self.level()) + 1).map(Duration::from_secs);
        let is_to_rise = !self.stands && self.claim.seniority < Claim::TAKES_OVER;
        next.filter(|_| is_to_rise).map(|next| self.updated + next.saturating_sub(self.went))
    }

    fn level(&self) -> u8 {
        let by_time = self.went.as_secs().checked_ilog(LEVEL).map_or(0, |level| level.min(MOST_LEVELS));
        u8::try_from(by_time).unwrap_or(0).max(u8::from(self.has_observed))
    }
}

/// So long does nothing last: 4^16 s are 136 years.
const MOST_LEVELS: u32 = 16;

#[cfg(test)]
mod tests;
