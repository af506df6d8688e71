//! Replays a recording of a vehicle's network through a robot, and reports what the robot would have observed, decided
//! and published.
//!
//! Nothing is sent or stored. The recorded vehicle does not follow the robot's decisions: its pilot gets no route,
//! makes an observation in each cell that it enters, and the robot decides again from there. All times are those of the
//! recording, so the same recording, settings and program give the same output, except for computing times.

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
use crate::config::{self, AgentSettings, OwnVehicle};
use crate::ros::incoming::Incoming;
use crate::ros::settings::Checked;
use crate::vehicle::detector::{Detector, Make};
use crate::vehicle::{Effect, Now, RefusedInput, SHOW, TICK, Vehicle};

/// The longest silence that is simulated step by step: timeouts have passed by then.
const SILENCE: Duration = Duration::from_mins(1);
/// A reading above this indicates an object, one below an empty cell.
const OBJECT: f32 = 0.5;

/// An action that the robot would have taken, with its time since the recording's first message.
#[derive(Clone, Debug, PartialEq)]
pub struct Note {
    /// Its time.
    pub time: MissionTime,
    /// The action.
    pub news: News,
}

/// An action that the robot would have taken.
#[derive(Clone, Debug, PartialEq)]
pub enum News {
    /// It observes from its cell.
    Observes {
        /// Its cell.
        from: Position,
        /// Number of cells that were read.
        readings: usize,
        /// Number of cells with a reading of an object.
        objects: Vec<Position>,
    },
    /// It decides on a path, or to stay.
    Decides {
        /// Number of cells to enter.
        cells: usize,
        /// The last of them.
        toward: Option<Position>,
        /// Computing time of the decision here.
        computing: Option<Duration>,
    },
    /// A cell's probability reaches the detection threshold.
    Finds(FoundObject),
    /// A cell's probability falls below the detection threshold again.
    Doubts(Position),
    /// A fault begins or ends.
    Tells(Diagnostic),
}

/// A declared object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundObject {
    /// Its cell.
    pub cell: Position,
    /// Its expected position, in the frame of the vehicle's network.
    pub place: PlanarEstimate,
}

/// The results of a dry run.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// From the first message to the last.
    pub duration: Duration,
    /// Topics of the settings, and their messages.
    pub received: Vec<Traffic>,
    /// Numbers of messages that would have been published, by topic.
    pub published: BTreeMap<String, u64>,
    /// Number of observations.
    pub observations: usize,
    /// Number of cells read in all of them.
    pub readings: usize,
    /// Computing time of each decision.
    pub decisions: Vec<Duration>,
    /// Entropy of the belief before and after, nats.
    pub entropy_nats: [f64; 2],
    /// Objects found at the end.
    pub found: Vec<FoundObject>,
    /// How the recording ends.
    pub ending: Ending,
}

/// The messages on a topic of the settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traffic {
    /// Its name.
    pub topic: String,
    /// The expected type.
    pub message: &'static str,
    /// Number of messages.
    pub messages: u64,
    /// Number of invalid messages.
    pub refused: u64,
    /// Why the last invalid message was rejected.
    pub reason: String,
}

/// Replays a recording through a robot with these settings. `tell` receives each note as it occurs. `make` constructs
/// the detector, if the settings have one.
///
/// # Errors
/// If the settings are invalid, have no vehicle, or the recording cannot be read.
pub fn run(
    file: &Path,
    recording: &Path,
    make: Make<'_>,
    tell: &mut dyn FnMut(Note),
) -> Result<Summary, RuntimeError> {
    let config: AgentSettings = config::load(file)?;
    let scenario = config.common.check(file)?.scenario;
    let agent_config = config.agent_config(file, &scenario)?;
    let Some(OwnVehicle::Ros(body)) = config.vehicle(file, &scenario)? else {
        let reason = "a dry run needs the vehicle whose network was recorded: [vehicle] and [ros]";
        return Err(RuntimeError::Settings { file: file.to_owned(), reason: reason.to_owned() });
    };
    let detector = body.make_detector(file, make)?;
    let mut bag = Bag::open(recording)?;
    let mut rehearsal = Rehearsal {
        topics: body.ros.subscriptions.iter().map(|one| one.topic.to_string()).zip(0..).collect(),
        traffic: body.ros.subscriptions.iter().map(Traffic::none).collect(),
        vehicle: Vehicle::new(body.pilot, &body.ros, &scenario),
        agent: Agent::new(agent_config),
        ros: body.ros,
        detector,
        terrain: scenario.terrain(),
        start_unix_ns: None,
        now: MissionTime::START,
        received_at: MissionTime::START,
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
        rehearsal.receive(&message?)?;
    }
    Ok(rehearsal.finish(before, bag.ending()))
}

/// The results so far.
#[derive(Default)]
struct Log {
    published: BTreeMap<OutputKind, u64>,
    observations: usize,
    readings: usize,
    decisions: Vec<Duration>,
    found: BTreeSet<Cell>,
}

/// A robot and its vehicle, driven by a recording's time.
struct Rehearsal<'a> {
    ros: Checked,
    /// Subscribed topics: indices of the subscriptions.
    topics: BTreeMap<String, usize>,
    /// By those indices.
    traffic: Vec<Traffic>,
    vehicle: Vehicle,
    agent: Agent,
    detector: Option<Box<dyn Detector>>,
    terrain: &'a Terrain,
    /// When the first message came.
    start_unix_ns: Option<u64>,
    now: MissionTime,
    /// When the last message came.
    received_at: MissionTime,
    tick_at: MissionTime,
    show_at: MissionTime,
    wake_at: MissionTime,
    /// Whether it has observed since its belief was last published.
    has_news: bool,
    log: Log,
    tell: &'a mut dyn FnMut(Note),
}

impl Rehearsal<'_> {
    fn receive(&mut self, message: &BagMessage) -> Result<(), RuntimeError> {
        let start = *self.start_unix_ns.get_or_insert(message.received_unix_ns);
        // The recording computer's clock may have been set back; a robot's own clock does not go back.
        self.pass(MissionTime(message.received_unix_ns.saturating_sub(start)).max(self.now))?;
        self.received_at = self.now;
        let Some(&number) = self.topics.get(&message.topic.name) else { return Ok(()) };
        self.traffic[number].messages += 1;
        let subscription = &self.ros.subscriptions[number];
        let received = match mismatch(&message.topic, subscription.kind.message().name) {
            Some(reason) => Incoming::Rejected { topic: subscription.topic.clone(), reason },
            None => self.ros.understand(subscription, &message.bytes),
        };
        let effects = self.vehicle.receive(self.clock(), &subscription.topic, received);
        self.act(effects)
    }

    /// Advances the time.
    fn pass(&mut self, until: MissionTime) -> Result<(), RuntimeError> {
        let end = until.min(self.received_at + SILENCE);
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
                let (belief, positions) = (self.agent.belief(), self.agent.replica().knowledge().positions());
                effects.extend(self.vehicle.show(self.clock(), belief, positions, has_changed));
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
                    self.observe(cell, &readings);
                    self.handle(Event::Sensed { cell, readings })?;
                    self.believe();
                }
                Effect::Report(event) => self.handle(event)?,
                Effect::Publish(output) => *self.log.published.entry(output.kind()).or_default() += 1,
                Effect::Detect(request) => {
                    if let Some(detector) = &mut self.detector {
                        let seen = request.through(&mut **detector);
                        effects.extend(self.vehicle.see(self.clock(), seen));
                    }
                }
                // There is no operator.
                Effect::Picture(_) => {}
                Effect::Tell(diagnostic) => self.note(News::Tells(diagnostic)),
            }
        }
        Ok(())
    }

    /// Passes an event to the agent.
    fn handle(&mut self, event: Event<Message>) -> Result<(), RuntimeError> {
        let effects = self.agent.handle(self.now, event)?;
        self.wake_at = effects.wake_at;
        self.log.decisions.extend(effects.decision);
        if let Some(route) = effects.route {
            let toward = route.last().map(|&cell| self.position(cell));
            self.note(News::Decides { cells: route.len(), toward, computing: effects.decision });
        }
        Ok(())
    }

    fn observe(&mut self, cell: Cell, readings: &[Reading]) {
        self.has_news = true;
        self.log.observations += 1;
        self.log.readings += readings.len();
        let objects = readings.iter().filter(|reading| reading.value > OBJECT);
        let objects = objects.map(|reading| self.position(reading.cell)).collect();
        self.note(News::Observes { from: self.position(cell), readings: readings.len(), objects });
    }

    /// Reports objects that are newly found, and those that no longer are.
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
        let positions = self.agent.replica().knowledge().positions();
        FoundObject { cell: self.position(cell), place: self.vehicle.place_of(cell, positions) }
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
        let published = self.log.published.iter().filter_map(|(kind, &count)| {
            self.ros.publications.get(kind).map(|topic| (topic.to_string(), count))
        });
        Summary {
            duration: self.now.since(MissionTime::START),
            published: published.collect(),
            observations: self.log.observations,
            readings: self.log.readings,
            entropy_nats: [entropy_before_nats, self.agent.belief().entropy_nats(self.terrain)],
            found: self.log.found.iter().map(|&cell| self.found(cell)).collect(),
            received: self.traffic,
            decisions: self.log.decisions,
            ending,
        }
    }
}

/// Why messages of a recorded topic cannot be used at all.
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
