//! A robot's vehicle in the field: its ROS 2 network and its pilot, driven by the wall clock.
//!
//! What the network says goes to the pilot ([`dragnet_vehicle::pilot`]), what the pilot says goes to the robot's mind or
//! back to the network. Its mind hears of cells and looks alone, and knows nothing of cameras and motors; where it goes
//! and what it believes comes back over [`Orders`].

mod board;
mod mind;
mod place;

use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::convert::viewer::Viewer;
use dragnet_proto::participant::Stimulus;
use dragnet_proto::ros::errand::{Errand, Progress};
use dragnet_proto::ros::input::{DetectedBox, GoalStatus, Occupancy};
use dragnet_proto::ros::output::{FoundObject, Output};
use dragnet_proto::scenario::Scenario;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::terrain::Terrain;
use dragnet_vehicle::camera::DetectionBox;
use dragnet_vehicle::lattice::costmap::{CostMap, OccupancyRule};
use dragnet_vehicle::pilot::{Action, CameraFrame, Event, Fix, Pilot, Report as DriveReport, Sights};
use dragnet_vehicle::plane::Pose;
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, MissedTickBehavior, interval};

use crate::config::Body;
use crate::live::{Clock, Report};
use crate::ros::node::{Heard, Node};
use crate::ros::settings::Stamps;
use crate::{LinkError, unix_time};
use board::Board;
use place::{Located, Places, planar, posed};

pub use mind::Embodied;

/// How often the pilot hears that time passes: silence is noticed so soon.
const TICK: Duration = Duration::from_millis(100);
/// How often people are shown what the robot believes, and what is wrong with it, at most.
const SHOW: Duration = Duration::from_secs(1);
/// A goal that nobody has taken up is told again after so long.
const PATIENCE: Duration = Duration::from_secs(5);
/// Of a map that the vehicle hears: what is at least so probably occupied is never driven on; what is not known is
/// driven on as little as possible.
const RULE: OccupancyRule = OccupancyRule { lethal_percent: 65, unknown_cost: 50 };

/// What a robot's mind has for its vehicle.
#[derive(Debug)]
pub struct Orders {
    routes: mpsc::UnboundedReceiver<Vec<Cell>>,
    beliefs: watch::Receiver<Arc<Belief>>,
}

/// A vehicle on its own network.
pub struct Vehicle {
    node: Node,
    pilot: Pilot,
    places: Places,
    clock: Clock,
    terrain: Arc<Terrain>,
    tau: f64,
    stamps: Stamps,
    board: Board,
    /// The last place that the network said.
    located: Option<Pose>,
    /// Goals that Nav2 told of last.
    goals: Vec<GoalStatus>,
    errand: Option<(Errand, Pose, Instant)>,
}

impl Vehicle {
    /// Joins the vehicle's network, which may take until that is there.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn open(body: Body, scenario: &Scenario, clock: Clock) -> Result<Self, LinkError> {
        let Body { ros: settings, pilot, .. } = body;
        let places =
            Places::new(settings.localization(), scenario.origin(), scenario.georeference().copied());
        let stamps = settings.stamps();
        Ok(Self {
            node: Node::open(settings).await?,
            pilot,
            places,
            clock,
            terrain: Arc::new(scenario.terrain().clone()),
            tau: scenario.mission().tau,
            stamps,
            board: Board::default(),
            located: None,
            goals: Vec::new(),
            errand: None,
        })
    }

    /// Serves a robot's mind until it is gone; then the vehicle stands still.
    ///
    /// # Errors
    /// If Zenoh refuses to say something.
    pub async fn run(mut self, mut orders: Orders, reports: mpsc::Sender<Report>) -> Result<(), LinkError> {
        let [mut tick, mut show] = [TICK, SHOW].map(interval);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let actions = tokio::select! {
                heard = self.node.hear() => self.hear(heard),
                route = orders.routes.recv() => match route {
                    Some(route) => self.tell(Event::Route(route)),
                    None => return self.halt().await,
                },
                _ = tick.tick() => {
                    self.insist().await?;
                    self.tell(Event::Tick)
                }
                _ = show.tick() => {
                    self.show(&mut orders.beliefs).await?;
                    Vec::new()
                }
            };
            for action in actions {
                self.act(action, &reports).await?;
            }
        }
    }

    fn tell(&mut self, event: Event) -> Vec<Action> {
        self.pilot.handle(self.clock.now().0, event)
    }

    /// Mission time of a stamp: as long ago as the stamp is by the computer's clock, which may be set meanwhile.
    fn time_ns(&self, stamp_unix_ns: i64) -> u64 {
        let now_ns = self.clock.now().0;
        match self.stamps {
            Stamps::Arrival => now_ns,
            Stamps::Clock => now_ns.saturating_add_signed(stamp_unix_ns.saturating_sub(unix_time::now_ns())),
        }
    }

    fn hear(&mut self, heard: Heard) -> Vec<Action> {
        let located = match heard {
            Heard::Odometry(odometry) => self.places.odometry(&odometry),
            Heard::Pose(pose) => self.places.pose(&pose),
            Heard::Fix(fix) => self.places.fix(&fix),
            Heard::Map(map) => return self.hear_map(&map),
            Heard::Detections { camera, detections } => {
                let time_ns = self.time_ns(detections.stamp_unix_ns);
                let sights = Sights::Boxes(detections.boxes.iter().map(of_box).collect());
                let frame = CameraFrame { time_ns, camera: camera.to_string(), head_radians: 0.0, sights };
                return self.tell(Event::Frame(frame));
            }
            // Images are for a detector of this program's own, which it has not.
            Heard::Image { .. } => None,
            Heard::Goals(goals) => return self.hear_goals(goals),
            Heard::Refused { topic, reason } => {
                self.board.refuse(&topic, &reason);
                None
            }
        };
        located.map(|located| self.locate(&located)).unwrap_or_default()
    }

    fn locate(&mut self, located: &Located) -> Vec<Action> {
        self.located = Some(located.pose);
        let fix = Fix {
            time_ns: self.time_ns(located.stamp_unix_ns),
            pose: located.pose,
            deviation_meters: located.deviation_meters,
            heading_deviation_radians: located.heading_deviation_radians,
        };
        self.tell(Event::Pose(fix))
    }

    fn hear_map(&mut self, map: &Occupancy) -> Vec<Action> {
        let corner = self.places.on_map(&posed(map.origin));
        let origin_meters = (corner.x_meters, corner.y_meters);
        let made = if corner.heading_radians.abs() > place::SQUARE_RADIANS {
            Err(format!("the map is turned by {:.3} rad against the search's", corner.heading_radians))
        } else {
            CostMap::from_occupancy(map.grid, map.cell_meters, origin_meters, &map.cells, RULE)
                .map_err(|error| error.to_string())
        };
        match made {
            Ok(map) => self.tell(Event::Map(map)),
            Err(reason) => {
                self.board.note("map", &reason);
                Vec::new()
            }
        }
    }

    fn hear_goals(&mut self, goals: Vec<GoalStatus>) -> Vec<Action> {
        self.goals = goals;
        let Some((errand, ..)) = &mut self.errand else { return Vec::new() };
        errand.follow(&self.goals);
        let report = match errand.progress() {
            Progress::Unanswered | Progress::Underway => return Vec::new(),
            Progress::Reached => DriveReport::Arrived,
            Progress::Failed => DriveReport::Failed("the navigation gave up".to_owned()),
            Progress::Canceled => DriveReport::Failed("somebody called it off".to_owned()),
            Progress::Replaced => DriveReport::Failed("somebody sent the robot elsewhere".to_owned()),
        };
        self.errand = None;
        self.tell(Event::Drive(report))
    }

    async fn act(&mut self, action: Action, reports: &mpsc::Sender<Report>) -> Result<(), LinkError> {
        match action {
            Action::Sensed { cell, readings } => {
                // A mind that is gone hears nothing: the vehicle is about to be told so.
                let _ = reports.send((None, Stimulus::Sensed { cell, readings })).await;
                Ok(())
            }
            Action::Drive(plan) => {
                let poses = plan.poses.iter().map(|pose| self.in_frame(pose)).collect();
                self.say(Output::Path(poses)).await
            }
            Action::Go(pose) => self.go(pose).await,
            Action::Hold => self.halt().await,
            Action::Tell(diagnostic) => {
                self.board.pin(&diagnostic);
                self.say(Output::Diagnostics(self.board.all())).await
            }
        }
    }

    async fn go(&mut self, pose: Pose) -> Result<(), LinkError> {
        self.errand = Some((Errand::begin(&self.goals), pose, Instant::now()));
        self.say(Output::Goal(self.in_frame(&pose))).await
    }

    /// Tells a goal again that nobody has taken up.
    async fn insist(&mut self) -> Result<(), LinkError> {
        match &self.errand {
            Some((errand, pose, told))
                if errand.progress() == Progress::Unanswered && told.elapsed() > PATIENCE =>
            {
                let pose = *pose;
                self.board.note("goal", "nobody takes up the goal; it is told again");
                self.go(pose).await
            }
            _ => Ok(()),
        }
    }

    /// Nothing is left to drive. Nav2 is sent to where the robot is, which is how topics call a goal off.
    async fn halt(&mut self) -> Result<(), LinkError> {
        if let (Some(_), Some(here)) = (self.errand.take(), self.located) {
            self.say(Output::Goal(self.in_frame(&here))).await?;
        }
        self.say(Output::Path(Vec::new())).await
    }

    async fn show(&mut self, beliefs: &mut watch::Receiver<Arc<Belief>>) -> Result<(), LinkError> {
        self.say(Output::Diagnostics(self.board.all())).await?;
        if !beliefs.has_changed().unwrap_or(false) {
            return Ok(());
        }
        let belief = Arc::clone(&beliefs.borrow_and_update());
        let start_unix_ns = unix_time::now_ns().saturating_sub_unsigned(self.clock.now().0);
        let drawn = Viewer::new(&self.terrain, start_unix_ns).belief(&belief, self.clock.now());
        let found = self.found(&belief);
        self.say(Output::Belief(drawn, self.in_frame(&Pose::default()))).await?;
        self.say(Output::Objects(found)).await
    }

    /// Cells in which the robot believes an object, as sure as the mission asks.
    fn found(&self, belief: &Belief) -> Vec<FoundObject> {
        let is_found = |cell: &Cell| belief.probability(*cell) >= self.tau;
        let object = |cell: Cell| {
            let (x_meters, y_meters) = self.terrain.center_meters(cell);
            let middle = self.in_frame(&Pose::new(x_meters, y_meters, 0.0));
            FoundObject {
                id: cell.number().to_string(),
                class: "object".to_owned(),
                x_meters: middle.x_meters,
                y_meters: middle.y_meters,
                edge_meters: self.terrain.cell_meters(),
                probability: belief.probability(cell),
            }
        };
        self.terrain.searched_cells().filter(is_found).map(object).collect()
    }

    /// A pose on the search's map in the frame of the vehicle's network.
    fn in_frame(&self, pose: &Pose) -> dragnet_proto::ros::input::PlanarPose {
        planar(&self.places.in_frame(pose))
    }

    async fn say(&mut self, output: Output) -> Result<(), LinkError> {
        self.node.say(unix_time::now_ns(), output).await
    }
}

fn of_box(found: &DetectedBox) -> DetectionBox {
    let DetectedBox { left, top, right, bottom, .. } = *found;
    DetectionBox { left, top, right, bottom }
}
