//! The coordinator, in the test's own process, with access to all that it receives.

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_proto::convert::Codec;
use dragnet_proto::message::{Heartbeat, Message};
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_proto::validation::Rejection;
use dragnet_runtime::clock::Clock;
use dragnet_runtime::link::Link;
use dragnet_runtime::session;
use dragnet_runtime::wall_clock::{self, Report};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Observation, Origin, RobotId, Source};
use tokio::sync::{mpsc, watch};

use crate::field::{Field, PACE};

/// The messages received so far.
#[derive(Clone, Default)]
pub(crate) struct Knowledge {
    /// Each observation, in order of arrival.
    pub(crate) observations: Vec<Arc<Observation>>,
    /// The last known start of each robot.
    latest: BTreeMap<Source, Origin>,
    /// Number of observations with the name of another one.
    pub(crate) conflicting: usize,
    /// Of all evidence.
    pub(crate) digest: Option<Digest>,
    /// Digest of each robot's evidence, by its last heartbeat.
    pub(crate) believed: BTreeMap<RobotId, Digest>,
    /// All heartbeats, in order of arrival.
    pub(crate) beats: Vec<Heartbeat>,
}

impl Knowledge {
    /// Whether the evidence of all robots equals what was received.
    pub(crate) fn is_shared_by(&self, robots: usize) -> bool {
        self.believed.len() == robots && self.believed.values().all(|&digest| Some(digest) == self.digest)
    }

    /// The last known start of a robot.
    pub(crate) fn latest(&self, robot: RobotId) -> Option<Origin> {
        self.latest.get(&robot.into()).copied()
    }

    fn add(&mut self, observation: &Arc<Observation>) {
        let origin = observation.origin;
        let latest = self.latest.entry(origin.source).or_insert(origin);
        *latest = origin.max(*latest);
        self.observations.push(Arc::clone(observation));
    }
}

/// Coordinates a mission until its state is no longer observed.
pub(crate) async fn coordinate(field: &Field, knowledge: watch::Sender<Knowledge>) {
    let (_, no_commands) = mpsc::channel(1);
    coordinate_by(field, knowledge, no_commands).await;
}

/// The same with the operator's commands.
pub(crate) async fn coordinate_by(
    field: &Field,
    knowledge: watch::Sender<Knowledge>,
    commands: mpsc::Receiver<Report>,
) {
    let scenario = field.scenario();
    let session = session::open(&field.endpoints(1)).await.unwrap();
    let codec = Codec::new(scenario.terrain().grid());
    let me = Participant::Coordinator;
    let mut link = Link::join(session, "field".parse().unwrap(), me, codec).await.unwrap();
    link.announce().await.unwrap();
    let node = CoordinatorNode::new(Mission::new(CoordinatorConfig::of(&scenario)), None);
    let unheeded = knowledge.clone();
    let mut witness = Witness { node, knowledge };
    let stop = async move { unheeded.closed().await };
    wall_clock::run(&mut link, &mut witness, scenario.places(), Clock::new(PACE), None, commands, stop)
        .await
        .unwrap();
}

/// A coordinator that publishes its state to the test.
struct Witness {
    node: CoordinatorNode,
    knowledge: watch::Sender<Knowledge>,
}

impl StateMachine for Witness {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let heartbeat = match &event {
            Event::Received { message: Message::Heartbeat(beat), .. } => Some(beat.clone()),
            _ => None,
        };
        let effects = self.node.handle(now, event)?;
        self.knowledge.send_modify(|knowledge| {
            effects.kept.iter().for_each(|observation| knowledge.add(observation));
            let refused = effects.rejected.iter();
            knowledge.conflicting += refused.filter(|refused| refused.why == Rejection::Conflicting).count();
            knowledge.digest = Some(self.node.digest());
            if let Some(heartbeat) = heartbeat {
                knowledge.believed.insert(heartbeat.robot, heartbeat.digest);
                knowledge.beats.push(heartbeat);
            }
        });
        Ok(effects)
    }

    fn digest(&self) -> Digest {
        self.node.digest()
    }

    fn observations(&self) -> u64 {
        self.node.observations()
    }
}
