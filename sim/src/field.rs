//! The field test: vehicles in continuous space that find objects with cameras.
//!
//! Everything between a camera's boxes and a vehicle's path is production code: boxes go to the [`Pilot`] of a robot,
//! its observations to the [`Agent`], the agent's routes back to the pilot, and its paths to the simulated vehicle. The
//! ground (`site`), the vehicle's body (`body`), its cameras and detector with misses and false alarms, and its
//! localization (`cameras`) are simulated.
//!
//! Time advances in ticks of [`TICK`]: in each, bodies move, poses and images are taken, and the resulting messages
//! reach teammates within the tick. A trial ends when the belief from all readings together has found every object
//! ([`Score`]), or with the mission's time. A decision takes the mission time that the caller passes
//! ([`DecisionTime`]), never its computing time: so a trial is a function of scenario, seed and that time, byte for
//! byte.

mod body;
mod cameras;
mod site;

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::{Audience, Message};
use dragnet_proto::state_machine::{Effects, Event, ParticipantError};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::measures::Score;
use dragnet_search::object_position::ObjectPositions;
use dragnet_search::observation::RobotId;
use dragnet_vehicle::pilot::diagnostic::{Diagnostic, Level};
use dragnet_vehicle::pilot::{self, Action, Pilot, PilotError};
use dragnet_vehicle::settings::SettingsError;

use crate::participants::{LocalParticipants, Participants};
use crate::world;
use body::Body;
use cameras::SimulatedCameras;
use site::Site;

pub use cameras::{HEAD_RADIANS_PER_SECOND, detection_probability};
pub use site::settings;

/// Time between two images of a camera.
pub const TICK: Duration = Duration::from_millis(200);

/// The mission time that a decision takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DecisionTime {
    /// The duration of each decision. Meanwhile the vehicle continues to the middle of the waypoint's cell, which it
    /// has just entered, and stops there.
    pub time: Duration,
}

impl DecisionTime {
    /// Decisions take no time: a millisecond is negligible in a search of minutes.
    pub const NONE: Self = Self { time: Duration::ZERO };
}

/// The result of a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// When every object was found; `None` if not all were found before the end.
    pub found: Option<MissionTime>,
    /// When the trial ended.
    pub ended: MissionTime,
    /// The belief from all readings together compared with the truth, at the end.
    pub score: Score,
    /// Distance driven by each robot, meters.
    pub driven_meters: Vec<f64>,
    /// Computing time of each decision, as measured; it does not affect the trial.
    pub decisions: Vec<Duration>,
    /// Number of observations of all robots.
    pub observations: u64,
    /// Number of observations that an agent rejected.
    pub rejected: u64,
    /// Diagnostics of the pilots above [`Level::Ok`], in order.
    pub diagnostics: Vec<(RobotId, Diagnostic)>,
    /// Digest of the evidence of all readings.
    pub digest: Digest,
    /// Positions of declared objects, by all observations.
    pub positions: ObjectPositions,
    /// The first robot's position at each tick, meters east and north.
    pub trace: Vec<(f64, f64)>,
}

/// Why a trial cannot run.
#[derive(Debug, thiserror::Error)]
pub enum FieldError {
    /// An agent failed.
    #[error(transparent)]
    StateMachine(#[from] ParticipantError),
    /// The vehicle's settings are invalid.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The pilot cannot be constructed.
    #[error(transparent)]
    Pilot(#[from] PilotError),
    /// The site is invalid.
    #[error(transparent)]
    Site(#[from] site::SiteError),
}

/// Runs a scenario with vehicles instead of grid robots.
///
/// # Errors
/// If the scenario does not state a number of objects, or is too large for a lattice.
pub fn run(scenario: &Scenario, seed: u64, thinking: DecisionTime) -> Result<Trial, FieldError> {
    let config = AgentConfig::of_team(scenario, seed);
    let mut agents: Vec<Agent> = config.into_iter().map(Agent::new).collect();
    let mut mission = Mission::new(scenario, seed, thinking, LocalParticipants::new(&mut agents, None))?;
    mission.run(scenario.mission().budget.time().unwrap_or(LONGEST))?;
    Ok(mission.end())
}

/// The end of a trial without a time budget.
const LONGEST: Duration = Duration::from_hours(1);

/// A vehicle with its pilot.
struct Vehicle {
    id: RobotId,
    body: Body,
    eyes: SimulatedCameras,
    pilot: Pilot,
    /// A route that its agent is still computing.
    pending: Option<(MissionTime, Vec<Cell>)>,
    wake_at: MissionTime,
}

/// A trial in progress.
struct Mission<'a> {
    site: Arc<Site>,
    thinking: DecisionTime,
    participants: LocalParticipants<'a>,
    vehicles: Vec<Vehicle>,
    merged: Belief,
    detection_threshold: f64,
    /// Cells that `merged` declares.
    declared: BTreeSet<Cell>,
    /// Whether they have changed since the pilots were told.
    has_news: bool,
    now: MissionTime,
    trial: Trial,
    /// Messages in transit, with their receivers.
    mail: VecDeque<(Participant, usize, Message)>,
}

impl<'a> Mission<'a> {
    fn new(
        scenario: &Scenario,
        seed: u64,
        thinking: DecisionTime,
        participants: LocalParticipants<'a>,
    ) -> Result<Self, FieldError> {
        let site = Arc::new(Site::new(scenario, seed)?);
        let mut vehicles = Vec::new();
        for (robot, start) in scenario.robots().iter().zip(site.starts()) {
            let full_speed = robot.class.speed_meters_per_second;
            let checked = settings(full_speed).check(None)?;
            let (terrain, sensor) = (scenario.terrain().clone(), (*robot.class.sensor).clone());
            vehicles.push(Vehicle {
                id: robot.id,
                body: Body::new(*start, full_speed),
                eyes: SimulatedCameras::new(&checked, seed, robot.id),
                pilot: Pilot::new(checked.clone(), terrain, sensor, site.ground())?,
                pending: None,
                wake_at: MissionTime(u64::MAX),
            });
        }
        let (merged, detection_threshold) =
            (scenario.prior().clone(), scenario.mission().detection_threshold);
        let reach = world::draw_reach(scenario, seed);
        let trial = Trial {
            found: None,
            ended: MissionTime::START,
            score: Score::of(scenario.terrain(), &reach, &merged, site.truth(), detection_threshold),
            driven_meters: Vec::new(),
            decisions: Vec::new(),
            observations: 0,
            rejected: 0,
            diagnostics: Vec::new(),
            digest: merged.digest(),
            positions: ObjectPositions::default(),
            trace: Vec::new(),
        };
        let now = MissionTime::START;
        Ok(Self {
            site,
            thinking,
            participants,
            vehicles,
            merged,
            detection_threshold,
            declared: BTreeSet::new(),
            has_news: false,
            now,
            trial,
            mail: VecDeque::new(),
        })
    }

    fn run(&mut self, budget: Duration) -> Result<(), ParticipantError> {
        for index in 0..self.vehicles.len() {
            self.tell(index, Event::Start)?;
        }
        while self.trial.found.is_none() && self.now.since(MissionTime::START) < budget {
            self.now = self.now + TICK;
            for index in 0..self.vehicles.len() {
                self.wake(index)?;
                self.move_on(index)?;
            }
            self.deliver()?;
            if std::mem::take(&mut self.has_news) {
                for index in 0..self.vehicles.len() {
                    self.steer(index, pilot::Event::Declared(self.declared.clone()))?;
                }
            }
        }
        Ok(())
    }

    fn wake(&mut self, index: usize) -> Result<(), ParticipantError> {
        if self.vehicles[index].wake_at <= self.now {
            self.tell(index, Event::Woke)?;
        }
        let now = self.now;
        if let Some((_, cells)) = self.vehicles[index].pending.take_if(|(due, _)| *due <= now) {
            self.steer(index, pilot::Event::Route(cells))?;
        }
        Ok(())
    }

    /// A tick of one vehicle: its body moves, then it receives its pose and its cameras' detections.
    fn move_on(&mut self, index: usize) -> Result<(), ParticipantError> {
        let vehicle = &mut self.vehicles[index];
        vehicle.body.move_on(TICK.as_secs_f64());
        let pose = vehicle.body.pose();
        if index == 0 {
            self.trial.trace.push((pose.x_meters, pose.y_meters));
        }
        let fix = vehicle.eyes.fix(self.now, &pose);
        let frames = vehicle.eyes.observe(self.now, &pose, self.site.objects_meters());
        self.steer(index, pilot::Event::Pose(fix))?;
        for frame in frames {
            self.steer(index, pilot::Event::Frame(frame))?;
        }
        Ok(())
    }

    /// Passes an event to a pilot, and carries out its effects.
    fn steer(&mut self, index: usize, event: pilot::Event) -> Result<(), ParticipantError> {
        let vehicle = &mut self.vehicles[index];
        for action in vehicle.pilot.handle(self.now.0, event) {
            let vehicle = &mut self.vehicles[index];
            match action {
                Action::Sensed { cell, readings } => self.sense(index, cell, readings)?,
                Action::RouteFailed { blocked } => self.tell(index, Event::RouteFailed { blocked })?,
                Action::Doubted { cells } => self.tell(index, Event::Doubted { cells })?,
                Action::LineOfSight(seen) => self.tell(index, Event::LineOfSight(seen))?,
                Action::Located(positions) => self.tell(index, Event::Located(positions))?,
                Action::Drive(plan) => vehicle.body.follow(&plan.poses),
                Action::Go(pose) => {
                    let here = vehicle.body.pose();
                    vehicle.body.follow(&[here, pose]);
                }
                Action::Hold => vehicle.body.follow(&[]),
                Action::Tell(diagnostic) if diagnostic.level > Level::Ok => {
                    self.trial.diagnostics.push((vehicle.id, diagnostic));
                }
                Action::Tell(_) | Action::Refuse(..) => {}
            }
        }
        Ok(())
    }

    fn sense(&mut self, index: usize, cell: Cell, readings: Vec<Reading>) -> Result<(), ParticipantError> {
        self.trial.observations += 1;
        for reading in &readings {
            let before = self.merged.is_found(reading.cell, self.detection_threshold);
            self.merged.add(reading);
            let after = self.merged.is_found(reading.cell, self.detection_threshold);
            if before != after {
                self.has_news = true;
                if after {
                    self.declared.insert(reading.cell);
                } else {
                    self.declared.remove(&reading.cell);
                }
                self.trial.score.change(after, self.site.truth().is_object(reading.cell));
            }
        }
        if self.trial.score.false_negatives == 0 {
            self.trial.found.get_or_insert(self.now);
        }
        self.tell(index, Event::Sensed { cell, readings })
    }

    /// Passes an event to an agent, and carries out its effects.
    fn tell(&mut self, index: usize, event: Event<Message>) -> Result<(), ParticipantError> {
        let participant = Participant::Robot(self.vehicles[index].id);
        let Effects { published, route, wake_at, decision, rejected, .. } =
            self.participants.step(participant, self.now, event)?;
        self.trial.rejected += rejected.len() as u64;
        self.vehicles[index].wake_at = wake_at;
        for (audience, message) in published {
            self.post(index, audience, &message);
        }
        if let Some(cells) = route {
            let time = if decision.is_some() { self.thinking.time } else { Duration::ZERO };
            self.vehicles[index].pending = Some((self.now + time, cells));
        }
        self.trial.decisions.extend(decision);
        Ok(())
    }

    fn post(&mut self, from: usize, audience: Audience, message: &Message) {
        let sender = Participant::Robot(self.vehicles[from].id);
        if let (Audience::All, Message::Observation(observation)) = (audience, message) {
            self.trial.positions.add(observation);
        }
        for (to, vehicle) in self.vehicles.iter().enumerate() {
            let is_meant = match audience {
                Audience::All => to != from,
                Audience::One(one) => one == Participant::Robot(vehicle.id),
            };
            if is_meant {
                self.mail.push_back((sender, to, message.clone()));
            }
        }
    }

    fn deliver(&mut self) -> Result<(), ParticipantError> {
        while let Some((from, to, message)) = self.mail.pop_front() {
            self.tell(to, Event::Received { from, message })?;
        }
        Ok(())
    }

    fn end(self) -> Trial {
        Trial {
            ended: self.now,
            driven_meters: self.vehicles.iter().map(|vehicle| vehicle.body.driven_meters()).collect(),
            digest: self.merged.digest(),
            ..self.trial
        }
    }
}

#[cfg(test)]
mod tests;
