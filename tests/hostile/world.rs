//! One robot and one coordinator with its page, which receive messages of other robots over a faulty network.

mod speech;

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_live::view::{About, View};
use dragnet_proto::command::Command;
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::message::{Audience, Message, MessageKind};
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::state_machine::{Event, StateMachine};
use dragnet_proto::validation::{Limits, Rejection};
use dragnet_proto::verdict::Decision;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::mark::{Mark, Searched};
use dragnet_search::observation::RobotId;
use dragnet_search::seed::{Purpose, Stream, stream};
use rand::RngExt;
use rand::seq::IndexedRandom;

use crate::spoil_bytes::spoil;
use crate::{check, scenario};

/// The robot that receives all this.
const ROBOT: Participant = Participant::Robot(RobotId::FIRST);
/// Number of last messages that may be spliced into others.
const REMEMBERED: usize = 64;
/// One of this number of replies is remembered too: they carry all that is known, and to encode them all takes longer than
/// all else.
const REMEMBER_EVERY: u32 = 8;
/// In the world of this seed a robot restarts more often than is accepted.
const RESTLESS: u64 = 0;
/// The world of this seed is at the end of time: clocks go no further.
const LAST: u64 = 1;

/// A small map with blocked cells, and a search that goes on: readings are so vague that nothing is ever certain.
const SCENARIO: &str = "name = 'hostile'
map = { shape = 'ice_cream_cone', rows = 6, columns = 6, cell_meters = 5.0 }
sensor = { radius = 1, noise_variance = 500.0 }
objects.count = 1
robots.count = 3
mission = { budget_meters = 1e9, stop_when_expected_remaining = 0.0 }
";

/// A message in transit.
pub(crate) struct Said {
    pub(crate) from: Participant,
    pub(crate) kind: MessageKind,
    pub(crate) bytes: Vec<u8>,
}

/// Numbers of damaged messages by result.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally {
    /// Invalid bytes.
    pub(crate) undecoded: u64,
    /// Messages, by kind.
    pub(crate) decoded: BTreeMap<MessageKind, u64>,
    /// Of these, those with another author than their key's.
    pub(crate) misattributed: u64,
    /// Observations that counted, at the robot or at the coordinator.
    pub(crate) counted: u64,
    /// Observations that were rejected there, and why.
    pub(crate) rejected: BTreeMap<Rejection, u64>,
}

/// The effects of a message on its receivers.
#[derive(Default)]
struct Heard {
    counted: u64,
    rejected: Vec<Rejection>,
}

/// Everything in it depends on its seed alone.
pub(crate) struct World {
    scenario: Scenario,
    codec: Codec,
    limits: Limits,
    agent: Agent,
    node: CoordinatorNode,
    page: Arc<Mutex<View>>,
    now: MissionTime,
    /// Number of damaged messages so far.
    number: u64,
    /// The robot's cell, and the cells that it has yet to enter.
    cell: Cell,
    route: VecDeque<Cell>,
    /// The other robots.
    /// Each with its incarnation.
    mates: [(RobotId, u64); 2],
    /// Number of messages after which the first of them restarts.
    restart_every: u64,
    random: Stream,
    /// The last messages.
    said: VecDeque<Said>,
}

impl World {
    pub(crate) fn new(seed: u64) -> Self {
        let scenario = scenario(SCENARIO);
        let page = Arc::new(Mutex::new(View::new(Arc::new(About::of(&scenario, None)))));
        let shown = Arc::clone(&page);
        let listener = move |now, record: &_| shown.lock().unwrap().take(now, record);
        let node = CoordinatorNode::new(Mission::new(CoordinatorConfig::of(&scenario)), None);
        let cell = scenario.terrain().traversable_cells().next().unwrap();
        let mut world = Self {
            codec: Codec::new(scenario.terrain().grid()),
            limits: Limits::of(&scenario),
            agent: Agent::new(AgentConfig::of_team(&scenario, seed).remove(0)),
            node: node.with_listener(Some(Box::new(listener))),
            page,
            now: if seed == LAST { MissionTime(u64::MAX - 3_600_000_000_000) } else { MissionTime::START },
            number: 0,
            cell,
            route: VecDeque::new(),
            mates: [2, 3].map(|number| (RobotId::new(number).unwrap(), 0)),
            restart_every: if seed == RESTLESS { 60 } else { 2000 },
            random: stream(seed, Purpose::Soak, 0),
            said: VecDeque::new(),
            scenario,
        };
        for kind in MessageKind::ALL {
            let said = world.speak(kind);
            world.remember(said);
        }
        world
    }

    /// Time passes, a message is sent, and a damaged one arrives; sometimes the original arrives too.
    pub(crate) fn step(&mut self, tally: &mut Tally) {
        self.now = self.now + Duration::from_millis(self.random.random_range(0..1000));
        self.live();
        self.number += 1;
        let kind = *MessageKind::ALL.choose(&mut self.random).unwrap();
        let said = self.speak(kind);
        if self.random.random_ratio(1, 4) {
            self.arrive(&said, &mut Tally::default());
        }
        let spoiled = self.spoil(&said);
        self.remember(said);
        self.arrive(&spoiled, tally);
    }

    /// Number of waypoints that the robot has chosen.
    pub(crate) fn decisions(&self) -> u64 {
        self.agent.decisions()
    }

    /// All known observations are valid, all of them count, and nothing else does.
    pub(crate) fn check(&self) {
        let mission = self.node.mission();
        check(self.agent.replica(), self.agent.belief(), &self.scenario, &self.limits);
        check(mission.replica(), mission.belief(), &self.scenario, &self.limits);
        assert_eq!(self.page.lock().unwrap().belief().digest(), mission.belief().digest());
    }

    /// Events of the robot, the operator and the network.
    fn live(&mut self) {
        if self.now >= self.agent.wake_at().min(self.node.mission().wake_at()) {
            self.tell(ROBOT, Event::Woke);
            self.tell(Participant::Coordinator, Event::Woke);
        }
        if self.number.is_multiple_of(40) {
            self.cell = self.route.pop_front().unwrap_or(self.cell);
            let readings = self.readings(self.cell);
            self.tell(ROBOT, Event::Sensed { cell: self.cell, readings });
        }
        if self.number.is_multiple_of(300) {
            let command = self.command();
            self.tell(Participant::Coordinator, Event::Commanded(command));
        }
        if self.number.is_multiple_of(500) {
            let robot = RobotId::new(self.random.random_range(1..5)).unwrap();
            self.tell(ROBOT, Event::Lost(robot));
            self.tell(Participant::Coordinator, Event::Lost(robot));
            self.tell(ROBOT, Event::Came);
        }
        if self.number.is_multiple_of(self.restart_every) {
            self.mates[0].1 = self.now.0;
        }
    }

    fn command(&mut self) -> Command {
        let cell = self.any_cell();
        match self.random.random_range(0..9) {
            8 => Command::Robot(RobotId::FIRST, self.any_order()),
            7 => Command::Team(TeamOrder::Return),
            0 => Command::Team(TeamOrder::Pause),
            1 => Command::Team(TeamOrder::Search),
            2 => Command::Search(vec![cell]),
            3 | 4 => Command::Judge(*Decision::ALL.choose(&mut self.random).unwrap(), cell),
            _ if self.node.mission().marks().iter().len() >= 20 => Command::Unmark(self.now.0),
            _ => {
                let search = Searched { cells: [cell].into(), pod_thousandths: 500 };
                Command::Mark(Mark::Searched(search), String::new())
            }
        }
    }

    fn any_order(&mut self) -> RobotOrder {
        let go = RobotOrder::Go(self.any_cell());
        *[RobotOrder::Search, go, RobotOrder::Return, RobotOrder::Pause].choose(&mut self.random).unwrap()
    }

    fn spoil(&mut self, said: &Said) -> Said {
        let other = &self.said[self.random.random_range(0..self.said.len())];
        let strangers =
            [ROBOT, Participant::Coordinator, Participant::Robot(RobotId::new(9).unwrap()), other.from];
        let is_forged = self.random.random_ratio(1, 16);
        let from = if is_forged { *strangers.choose(&mut self.random).unwrap() } else { said.from };
        let (kind, bytes) = spoil(&mut self.random, said, other);
        Said { from, kind, bytes }
    }

    /// Bytes arrive under a key: decoded, attributed, and received by all others.
    fn arrive(&mut self, said: &Said, tally: &mut Tally) {
        let message = match self.codec.decode(said.kind, &said.bytes) {
            Ok(message) => message,
            Err(error) => {
                assert!(error.to_string().starts_with("dragnet_msgs/msg/"), "{error}");
                tally.undecoded += 1;
                return;
            }
        };
        *tally.decoded.entry(said.kind).or_default() += 1;
        if convert::check_sender(&message, said.from).is_err() {
            tally.misattributed += 1;
            return;
        }
        for whom in [ROBOT, Participant::Coordinator].into_iter().filter(|&whom| whom != said.from) {
            let received = self.tell(whom, Event::Received { from: said.from, message: message.clone() });
            tally.counted += received.counted;
            for why in received.rejected {
                *tally.rejected.entry(why).or_default() += 1;
            }
        }
    }

    /// Passes an event to one participant, and its replies to the other, until both are silent. Returns the effects on
    /// the first.
    fn tell(&mut self, whom: Participant, event: Event<Message>) -> Heard {
        let mut first = None;
        let mut waiting = VecDeque::from([(whom, event)]);
        while let Some((whom, event)) = waiting.pop_front() {
            let (machine, other): (&mut dyn StateMachine, _) = match whom {
                ROBOT => (&mut self.agent, Participant::Coordinator),
                _ => (&mut self.node, ROBOT),
            };
            let effects = machine.handle(self.now, event).unwrap();
            first.get_or_insert_with(|| Heard {
                counted: effects.kept.len() as u64,
                rejected: effects.rejected.iter().map(|rejected| rejected.why).collect(),
            });
            if let Some(route) = effects.route {
                self.route = route.into();
            }
            for (audience, message) in effects.published {
                if audience == Audience::All || audience == Audience::One(other) {
                    if self.random.random_ratio(1, REMEMBER_EVERY) {
                        let bytes = convert::encode(&message);
                        self.remember(Said { from: whom, kind: message.kind(), bytes });
                    }
                    waiting.push_back((other, Event::Received { from: whom, message }));
                }
            }
        }
        first.unwrap_or_default()
    }

    fn remember(&mut self, said: Said) {
        if self.said.len() == REMEMBERED {
            self.said.pop_front();
        }
        self.said.push_back(said);
    }

    fn any_cell(&mut self) -> Cell {
        let grid = self.scenario.terrain().grid();
        grid.cells().nth(self.random.random_range(0..grid.cell_count())).unwrap()
    }
}
