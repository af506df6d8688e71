//! Delivery of messages: a message that reaches several participants at one time is one event, and is delivered to them
//! together where the order cannot matter.

use dragnet_proto::message::Audience;
use dragnet_proto::radio::{Radio, Sending};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;

use super::{Member, SimEvent, Simulation, StepContext};
use crate::participants::{Participants, Published};
use crate::traffic::Traffic;

impl<C: Participants, S: FnMut(MissionTime, StepContext)> Simulation<C, S> {
    /// Sends a message at once, or queues it at its sender's radio.
    pub(super) fn publish(
        &mut self,
        now: MissionTime,
        from: Participant,
        audience: Audience,
        message: C::MessageRef,
    ) {
        // Most searches of a comparison are of one robot, which nobody hears: encoding would be a third of their time.
        if self.members.len() == 1 {
            return;
        }
        if self.radios.is_empty() && !self.is_traffic_counted {
            return self.send(now, from, audience, &message);
        }
        let (load, place) = (message.load(&self.codec), self.place(from));
        if let Some(radio) = self.radios.get_mut(place) {
            radio.offer(audience, load, message);
            self.transmit(now, from);
        } else {
            self.traffic.count(load);
            self.send(now, from, audience, &message);
        }
    }

    /// Begins to send a participant's next message, if its radio is free.
    fn transmit(&mut self, now: MissionTime, from: Participant) {
        let place = self.place(from);
        if let Some(sending) = self.radios[place].next(now) {
            let Sending { audience, load, message, until } = sending;
            self.traffic.count(load);
            self.queue.plan(until, SimEvent::Sent { from, audience, message });
        }
    }

    /// A message is complete: it is on its way to its receivers, unless its sender has crashed meanwhile.
    pub(super) fn sent(
        &mut self,
        now: MissionTime,
        from: Participant,
        audience: Audience,
        message: &C::MessageRef,
    ) {
        if self.members[self.place(from)].is_up {
            self.send(now, from, audience, message);
        }
        self.transmit(now, from);
    }

    pub(super) fn traffic_so_far(&self) -> Traffic {
        let unsent = self.radios.iter().map(Radio::unsent).sum();
        Traffic { unsent, ..self.traffic.clone() }
    }

    fn send(&mut self, now: MissionTime, from: Participant, audience: Audience, message: &C::MessageRef) {
        let mut due = now;
        let mut together = Vec::new();
        for index in 0..self.members.len() {
            let to = self.members[index].participant;
            let is_meant = match audience {
                Audience::All => to != from,
                Audience::One(one) => to == one,
            };
            if !is_meant {
                continue;
            }
            for arrival in self.network.arrivals(now, from, to) {
                if arrival != due || together.last() == Some(&to) {
                    self.plan_delivery(due, from, std::mem::take(&mut together), message);
                }
                due = arrival;
                together.push(to);
            }
        }
        self.plan_delivery(due, from, together, message);
    }

    fn plan_delivery(
        &mut self,
        due: MissionTime,
        from: Participant,
        to: Vec<Participant>,
        message: &C::MessageRef,
    ) {
        if !to.is_empty() {
            self.queue.plan(due, SimEvent::Delivery { from, to, message: message.clone() });
        }
    }

    /// Delivers a message to as many participants together as cannot end the search, except for the last one; the others
    /// are due next.
    pub(super) fn deliver(
        &mut self,
        now: MissionTime,
        from: Participant,
        mut to: Vec<Participant>,
        message: C::MessageRef,
    ) -> Result<(), C::Error> {
        let later = to.split_off(self.count_together(&to));
        let mut receivers = Vec::with_capacity(to.len());
        for participant in to {
            if self.members[self.place(participant)].is_up {
                receivers.push((participant, now + self.faults.ahead(participant)));
            }
        }
        let reactions = self.participants.deliver(from, &message, &receivers)?;
        if !later.is_empty() {
            self.queue.put_back(now, SimEvent::Delivery { from, to: later, message });
        }
        for ((participant, _), reaction) in receivers.into_iter().zip(reactions) {
            match reaction.effects {
                Some(effects) => self.react(now, participant, *effects),
                None => self.attend(now, participant, reaction.wake_at, reaction.activity),
            }
        }
        Ok(())
    }

    /// Number of receivers before the last robot that searches: it keeps the search going, whatever the others do.
    fn count_together(&self, to: &[Participant]) -> usize {
        if self.is_over() {
            return 1;
        }
        let is_busy = |member: &&Member| !member.is_resting();
        let Some(searcher) = self.members.iter().rev().find(is_busy) else { return to.len() };
        to.iter()
            .position(|&participant| participant == searcher.participant)
            .map_or(to.len(), |place| place.max(1))
    }
}
