//! A robot and the operator: it heeds instructions, passes them on, and keeps them over a restart.

use std::sync::Arc;

use dragnet_proto::directive::Directive;
use dragnet_proto::instructions::passed_on;
use dragnet_proto::message::{Activity, Audience, Heartbeat, Message, MissionStatus};
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::replica::Received;
use dragnet_proto::state_machine::Effects;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;

use super::Agent;

impl Agent {
    /// Restores instructions of the operator that a robot of this number had passed on before a restart, so that a paused
    /// robot stays paused and a no-go zone closed while no other participant is in reach. To be called before the robot's
    /// first cell is known, after [`Agent::recall`], at the time at which the robot goes on.
    pub fn recall_instructions(&mut self, now: MissionTime, message: &Message) {
        let received = match message {
            Message::Verdicts(_) | Message::Marks(_) => {
                self.replica.receive(now, Participant::Robot(self.config.id()), message)
            }
            _ => Received::default(),
        };
        // It has no cell yet: it decides nothing.
        self.heed(now, message, &received.judged, received.marked.is_some(), &mut Effects::default());
    }

    /// Follows the instructions in a message: cells with new verdicts, and whether marks are new, are as the replica says.
    pub(super) fn heed(
        &mut self,
        now: MissionTime,
        message: &Message,
        judged: &[Cell],
        is_marked: bool,
        effects: &mut Effects<Message>,
    ) {
        match message {
            Message::Heartbeat(Heartbeat { directive, .. })
            | Message::MissionStatus(MissionStatus { directive, .. }) => self.obey(now, directive, effects),
            Message::Orders(report) => {
                let before = self.order();
                if self.orders.merge(now, &report.orders) && self.order() != before {
                    self.decide(now, effects);
                }
            }
            Message::Zones(report) => self.keep_out(now, &report.zones, effects),
            _ => {}
        }
        if !judged.is_empty() {
            // What was detected there is settled.
            self.sightings.settle(judged);
            self.reconsider(now, effects);
        }
        if is_marked {
            self.reconsider(now, effects);
        }
    }

    /// Tells all others the instructions that it knows, but for the directive, which its heartbeat tells.
    pub(super) fn pass_on(&self, now: MissionTime, effects: &mut Effects<Message>) {
        let (from, knowledge) = (Participant::Robot(self.config.id()), self.replica.knowledge());
        let told = (knowledge.verdicts(), &self.orders);
        let messages = passed_on(from, now, told, (&self.zones, knowledge.marks()));
        effects.published.extend(messages.map(|message| (Audience::All, message)));
    }

    /// The operator has decided about finds or marked something: a plan, or an end of the search because of what was believed,
    /// is reconsidered.
    fn reconsider(&mut self, now: MissionTime, effects: &mut Effects<Message>) {
        self.is_overtaken = true;
        if self.has_nothing_to_do() {
            self.decide(now, effects);
        }
    }

    /// Whether anything new may give it something to do at once.
    pub(super) fn has_nothing_to_do(&self) -> bool {
        self.activity.is_rest() || self.activity == Activity::Waiting
    }

    /// Applies a new directive of the operator: pauses, resumes, returns, or adds cells to the search area.
    fn obey(&mut self, now: MissionTime, directive: &Directive, effects: &mut Effects<Message>) {
        let (order, known) = (self.order(), self.directive.added.len());
        if !self.directive.merge(now, directive) {
            return;
        }
        let terrain = Arc::make_mut(&mut self.config.terrain);
        self.replica.knowledge_mut().search_also(
            terrain,
            self.directive.added.iter().copied(),
            self.config.added_prior,
        );
        if self.directive.added.len() > known {
            self.survey();
        }
        // On its way home, or to where it is sent, it decides again in the next cell.
        self.is_overtaken |=
            matches!(self.activity, Activity::Returning | Activity::Sent | Activity::Leaving);
        if self.order() != order || self.has_nothing_to_do() {
            self.decide(now, effects);
        }
    }

    /// What it is to do: what the operator wants of it, or to return if it must and is not told to stay where it is.
    pub(super) fn order(&self) -> RobotOrder {
        match self.orders.current(self.config.id(), &self.directive) {
            RobotOrder::Search | RobotOrder::Go(_) if self.must_return => RobotOrder::Return,
            order => order,
        }
    }
}
