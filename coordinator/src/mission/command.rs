//! The operator's commands: marks become observations, the others change the directive.

use std::sync::Arc;

use dragnet_proto::command::{Command, Mark};
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Audience, Message};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Observation, Origin, Source};

use super::{Mission, Outcome};

impl Mission {
    /// The operator's directive so far.
    #[must_use]
    pub const fn directive(&self) -> &Directive {
        &self.directive
    }

    pub(super) fn command(&mut self, now: MissionTime, command: Command, outcome: &mut Outcome) {
        let mut directive = self.directive.clone();
        match command {
            Command::Mark(mark, cell) => return self.mark(now, mark, cell, outcome),
            Command::Pause if directive.is_paused => {}
            Command::Pause => directive.order_pause(now.0, true),
            Command::Resume if !directive.is_paused => {}
            Command::Resume => directive.order_pause(now.0, false),
            Command::Search(cells) => {
                let terrain = &self.config.terrain;
                directive.added.extend(cells.into_iter().filter(|&cell| !terrain.is_searched(cell)));
            }
        }
        self.learn(now, &directive, outcome);
    }

    /// Merges a directive, from here or from a robot; if it is news, it is published to all.
    pub(super) fn learn(&mut self, now: MissionTime, directive: &Directive, outcome: &mut Outcome) {
        if !self.directive.merge(now, directive) {
            return;
        }
        let terrain = Arc::make_mut(&mut self.config.terrain);
        let added = self.directive.added.iter().copied();
        let new = self.replica.knowledge_mut().search_also(terrain, added, self.added_prior);
        self.declarations.review(now, self.replica.knowledge().belief(), new);
        self.report(now, outcome);
    }

    /// One reading of one cell, under a unique name: it is stored, published and repaired like observations of robots.
    fn mark(&mut self, now: MissionTime, mark: Mark, cell: Cell, outcome: &mut Outcome) {
        let origin = *self.by_hand.get_or_insert_with(|| unused(&self.replica, now));
        let observation = Arc::new(Observation {
            origin,
            sequence: self.replica.log().next(origin),
            time_ns: now.0,
            from: cell,
            readings: vec![mark.reading(cell)],
        });
        if let Err(rejected) = self.replica.record(&observation) {
            return outcome.effects.rejected.push(rejected);
        }
        let has_declared = self.merge(now, &[Arc::clone(&observation)], outcome);
        outcome.effects.published.push((Audience::All, Message::Observation(observation)));
        if has_declared {
            self.report(now, outcome);
        }
    }
}

/// A restarted coordinator does not know which names it has used; the time of its first mark, in nanoseconds, is
/// unused.
fn unused(replica: &dragnet_proto::replica::Replica, now: MissionTime) -> Origin {
    let known: Vec<Origin> = replica.log().versions().iter().map(|version| version.origin).collect();
    let mut origin = Origin { source: Source::Operator, incarnation: now.0 };
    while known.contains(&origin) {
        // Its clock may be at the end of time, if it was set by a faulty participant.
        origin.incarnation = origin.incarnation.wrapping_add(1);
    }
    origin
}
