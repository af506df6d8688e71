//! The pilot and the autopilot, connected: driven by the caller's time, like a state machine.

use std::collections::{BTreeSet, VecDeque};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use dragnet_lattice::plane::{Pose, wrapped_radians};
use dragnet_mavlink::MavMessage;
use dragnet_mavlink::autopilot::{
    Action as AutopilotAction, Autopilot, Event as AutopilotEvent, Level, Notice,
};
use dragnet_mavlink::frames::Frame;
use dragnet_mavlink::target::{Place, Position, Target};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::Event as AgentEvent;
use dragnet_scenario::Scenario;
use dragnet_scenario::map_file::{GeoPoint, Georeference};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::terrain::Terrain;
use dragnet_vehicle::camera::{Attitude, DetectionBox};
use dragnet_vehicle::pilot::alarms::Alarms;
use dragnet_vehicle::pilot::diagnostic::{Diagnostic, Level as PilotLevel};
use dragnet_vehicle::pilot::{
    Action as PilotAction, CameraDetections, CameraFrame, Event as PilotEvent, Pilot, PoseEstimate, Report,
};

use super::detections::{Seen, Sighting};
use super::settings::Checked;

/// Lean beyond which a frame is not used, radians: what is in view is then not what the camera's settings say.
const MAX_LEAN_RADIANS: f64 = 0.5;
/// Share of a copter's altitude by which it may be off for its frames to be used.
const ALTITUDE_SHARE: f64 = 0.25;
/// Time without a refused frame after which frames are reported to be well again, nanoseconds.
const RECOVERY_NS: u64 = 3_000_000_000;

/// The time by the vehicle's clock and by the computer's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Now {
    pub(crate) mission_ns: u64,
    pub(crate) unix_ns: i64,
}

/// The effects of a vehicle, in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Effect {
    /// For the agent: the vehicle's cell, and the readings since the last observation.
    Sensed { cell: Cell, readings: Vec<Reading> },
    /// For the agent: another event of its vehicle.
    Report(AgentEvent<Message>),
    /// For the autopilot.
    Send(Box<MavMessage>),
    /// For the log.
    Tell(Notice),
}

/// The frame of the autopilot's positions.
#[derive(Clone, Copy, Debug)]
enum MapFrame {
    Global {
        earth: Georeference,
        /// Direction of the north on the map, radians counterclockwise from the direction of its rows.
        north_radians: f64,
    },
    /// The pose of the map in a frame with its origin at the autopilot's, x to the east, y to the north.
    Local(Pose),
}

/// A vehicle behind an autopilot.
pub(crate) struct Vehicle {
    pilot: Pilot,
    autopilot: Autopilot,
    frame: MapFrame,
    terrain: Arc<Terrain>,
    detection_threshold: f64,
    heading_std_radians: f64,
    /// Height of a copter's search above home, meters.
    altitude_meters: Option<f64>,
    /// The last position.
    here: Option<Position>,
    alarms: Alarms<String>,
}

enum Step {
    Pilot(PilotEvent),
    Autopilot(AutopilotEvent),
}

impl Vehicle {
    /// `None` if the positions are global and the map has none on the earth.
    pub(crate) fn new(pilot: Pilot, settings: &Checked, scenario: &Scenario) -> Option<Self> {
        use dragnet_mavlink::autopilot::config::PositionSource;
        let frame = match settings.config.position {
            PositionSource::Global => MapFrame::global(*scenario.georeference()?),
            PositionSource::Local => {
                let origin = scenario.origin();
                MapFrame::Local(Pose::new(origin.x_meters, origin.y_meters, origin.yaw_radians))
            }
        };
        Some(Self {
            pilot,
            autopilot: Autopilot::new(settings.config),
            frame,
            terrain: Arc::new(scenario.terrain().clone()),
            detection_threshold: scenario.mission().detection_threshold,
            heading_std_radians: settings.heading_std_radians,
            altitude_meters: settings.config.altitude_meters,
            here: None,
            alarms: Alarms::new(RECOVERY_NS),
        })
    }

    /// Something arrives from the autopilot.
    pub(crate) fn receive(&mut self, now: Now, frame: Frame) -> Vec<Effect> {
        let event = match frame {
            Frame::Message(header, message) => AutopilotEvent::Received(header, message),
            Frame::Unreadable(reason) => AutopilotEvent::Unreadable(reason),
        };
        self.run(now, Step::Autopilot(event))
    }

    /// A datagram of a detector: a sighting, or the reason why it is none.
    pub(crate) fn see(&mut self, now: Now, sighting: Result<Sighting, String>) -> Vec<Effect> {
        match sighting.and_then(|sighting| self.frame(now, sighting)) {
            Ok(frame) => {
                self.alarms.ease(now.mission_ns, &"detections".to_owned());
                self.run(now, Step::Pilot(PilotEvent::Frame(frame)))
            }
            Err(reason) => self.ill(now, "detections", reason),
        }
    }

    /// The agent has a new route, or knows of other closed cells.
    pub(crate) fn heed(&mut self, now: Now, event: PilotEvent) -> Vec<Effect> {
        self.run(now, Step::Pilot(event))
    }

    /// The team's belief has changed.
    pub(crate) fn believe(&mut self, now: Now, belief: &Belief) -> Vec<Effect> {
        let is_found = |&cell: &Cell| belief.is_found(cell, self.detection_threshold);
        let declared: BTreeSet<Cell> = self.terrain.searched_cells().filter(is_found).collect();
        self.run(now, Step::Pilot(PilotEvent::Declared(declared)))
    }

    /// To be called every 100 ms.
    pub(crate) fn tick(&mut self, now: Now) -> Vec<Effect> {
        let mut effects = self.run(now, Step::Autopilot(AutopilotEvent::Tick));
        effects.extend(self.run(now, Step::Pilot(PilotEvent::Tick)));
        for subject in self.alarms.settle(now.mission_ns) {
            effects.extend(self.tell(now, Level::Ok, subject, "well again".to_owned()));
        }
        effects
    }

    /// The robot ends: the vehicle stays where it is.
    pub(crate) fn halt(&mut self, now: Now) -> Vec<Effect> {
        self.run(now, Step::Autopilot(AutopilotEvent::Hold))
    }

    /// What one of the two does may be news for the other.
    fn run(&mut self, now: Now, step: Step) -> Vec<Effect> {
        let mut steps = VecDeque::from([step]);
        let mut effects = Vec::new();
        while let Some(step) = steps.pop_front() {
            match step {
                Step::Pilot(event) => {
                    for action in self.pilot.handle(now.mission_ns, event) {
                        steps.extend(self.of_pilot(action, &mut effects));
                    }
                }
                Step::Autopilot(event) => {
                    for action in self.autopilot.handle(now.mission_ns, event) {
                        steps.extend(self.of_autopilot(action, &mut effects));
                    }
                }
            }
        }
        effects
    }

    fn of_pilot(&self, action: PilotAction, effects: &mut Vec<Effect>) -> Option<Step> {
        let mut report = |event| {
            effects.push(Effect::Report(event));
            None
        };
        let event = match action {
            PilotAction::Sensed { cell, readings } => {
                effects.push(Effect::Sensed { cell, readings });
                return None;
            }
            PilotAction::RouteFailed { blocked } => return report(AgentEvent::RouteFailed { blocked }),
            PilotAction::Doubted { cells } => return report(AgentEvent::Doubted { cells }),
            PilotAction::LineOfSight(seen) => return report(AgentEvent::LineOfSight(seen)),
            PilotAction::Located(positions) => return report(AgentEvent::Located(positions)),
            PilotAction::Go(pose) => AutopilotEvent::Go(self.frame.target(&pose)),
            // Settings of the lattice are refused beside an autopilot; the end of its path is what remains of it.
            PilotAction::Drive(plan) => AutopilotEvent::Go(self.frame.target(plan.poses.last()?)),
            PilotAction::Hold => AutopilotEvent::Hold,
            PilotAction::Tell(diagnostic) => {
                let notice = noticed(diagnostic);
                effects.push(Effect::Tell(notice.clone()));
                AutopilotEvent::Say(notice)
            }
            // Counted for topics, of which there are none.
            PilotAction::Refuse(..) => return None,
        };
        Some(Step::Autopilot(event))
    }

    fn of_autopilot(&mut self, action: AutopilotAction, effects: &mut Vec<Effect>) -> Option<Step> {
        match action {
            AutopilotAction::Send(message) => effects.push(Effect::Send(message)),
            AutopilotAction::Tell(notice) => effects.push(Effect::Tell(notice)),
            AutopilotAction::Failed(reason) => {
                return Some(Step::Pilot(PilotEvent::Drive(Report::Failed(reason))));
            }
            AutopilotAction::Position(position) => {
                self.here = Some(position);
                return Some(Step::Pilot(PilotEvent::Pose(self.estimate(&position))));
            }
        }
        None
    }

    fn estimate(&self, position: &Position) -> PoseEstimate {
        PoseEstimate {
            time_ns: position.time_ns,
            pose: self.frame.pose(position),
            deviation_meters: position.std_meters,
            heading_deviation_radians: self.heading_std_radians,
        }
    }

    /// A frame of a camera; its boxes as bearings on the horizon, by the vehicle's roll and pitch.
    fn frame(&self, now: Now, sighting: Sighting) -> Result<CameraFrame, String> {
        let Some(here) = self.here else { return Err("a frame comes before any position".to_owned()) };
        self.check_view(&here)?;
        let time_ns = match sighting.unix_ns {
            Some(unix_ns) => now.mission_ns.saturating_add_signed(unix_ns.saturating_sub(now.unix_ns)),
            None => now.mission_ns,
        };
        let detections = match sighting.seen {
            Seen::Bearings(bearings) => CameraDetections::Bearings(bearings),
            Seen::Boxes(boxes) => self.bearings(&sighting.camera, boxes, &here),
        };
        Ok(CameraFrame { time_ns, camera: sighting.camera, head_radians: 0.0, detections })
    }

    /// Boxes that cannot be remain boxes: the pilot says what is wrong with them.
    fn bearings(&self, camera: &str, boxes: Vec<DetectionBox>, here: &Position) -> CameraDetections {
        let Some(camera) = self.pilot.camera(camera) else { return CameraDetections::Boxes(boxes) };
        if camera.detections(&boxes).is_ok_and(|detections| detections.refused.is_empty()) {
            let attitude = Attitude { roll_radians: here.roll_radians, pitch_radians: here.pitch_radians };
            let bearing = |one: &DetectionBox| {
                let (column, row) = (f64::midpoint(one.left, one.right), f64::midpoint(one.top, one.bottom));
                camera.level_bearing_radians(column, row, attitude)
            };
            return CameraDetections::Bearings(boxes.iter().filter_map(bearing).collect());
        }
        CameraDetections::Boxes(boxes)
    }

    /// Whether the cameras see what their settings say.
    fn check_view(&self, here: &Position) -> Result<(), String> {
        let lean_radians = here.roll_radians.abs().max(here.pitch_radians.abs());
        if lean_radians > MAX_LEAN_RADIANS {
            let (lean, most) = (lean_radians.to_degrees(), MAX_LEAN_RADIANS.to_degrees());
            return Err(format!(
                "frames are not used while the vehicle leans by {lean:.0} degrees; allowed are {most:.0}"
            ));
        }
        let Some(wanted) = self.altitude_meters else { return Ok(()) };
        let off_meters = (here.altitude_meters - wanted).abs();
        if off_meters > ALTITUDE_SHARE * wanted {
            let (altitude, most) = (here.altitude_meters, ALTITUDE_SHARE * wanted);
            return Err(format!(
                "frames are not used {altitude:.1} m above home; allowed is {wanted:.1} m, {most:.1} m more or less"
            ));
        }
        Ok(())
    }

    fn ill(&mut self, now: Now, subject: &str, reason: String) -> Vec<Effect> {
        if self.alarms.raise(now.mission_ns, subject.to_owned(), reason.clone()) {
            return self.tell(now, Level::Warning, subject.to_owned(), reason);
        }
        Vec::new()
    }

    fn tell(&mut self, now: Now, level: Level, subject: String, message: String) -> Vec<Effect> {
        let notice = Notice { level, subject, message };
        let said = self.run(now, Step::Autopilot(AutopilotEvent::Say(notice.clone())));
        [Effect::Tell(notice)].into_iter().chain(said).collect()
    }
}

impl MapFrame {
    fn global(earth: Georeference) -> Self {
        let corner = earth.south_west();
        let north = GeoPoint { latitude_degrees: corner.latitude_degrees + 1e-3, ..corner };
        let (x_meters, y_meters) = earth.meters(north);
        Self::Global { earth, north_radians: y_meters.atan2(x_meters) }
    }

    /// The pose on the map of a vehicle at a position.
    fn pose(&self, position: &Position) -> Pose {
        match (self, position.place) {
            (
                Self::Global { earth, north_radians },
                Place::Global { latitude_degrees, longitude_degrees },
            ) => {
                let (x_meters, y_meters) = earth.meters(GeoPoint { longitude_degrees, latitude_degrees });
                Pose::new(x_meters, y_meters, wrapped_radians(north_radians - position.yaw_radians))
            }
            (Self::Local(map), Place::Local { north_meters, east_meters }) => {
                let heading_radians = wrapped_radians(FRAC_PI_2 - position.yaw_radians);
                Pose::new(east_meters, north_meters, heading_radians).seen_from(map)
            }
            // The autopilot gives positions of the kind that it was told to.
            (Self::Global { .. }, Place::Local { .. }) | (Self::Local(_), Place::Global { .. }) => {
                Pose::new(f64::NAN, f64::NAN, f64::NAN)
            }
        }
    }

    /// The target of a vehicle that is to have a pose on the map.
    fn target(&self, pose: &Pose) -> Target {
        match self {
            Self::Global { earth, north_radians } => {
                let GeoPoint { longitude_degrees, latitude_degrees } =
                    earth.point((pose.x_meters, pose.y_meters));
                let place = Place::Global { latitude_degrees, longitude_degrees };
                Target { place, yaw_radians: wrapped_radians(north_radians - pose.heading_radians) }
            }
            Self::Local(map) => {
                let pose = map.of_part(pose);
                let place = Place::Local { north_meters: pose.y_meters, east_meters: pose.x_meters };
                Target { place, yaw_radians: wrapped_radians(FRAC_PI_2 - pose.heading_radians) }
            }
        }
    }
}

fn noticed(diagnostic: Diagnostic) -> Notice {
    let level = match diagnostic.level {
        PilotLevel::Ok => Level::Ok,
        PilotLevel::Warning => Level::Warning,
        PilotLevel::Error => Level::Error,
    };
    Notice { level, subject: diagnostic.name, message: diagnostic.message }
}

#[cfg(test)]
mod tests;
