use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_proto::convert::Codec;
use dragnet_proto::message::MessageKind;
use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::Scenario;
use dragnet_search::evidence::{Digest, Reading};

use super::*;
use crate::session::{Endpoints, free_endpoints, open};
use crate::unix_time;

/// A coordinator that reports each heartbeat: its own time, and the robot's.
struct Listener {
    node: CoordinatorNode,
    /// The date of mission time 0 that it was told last, Unix time in nanoseconds.
    began_unix_ns: Option<i64>,
    received: mpsc::UnboundedSender<(MissionTime, MissionTime)>,
}

impl StateMachine for Listener {
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        if let Event::Received { message: Message::Heartbeat(heartbeat), .. } = &event {
            let _ = self.received.send((now, MissionTime(heartbeat.time_ns)));
        }
        if let Event::Began { unix_ns } = event {
            self.began_unix_ns = Some(unix_ns);
        }
        self.node.handle(now, event)
    }

    fn digest(&self) -> Digest {
        self.node.digest()
    }

    fn observations(&self) -> u64 {
        self.node.observations()
    }
}

async fn join(scenario: &Scenario, me: Participant, endpoints: &Endpoints) -> Link {
    let session = open(endpoints).await.unwrap();
    let codec = Codec::new(scenario.terrain().grid());
    let mut link = Link::join(session, "late".parse().unwrap(), me, codec).await.unwrap();
    link.announce().await.unwrap();
    link
}

/// The mission began long before this coordinator did.
#[tokio::test(flavor = "multi_thread")]
async fn a_coordinator_that_starts_late_adopts_its_robots_time() {
    let text = "name = 'late'\nmap = { shape = 'all_traversable', rows = 12, columns = 12 }\nobjects.count = 1\n\
                mission = { budget_seconds = 1e6, heartbeat_seconds = 100.0, liveness_timeout_seconds = 200.0 }\n";
    let scenario = Scenario::from_text(std::path::Path::new("late.toml"), text.to_owned()).unwrap();
    let listen = free_endpoints(1).unwrap();
    let long_after = MissionTime(5_000_000_000_000);

    let endpoints = Endpoints { listen: listen.clone(), ..Endpoints::default() };
    let mut robot = join(&scenario, Participant::Robot(RobotId::FIRST), &endpoints).await;
    let mut agent = Agent::new(AgentConfig::of_team(&scenario, 1).remove(0));
    let (sender, reports) = mpsc::channel(1);
    let cell = scenario.terrain().grid().cells().next().unwrap();
    let variance = scenario.sensor().variance(0);
    let readings = vec![Reading { cell, value: 0.0, variance }];
    sender.send((Some(long_after), Event::Sensed { cell, readings })).await.unwrap();
    let places = scenario.places();
    let searching = tokio::spawn(async move {
        let never = std::future::pending::<()>();
        run(&mut robot, &mut agent, places, Clock::new(1.0), None, reports, never).await
    });

    // The channel holds one: when there is space for this, the robot has published its observation.
    for _ in 0..2 {
        sender.send((None, Event::Woke)).await.unwrap();
    }

    let endpoints = Endpoints { connect: listen, ..Endpoints::default() };
    let mut link = join(&scenario, Participant::Coordinator, &endpoints).await;
    let (received, mut times) = mpsc::unbounded_channel();
    let mut listener = Listener {
        node: CoordinatorNode::new(Mission::new(CoordinatorConfig::of(&scenario)), None),
        began_unix_ns: None,
        received,
    };
    let (_, no_reports) = mpsc::channel(1);
    let never = std::future::pending::<()>();
    let listening =
        run(&mut link, &mut listener, scenario.places(), Clock::new(1.0), None, no_reports, never);
    let (own, robots) = tokio::select! {
        ended = listening => panic!("{ended:?}"),
        // Long before the next heartbeat that is due.
        times = tokio::time::timeout(Duration::from_mins(1), times.recv()) => times.unwrap().unwrap(),
    };
    assert!(robots >= long_after);
    assert!(own >= robots, "{own:?} {robots:?}");
    let ago_ns = u64::try_from(unix_time::now_ns() - listener.began_unix_ns.unwrap()).unwrap();
    assert!(MissionTime(ago_ns) >= long_after, "mission time 0 was before it started: {ago_ns} ns ago");
    searching.abort();
}

/// Nobody is there, and nothing is to be done: what would end it is looked at when something happens.
#[tokio::test(flavor = "multi_thread")]
async fn a_coordinator_that_waits_sleeps() {
    let text = "name = 'late'\nmap = { shape = 'all_traversable', rows = 12, columns = 12 }\nobjects.count = 1\n\
                mission.budget_seconds = 1e6\n";
    let scenario = Scenario::from_text(std::path::Path::new("late.toml"), text.to_owned()).unwrap();
    let endpoints = Endpoints { listen: free_endpoints(1).unwrap(), ..Endpoints::default() };
    let mut link = join(&scenario, Participant::Coordinator, &endpoints).await;
    let mut node = CoordinatorNode::new(Mission::new(CoordinatorConfig::of(&scenario)), None);
    let (_, no_reports) = mpsc::channel(1);
    let mut looks = 0;
    let mut over = Box::pin(tokio::time::sleep(Duration::from_secs(7)));
    let stop = std::future::poll_fn(|context| {
        looks += 1;
        over.as_mut().poll(context)
    });
    run(&mut link, &mut node, scenario.places(), Clock::new(1.0), None, no_reports, stop).await.unwrap();
    assert!(looks < 200, "{looks}");
}

/// Kinds of the messages of a robot that has taken readings, up to the first pause of two seconds, with this line in its
/// scenario.
async fn heard(network: &str) -> Vec<MessageKind> {
    let text = format!(
        "name = 'radio'\nmap = {{ shape = 'all_traversable', rows = 12, columns = 12 }}\nobjects.count = 1\n\
         mission.budget_seconds = 1e6\n{network}\n"
    );
    let scenario = Scenario::from_text(std::path::Path::new("radio.toml"), text).unwrap();
    let listen = free_endpoints(1).unwrap();
    let endpoints = Endpoints { connect: listen.clone(), ..Endpoints::default() };
    let robot = open(&Endpoints { listen, ..Endpoints::default() }).await.unwrap();
    let me = Participant::Robot(RobotId::FIRST);
    let mut robot = Link::join(robot, "late".parse().unwrap(), me, Codec::of(&scenario)).await.unwrap();
    robot.announce().await.unwrap();
    let mut coordinator = join(&scenario, Participant::Coordinator, &endpoints).await;
    coordinator.wait_for(&[me], Duration::from_mins(1), |_| ()).await.unwrap();
    robot.wait_for(&[Participant::Coordinator], Duration::from_mins(1), |_| ()).await.unwrap();

    let mut agent = Agent::new(AgentConfig::of_team(&scenario, 1).remove(0));
    let from = scenario.terrain().grid().cell_numbered(5 * 12 + 5).unwrap();
    let cells = scenario.sensor().footprint().iter();
    let readings = cells.filter_map(|it| {
        let cell = scenario.terrain().grid().step(from, it.offset)?;
        Some(Reading { cell, value: 0.0, variance: it.variance })
    });
    let (sender, reports) = mpsc::channel(1);
    let sensed = Event::Sensed { cell: from, readings: readings.collect() };
    sender.send((Some(MissionTime::START), sensed)).await.unwrap();
    let searching = tokio::spawn(async move {
        run(
            &mut robot,
            &mut agent,
            scenario.places(),
            Clock::new(1.0),
            None,
            reports,
            std::future::pending::<()>(),
        )
        .await
    });
    let mut kinds = Vec::new();
    let mut patience = Duration::from_mins(1);
    while let Ok(Some(incoming)) = tokio::time::timeout(patience, coordinator.receive()).await {
        if let Incoming::Message { message, .. } = incoming {
            kinds.push(message.kind());
            patience = Duration::from_secs(2);
        }
    }
    searching.abort();
    kinds
}

/// At 10 bytes a second an observation takes eight seconds. A listener that knows of no radio reads it, too.
#[tokio::test(flavor = "multi_thread")]
async fn a_plan_waits_until_the_radio_is_free() {
    let observation = MessageKind::Observation;
    assert_eq!(heard("network.bytes_per_second = 10.0").await, [observation]);
    assert_eq!(heard("").await[..2], [observation, MessageKind::Intent]);
}
