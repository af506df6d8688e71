//! A robot that lives through a recording of its vehicle's network: what it would have believed, decided and said.
//!
//! Nothing is sent, and nothing is written down. The vehicle drove where it drove and does not follow: its pilot is given no
//! route, so that it takes a look in each cell that it enters, and the robot decides anew from there. All of it hangs on the recording's own clock, so that the same recording, settings and
//! program give the same, but for the times that computing took.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;
use std::time::Duration;

use dragnet_agent::agent::Agent;
use dragnet_coordinator::Ending;
use dragnet_coordinator::bag::{Bag, BagMessage, BagTopic};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Event, StateMachine};
use dragnet_ros2::output::{Diagnostic, OutputKind, PlanarEstimate};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::evidence::Reading;
use dragnet_search::terrain::Terrain;

use crate::RuntimeError;
use crate::config::{self, AgentSettings};
use crate::ros::incoming::Incoming;
use crate::ros::settings::Checked;
use crate::vehicle::detector::{Detector, Make};
use crate::vehicle::{Effect, Now, RefusedInput, SHOW, TICK, Vehicle};

/// In a longer pause of a recording time passes at once: who was silent is known to be by then.
const SILENCE: Duration = Duration::from_mins(1);
/// A reading of more than this says that an object is there, one of less that none is: halfway.
const OBJECT: f32 = 0.5;

/// Something that the robot would have done, and when, since the recording's first message.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// When.
    pub time: MissionTime,
    /// What.
    pub news: News,
}

/// Something that the robot would have done.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// It takes a look of the cell where it stands.
    Looks {
        /// Where it stands.
        from: Position,
        /// Cells that were read.
        readings: usize,
        /// Those of them in which an object was read.
        objects: Vec<Position>,
    },
    /// It sets out, or stays where it is.
    Decides {
        /// Cells to enter.
        cells: usize,
        /// The last of them.
        toward: Option<Position>,
        /// How long the decision took here.
        computing: Option<Duration>,
    },
    /// It believes an object here, as sure as the mission asks.
    Finds(FoundObject),
    /// It does not any more.
    Doubts(Position),
    /// Something goes wrong, or is well again.
    Tells(Diagnostic),
}

/// A declared object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundObject {
    /// Its cell.
    pub cell: Position,
    /// Where it is expected by now, in the frame of the vehicle's network.
    pub place: PlanarEstimate,
}

/// How it went.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// From the first message to the last.
    pub duration: Duration,
    /// Topics of the settings, and what came of them.
    pub heard: Vec<Traffic>,
    /// What would have been said, by topic.
    pub said: BTreeMap<String, u64>,
    /// Looks that were taken.
    pub looks: usize,
    /// Cells that were read in all of them.
    pub readings: usize,
    /// Computing time of each decision.
    pub decisions: Vec<Duration>,
    /// Entropy of the belief before and after, nats.
    pub entropy_nats: [f64; 2],
    /// Where objects are believed at the end.
    pub found: Vec<FoundObject>,
    /// How the recording ends.
    pub ending: Ending,
}

/// What came on a topic of the settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traffic {
    /// Its name.
    pub topic: String,
    /// The type that is heard.
    pub message: &'static str,
    /// Messages.
    pub messages: u64,
    /// Those of them that could not be used, for whatever reason.
    pub refused: u64,
    /// Why the last of these could not.
    pub reason: String,
}

/// Has the robot of a file of settings live through a recording; each note is told as it comes up. `make` makes its
/// detector, if its settings ask for one.
///
/// # Errors
/// If the settings are not allowed, name no vehicle, or the recording cannot be read.
pub fn run(
    file: &Path,
    recording: &Path,
    make: Make<'_>,
    tell: &mut dyn FnMut(Note),
) -> Result<Summary, RuntimeError> {
    let config: AgentSettings = config::load(file)?;
    let scenario = config.common.check(file)?.scenario;
    let orders = config.orders(file, &scenario)?;
    let Some(body) = config.body(file, &scenario)? else {
        let reason = "a dry run needs the vehicle whose network was recorded: [vehicle] and [ros]";
        return Err(RuntimeError::Settings { file: file.to_owned(), reason: reason.to_owned() });
    };
    let detector = body.make_detector(file, make)?;
    let mut bag = Bag::open(recording)?;
    let mut rehearsal = Rehearsal {
        topics: body.ros.subscriptions.iter().map(|one| one.topic.to_string()).zip(0..).collect(),
        traffic: body.ros.subscriptions.iter().map(Traffic::none).collect(),
        vehicle: Vehicle::new(body.pilot, &body.ros, &scenario),
        agent: Agent::new(orders),
        ros: body.ros,
        detector,
        terrain: scenario.terrain(),
        start_unix_ns: None,
        now: MissionTime::START,
        heard_at: MissionTime::START,
        tick_at: MissionTime::START,
        show_at: MissionTime::START,
        wake_at: MissionTime(u64::MAX),
        has_news: true,
        log: Log::default(),
        tell,
    };
    let before = rehearsal.agent.belief().entropy_nats(scenario.terrain());
    rehearsal.handle(Event::Start)?;
    for message in &mut bag {
        rehearsal.hear(&message?)?;
    }
    Ok(rehearsal.finish(before, bag.ending()))
}

/// What has come of it so far.
#[derive(Default)]
struct Log {
    said: BTreeMap<OutputKind, u64>,
    looks: usize,
    readings: usize,
    decisions: Vec<Duration>,
    found: BTreeSet<Cell>,
}

/// A robot and its vehicle in a time of their own.
struct Rehearsal<'a> {
    ros: Checked,
    /// Topics that are heard: numbers among the subscriptions.
    topics: BTreeMap<String, usize>,
    /// By those numbers.
    traffic: Vec<Traffic>,
    vehicle: Vehicle,
    agent: Agent,
    detector: Option<Box<dyn Detector>>,
    terrain: &'a Terrain,
    /// When the first message came.
    start_unix_ns: Option<u64>,
    now: MissionTime,
    /// When the last message came.
    heard_at: MissionTime,
    tick_at: MissionTime,
    show_at: MissionTime,
    wake_at: MissionTime,
    /// Whether it has looked since its belief was last shown.
    has_news: bool,
    log: Log,
    tell: &'a mut dyn FnMut(Note),
}

impl Rehearsal<'_> {
    fn hear(&mut self, message: &BagMessage) -> Result<(), RuntimeError> {
        let start = *self.start_unix_ns.get_or_insert(message.heard_unix_ns);
        // Who recorded may have set its clock back meanwhile; a robot's own clock runs on.
        self.pass(MissionTime(message.heard_unix_ns.saturating_sub(start)).max(self.now))?;
        self.heard_at = self.now;
        let Some(&number) = self.topics.get(&message.topic.name) else { return Ok(()) };
        self.traffic[number].messages += 1;
        let subscription = &self.ros.subscriptions[number];
        let heard = match mismatch(&message.topic, subscription.kind.message().name) {
            Some(reason) => Incoming::Rejected { topic: subscription.topic.clone(), reason },
            None => self.ros.understand(subscription, &message.bytes),
        };
        let effects = self.vehicle.hear(self.clock(), &subscription.topic, heard);
        self.act(effects)
    }

    /// Lets time pass.
    fn pass(&mut self, until: MissionTime) -> Result<(), RuntimeError> {
        let end = until.min(self.heard_at + SILENCE);
        loop {
            let next = self.tick_at.min(self.wake_at.max(self.now));
            if next >= end {
                break;
            }
            self.now = next;
            if next < self.tick_at {
                self.handle(Event::Woke)?;
                continue;
            }
            self.tick_at = next + TICK;
            let mut effects = self.vehicle.tick(self.clock());
            if next >= self.show_at {
                self.show_at = next + SHOW;
                let has_changed = std::mem::take(&mut self.has_news);
                effects.extend(self.vehicle.show(self.clock(), self.agent.belief(), has_changed));
            }
            self.act(effects)?;
        }
        self.now = until;
        self.tick_at = self.tick_at.max(until);
        Ok(())
    }

    fn clock(&self) -> Now {
        let start_unix_ns = i64::try_from(self.start_unix_ns.unwrap_or(0)).unwrap_or(i64::MAX);
        Now { mission: self.now, unix_ns: start_unix_ns.saturating_add_unsigned(self.now.0) }
    }

    fn act(&mut self, effects: Vec<Effect>) -> Result<(), RuntimeError> {
        let mut effects = VecDeque::from(effects);
        while let Some(effect) = effects.pop_front() {
            match effect {
                Effect::Sensed { cell, readings } => {
                    self.look(cell, &readings);
                    self.handle(Event::Sensed { cell, readings })?;
                    self.believe();
                }
                Effect::Publish(output) => *self.log.said.entry(output.kind()).or_default() += 1,
                Effect::Look(look) => {
                    if let Some(detector) = &mut self.detector {
                        let seen = look.through(&mut **detector);
                        effects.extend(self.vehicle.see(self.clock(), seen));
                    }
                }
                Effect::Tell(diagnostic) => self.note(News::Tells(diagnostic)),
            }
        }
        Ok(())
    }

    /// Tells the robot's mind.
    fn handle(&mut self, event: Event<Message>) -> Result<(), RuntimeError> {
        let effects = self.agent.handle(self.now, event);
        let effects =
            effects.map_err(|error| RuntimeError::Participant { who: error.who, reason: error.reason })?;
        self.wake_at = effects.wake_at;
        self.log.decisions.extend(effects.decision);
        if let Some(route) = effects.route {
            let toward = route.last().map(|&cell| self.position(cell));
            self.note(News::Decides { cells: route.len(), toward, computing: effects.decision });
        }
        Ok(())
    }

    fn look(&mut self, cell: Cell, readings: &[Reading]) {
        self.has_news = true;
        self.log.looks += 1;
        self.log.readings += readings.len();
        let objects = readings.iter().filter(|reading| reading.value > OBJECT);
        let objects = objects.map(|reading| self.position(reading.cell)).collect();
        self.note(News::Looks { from: self.position(cell), readings: readings.len(), objects });
    }

    /// Tells of objects that are believed in, and of those that are not any more.
    fn believe(&mut self) {
        let found: BTreeSet<Cell> = self.vehicle.found(self.agent.belief()).collect();
        let before = std::mem::replace(&mut self.log.found, found.clone());
        for &cell in found.difference(&before) {
            self.note(News::Finds(self.found(cell)));
        }
        for &cell in before.difference(&found) {
            self.note(News::Doubts(self.position(cell)));
        }
    }

    fn found(&self, cell: Cell) -> FoundObject {
        FoundObject { cell: self.position(cell), place: self.vehicle.place_of(cell) }
    }

    fn position(&self, cell: Cell) -> Position {
        self.terrain.grid().position(cell)
    }

    fn note(&mut self, news: News) {
        (self.tell)(Note { time: self.now, news });
    }

    fn finish(mut self, entropy_before_nats: f64, ending: Ending) -> Summary {
        let refused = self.vehicle.refused();
        for (subscription, traffic) in self.ros.subscriptions.iter().zip(&mut self.traffic) {
            if let Some(RefusedInput { count, reason }) = refused.get(&subscription.topic) {
                (traffic.refused, traffic.reason) = (*count, reason.clone());
            }
        }
        let said = self.log.said.iter().filter_map(|(kind, &count)| {
            self.ros.publications.get(kind).map(|topic| (topic.to_string(), count))
        });
        Summary {
            duration: self.now.since(MissionTime::START),
            said: said.collect(),
            looks: self.log.looks,
            readings: self.log.readings,
            entropy_nats: [entropy_before_nats, self.agent.belief().entropy_nats(self.terrain)],
            found: self.log.found.iter().map(|&cell| self.found(cell)).collect(),
            heard: self.traffic,
            decisions: self.log.decisions,
            ending,
        }
    }
}

/// Why messages of a recorded topic cannot be heard at all.
fn mismatch(topic: &BagTopic, expected: &str) -> Option<String> {
    let BagTopic { message, encoding, .. } = topic;
    let is_expected = message == expected && encoding == "cdr";
    (!is_expected).then(|| format!("recorded is {message} as {encoding}; allowed is {expected} as cdr"))
}

impl Traffic {
    fn none(subscription: &crate::ros::settings::Subscription) -> Self {
        let (topic, message) = (subscription.topic.to_string(), subscription.kind.message().name);
        Self { topic, message, messages: 0, refused: 0, reason: String::new() }
    }
}
