//! Messages of honest robots and of the coordinator; some robots are careless.

use std::sync::Arc;

use dragnet_proto::convert;
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::Marks;
use dragnet_proto::message::{
    Activity, Heartbeat, Intent, MarkReport, Message, MessageKind, OrderReport, SyncReply, SyncRequest,
    VerdictReport, ZoneReport,
};
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::Zone;
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, MAX_VALUE, Reading};
use dragnet_search::mark::{Clue, Mark};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, Origin, RobotId, Version, Versions};
use rand::RngExt;
use rand::seq::IndexedRandom;

use super::{Said, World};

/// Number of marks that a message has at most. The coordinator knows more: damaged messages add others.
const SAID_MARKS: usize = 6;

fn origin((robot, incarnation): (RobotId, u64)) -> Origin {
    Origin { source: robot.into(), incarnation }
}

impl World {
    pub(super) fn speak(&mut self, kind: MessageKind) -> Said {
        let mate = *self.mates.choose(&mut self.random).unwrap();
        let (robot, origin) = (Participant::Robot(mate.0), origin(mate));
        let (from, message) = match kind {
            MessageKind::Observation => (robot, Message::Observation(self.some_observation(origin))),
            MessageKind::Intent => (robot, Message::Intent(self.intent(mate))),
            MessageKind::Heartbeat => (robot, Message::Heartbeat(self.heartbeat(mate))),
            MessageKind::SyncRequest => (robot, Message::SyncRequest(self.request(robot))),
            MessageKind::SyncReply => (robot, Message::SyncReply(self.reply(origin))),
            MessageKind::MissionStatus => {
                let mut status = self.node.mission().status(self.now);
                status.versions = self.versions();
                (Participant::Coordinator, Message::MissionStatus(status))
            }
            MessageKind::Verdicts => (robot, Message::Verdicts(self.verdicts(robot))),
            MessageKind::Orders => (robot, Message::Orders(self.orders(robot))),
            MessageKind::Zones => (robot, Message::Zones(self.zones(robot))),
            MessageKind::Marks => (robot, Message::Marks(self.marks(robot))),
        };
        Said { from, kind, bytes: convert::encode(&message) }
    }

    /// Usually the next one; sometimes a known or an early one.
    fn some_observation(&mut self, of: Origin) -> Arc<Observation> {
        let next = self.agent.replica().log().next(of);
        let sequence = match self.random.random_range(0..8) {
            0 => next.saturating_sub(1),
            1 => next + self.random.random_range(1..4),
            _ => next,
        };
        self.observed(of, sequence)
    }

    /// An observation that the receiving robot knows, or the next one. Few are from impossible cells.
    fn observed(&mut self, origin: Origin, sequence: u64) -> Arc<Observation> {
        if let Some(known) = self.agent.replica().log().since(origin, sequence).first() {
            return Arc::clone(known);
        }
        let cells: Vec<Cell> = self.scenario.terrain().traversable_cells().collect();
        let is_far = self.random.random_ratio(1, 20);
        let from = if is_far {
            *cells.choose(&mut self.random).unwrap()
        } else {
            cells[usize::from(sequence % 2 == 1)]
        };
        let mut readings = self.readings(from);
        if self.random.random_ratio(1, 1000) {
            // However vague the sensor is. Damaged bytes seldom make such a value.
            readings[0].value = MAX_VALUE;
        }
        let positions = self.positions(from);
        Arc::new(Observation { origin, sequence, time_ns: self.now.0, from, readings, positions })
    }

    /// Sometimes that of an object, and seldom one that is nowhere near its cell.
    fn positions(&mut self, cell: Cell) -> Box<[ObjectPosition]> {
        let (east, north) = self.scenario.terrain().center_meters(cell);
        let off = if self.random.random_ratio(1, 50) { 1e5 } else { 0.1 };
        let position = ObjectPosition::new(cell, [east + off, north], [0.5, 0.1, 0.2]);
        position.filter(|_| self.random.random_ratio(1, 20)).into_iter().collect()
    }

    /// Of all cells in the footprint: empty with noise.
    pub(super) fn readings(&mut self, from: Cell) -> Vec<Reading> {
        let (grid, sensor) = (self.scenario.terrain().grid(), self.scenario.sensor());
        let in_sight = grid.cells().filter(|&cell| grid.manhattan(from, cell) <= sensor.radius());
        let reading = |cell| Reading {
            cell,
            value: self.random.random_range(-0.1..0.1),
            variance: sensor.variance(grid.manhattan(from, cell)),
        };
        in_sight.map(reading).collect()
    }

    fn intent(&mut self, (robot, incarnation): (RobotId, u64)) -> Intent {
        let path = (0..self.random.random_range(0..5)).map(|_| self.any_cell()).collect();
        Intent { robot, incarnation, decision: self.number, time_ns: self.now.0, path }
    }

    fn heartbeat(&mut self, mate: (RobotId, u64)) -> Heartbeat {
        Heartbeat {
            robot: mate.0,
            time_ns: self.now.0,
            activity: Activity::Searching,
            cell: self.any_cell(),
            path_meters: self.now.as_seconds(),
            intent: self.intent(mate),
            versions: self.versions(),
            digest: Digest(self.now.0.into()),
            directive: self.directive(),
        }
    }

    /// The coordinator's directive; sometimes another one has more orders.
    fn directive(&mut self) -> Directive {
        let mut directive = self.node.mission().directive().clone();
        if self.random.random_ratio(1, 20) {
            let orders = [TeamOrder::Search, TeamOrder::Return, TeamOrder::Pause];
            directive.give(self.now.0, *orders.choose(&mut self.random).unwrap());
            directive.added.insert(self.any_cell());
        }
        directive
    }

    /// The coordinator's verdicts; mostly another one has decided more.
    fn verdicts(&mut self, from: Participant) -> VerdictReport {
        let cell = self.any_cell();
        let decision = *Decision::ALL.choose(&mut self.random).unwrap();
        let node = self.node.mission();
        let verdicts = node.verdicts().with(self.now.0, cell, decision, node.belief());
        VerdictReport { from, time_ns: self.now.0, verdicts }
    }

    /// The coordinator's orders to single robots; mostly another one has given more.
    fn orders(&mut self, from: Participant) -> OrderReport {
        let (order, mate) = (self.any_order(), self.mates.choose(&mut self.random).unwrap().0);
        let mission = self.node.mission();
        let mut orders = mission.orders().clone();
        orders.order(self.now.0, mate, order, mission.directive());
        OrderReport { from, time_ns: self.now.0, orders }
    }

    /// The coordinator's marks; mostly another one has more, or has withdrawn one.
    fn marks(&mut self, from: Participant) -> MarkReport {
        let (cell, radius_hundredths) = (self.any_cell(), 0);
        let mut marks: Marks = self.node.mission().marks().iter().take(SAID_MARKS).collect();
        let last = marks.iter().last().map(|(id, _)| id);
        match last {
            Some(last) if self.random.random() => drop(marks.withdraw(self.now.0, last)),
            _ if marks.iter().len() == SAID_MARKS => {}
            _ => {
                let mark = Mark::Clue(Clue { cell, ratio_thousandths: 2_000, radius_hundredths });
                marks.make(self.now.0, mark, "a glove".to_owned());
            }
        }
        MarkReport { from, time_ns: self.now.0, marks }
    }

    /// The coordinator's zones; mostly another one has more.
    fn zones(&mut self, from: Participant) -> ZoneReport {
        let (cell, zone) = (self.any_cell(), *Zone::ALL.choose(&mut self.random).unwrap());
        let mut zones = self.node.mission().zones().clone();
        zones.give(self.now.0, cell, zone);
        ZoneReport { from, time_ns: self.now.0, zones }
    }

    /// Of a few origins, some of which are claimed to have more observations.
    fn versions(&mut self) -> Versions {
        let mut versions: Vec<Version> =
            self.agent.replica().log().versions().iter().take(6).copied().collect();
        for version in &mut versions {
            version.next += self.random.random_range(0..2);
        }
        versions.into()
    }

    fn request(&mut self, from: Participant) -> SyncRequest {
        let of = origin(*self.mates.choose(&mut self.random).unwrap());
        let next = self.agent.replica().log().next(of);
        SyncRequest { from, of, first: self.random.random_range(0..=next) }
    }

    /// The last observations of a robot and what follows; sometimes a full reply, or more than it can have.
    fn reply(&mut self, of: Origin) -> SyncReply {
        let next = self.agent.replica().log().next(of);
        let (known, new) = match self.random.random_range(0..30) {
            0 => (SyncReply::MAX_OBSERVATIONS as u64, 0),
            1..=3 => (0, 30),
            _ => (self.random.random_range(0..4), self.random.random_range(1..3)),
        };
        let sequences = next.saturating_sub(known)..next + new;
        SyncReply { observations: sequences.map(|sequence| self.observed(of, sequence)).collect() }
    }
}
