//! A team over real Zenoh sessions gives the same results as in one process.

use std::path::{Path, PathBuf};
use std::time::Duration;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_runtime::RuntimeError;
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_runtime::team::{self, Medium, Options, Run};
use dragnet_scenario::Scenario;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules};

use crate::{committed, scenario};

/// The episode in this process, with a coordinator that records nothing.
fn in_process(scenario: &Scenario, seed: u64) -> Episode {
    let mut robots: Vec<Agent> = AgentConfig::of_team(scenario, seed).into_iter().map(Agent::new).collect();
    let mut node = CoordinatorNode::new(Mission::new(CoordinatorConfig::of(scenario)), None);
    let rules = Rules { end: End::Resting, coordinator: Membership::Present };
    let mut participants = LocalParticipants::new(&mut robots, Some(&mut node));
    episode::run_with(scenario, seed, rules, &mut participants, &mut |_, _| ()).unwrap()
}

fn over_zenoh(scenario: &Scenario, seed: u64, recording: Option<PathBuf>) -> Run {
    let options = Options { recording, version: "test".to_owned(), ..Options::default() };
    team::run(scenario, seed, &options, &mut |_, _| ()).unwrap()
}

fn check_equal(run: &Run, local: &Episode) {
    assert_eq!(run.episode.path_cells, local.path_cells);
    assert_eq!(run.episode.outcome.digest, local.outcome.digest);
    assert_eq!(run.episode.outcome.ended, local.outcome.ended);
    assert_eq!(run.episode.outcome.f1, local.outcome.f1);
    assert_eq!(run.episode.outcome.network, local.outcome.network);
    assert!(run.episode.outcome.beliefs_equal);
    assert_eq!(run.observations_merged, run.episode.outcome.observations);
}

#[test]
fn a_run_over_zenoh_is_the_run_in_one_process() {
    let cone = committed("ice_cream_cone.toml");
    for seed in 0..3 {
        check_equal(&over_zenoh(&cone, seed, None), &in_process(&cone, seed));
    }
}

#[test]
fn so_it_is_on_a_network_with_every_fault() {
    let faults = committed("faults.toml");
    let run = over_zenoh(&faults, 1, None);
    check_equal(&run, &in_process(&faults, 1));
    let tally = run.episode.outcome.network;
    assert!(tally.lost > 0 && tally.cut > 0 && tally.duplicated > 0 && tally.reordered > 0, "{tally:?}");
}

#[test]
fn two_runs_side_by_side_do_not_meet_and_record_the_same_bytes() {
    let cone = committed("ice_cream_cone.toml");
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str| {
        let path = folder.path().join(name);
        over_zenoh(&cone, 5, Some(path.clone()));
        std::fs::read(path).unwrap()
    };
    let (first, second) = std::thread::scope(|scope| {
        let first = scope.spawn(|| record("a.mcap"));
        let second = scope.spawn(|| record("b.mcap"));
        (first.join().unwrap(), second.join().unwrap())
    });
    assert!(first.len() > 10_000);
    assert!(first == second, "recordings of {} and {} bytes differ", first.len(), second.len());
}

/// The bytes that a run in memory records.
fn recorded_in_memory(scenario: &Scenario, seed: u64, threads: usize) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("memory.mcap");
    let version = "test".to_owned();
    let options = Options {
        medium: Medium::Memory,
        threads,
        recording: Some(recording.clone()),
        version,
        ..Options::default()
    };
    let run = team::run(scenario, seed, &options, &mut |_, _| ()).unwrap();
    assert!(run.episode.outcome.beliefs_equal);
    assert_eq!(run.observations_merged, run.episode.outcome.observations);
    std::fs::read(recording).unwrap()
}

#[test]
fn a_run_in_memory_records_the_bytes_of_one_over_zenoh() {
    let folder = tempfile::tempdir().unwrap();
    for (name, robots) in [("ice_cream_cone.toml", 3), ("faults.toml", 4)] {
        let scenario = committed(name).with_robots(robots).unwrap();
        let path = folder.path().join(name);
        over_zenoh(&scenario, 5, Some(path.clone()));
        let (zenoh, memory) = (std::fs::read(path).unwrap(), recorded_in_memory(&scenario, 5, 0));
        assert!(
            zenoh.len() > 10_000 && zenoh == memory,
            "{name}: {} and {} bytes",
            zenoh.len(),
            memory.len()
        );
    }
}

#[test]
fn a_large_team_records_the_same_bytes_whatever_the_number_of_threads() {
    let large = scenario(
        "name = \"large\"\n[map]\nshape = \"all_traversable\"\nrows = 40\ncolumns = 40\n\
         [objects]\ndensity = 0.01\n[robots]\ncount = 100\nstart = \"scattered\"\n\
         [mission]\nbudget_seconds = 60.0\n[network]\nloss = 0.1\ndelay_seconds = 0.05\n",
    );
    let [alone, again, together] = [1, 1, 2].map(|threads| recorded_in_memory(&large, 5, threads));
    assert!(alone.len() > 100_000);
    assert!(alone == again && alone == together);
}

#[test]
fn robots_as_processes_and_the_wall_clock_are_refused_in_memory() {
    let memory = Options { medium: Medium::Memory, ..Options::default() };
    for options in [
        Options { real_time_factor: Some(10.0), ..memory.clone() },
        Options { processes: Some("dragnet".into()), ..memory },
    ] {
        let error = team::run(&committed("ice_cream_cone.toml"), 1, &options, &mut |_, _| ()).unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains("Zenoh"), "{error}");
    }
}

#[test]
fn by_the_wall_clock_the_team_finds_all_and_agrees() {
    let small = scenario(
        "name = \"live\"\n[map]\nshape = \"all_traversable\"\nrows = 15\ncolumns = 15\n\
         [objects]\ncount = 4\n[robots]\ncount = 2\npolicy = \"path\"\n[mission]\nbudget_seconds = 1e6\nstop_when_expected_remaining = 0.001\n",
    );
    // It ends when all is found, not after some time: a slow computer only takes longer.
    let options = Options { real_time_factor: Some(300.0), version: "test".to_owned(), ..Options::default() };
    let run = team::run(&small, 3, &options, &mut |_, _| ()).unwrap();
    assert!(run.episode.outcome.beliefs_equal);
    assert!((run.episode.score.recall() - 1.0).abs() < 1e-12, "{:?}", run.episode.score);
    assert!(!run.episode.outcome.decisions.is_empty());
    assert_eq!(run.observations_merged, run.episode.outcome.observations);
}

#[test]
fn faults_by_the_wall_clock_are_rejected() {
    let options = Options { real_time_factor: Some(10.0), ..Options::default() };
    let error = team::run(&committed("faults.toml"), 1, &options, &mut |_, _| ()).unwrap_err();
    assert!(error.is_bad_input());
    assert!(error.to_string().contains("[network]"), "{error}");
}

#[test]
fn a_port_in_use_and_settings_that_are_none_are_named() {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let open = |endpoints: &Endpoints| runtime.block_on(open(endpoints)).unwrap_err().to_string();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = vec![format!("tcp/{}", taken.local_addr().unwrap())];
    let message = open(&Endpoints { listen: listen.clone(), ..Endpoints::default() });
    assert!(message.contains(&listen[0]), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("zenoh.json5");
    std::fs::write(&config, "{ scouting: { multicast: { enabeld: false } } }").unwrap();
    let message = open(&Endpoints { config: Some(config), ..Endpoints::default() });
    assert!(message.contains("zenoh.json5") && message.contains("enabeld"), "{message}");
}

#[test]
fn a_recording_that_cannot_be_written_stops_the_run_before_it_starts() {
    let options =
        Options { recording: Some(Path::new("/no/such/folder/a.mcap").to_owned()), ..Options::default() };
    let error = team::run(&committed("ice_cream_cone.toml"), 1, &options, &mut |_, _| ()).unwrap_err();
    assert!(matches!(error, RuntimeError::Recording(_)) && error.is_bad_input());
    assert!(error.to_string().contains("/no/such/folder/a.mcap"), "{error}");
}

#[test]
fn free_endpoints_are_distinct_and_on_loopback() {
    // A process that has found ports and not used them yet does not find them again.
    let mut endpoints = [free_endpoints(10).unwrap(), free_endpoints(10).unwrap()].concat();
    assert!(endpoints.iter().all(|endpoint| endpoint.starts_with("tcp/127.0.0.1:")));
    endpoints.sort();
    endpoints.dedup();
    assert_eq!(endpoints.len(), 20);
}

/// A participant outside the team that sends invalid messages.
mod stranger {
    use dragnet_proto::convert::{self, Codec};
    use dragnet_proto::message::{Audience, Intent, Message};
    use dragnet_proto::sender::Envelope;
    use dragnet_runtime::link::{Incoming, Link};
    use dragnet_scenario::participant::Participant;
    use dragnet_search::cell::Grid;
    use dragnet_search::observation::RobotId;

    use super::{Duration, Endpoints, free_endpoints, open};

    fn robot(number: u16) -> Participant {
        Participant::Robot(RobotId::new(number).unwrap())
    }

    async fn next_message(link: &mut Link) -> Incoming {
        loop {
            let received =
                tokio::time::timeout(Duration::from_secs(20), link.receive()).await.unwrap().unwrap();
            if !matches!(received, Incoming::Came(..) | Incoming::Left(..)) {
                return received;
            }
        }
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn is_rejected_by_name_and_the_honest_are_received() {
        let listen = free_endpoints(1).unwrap();
        let (mission, codec) = ("m".parse().unwrap(), Codec::new(Grid::new(3, 3).unwrap()));
        let endpoints = Endpoints { listen: listen.clone(), ..Endpoints::default() };
        let mut ear =
            Link::join(open(&endpoints).await.unwrap(), mission, robot(1), codec.clone()).await.unwrap();
        ear.announce().await.unwrap();
        let endpoints = Endpoints { connect: listen, ..Endpoints::default() };
        let session = open(&endpoints).await.unwrap();
        let mut mouth = Link::join(session.clone(), "m".parse().unwrap(), robot(2), codec).await.unwrap();
        mouth.wait_for(&[robot(1)], Duration::from_secs(20), |_| ()).await.unwrap();

        let intent = Intent {
            robot: RobotId::new(2).unwrap(),
            incarnation: 0,
            decision: 1,
            time_ns: 0,
            path: Vec::new().into(),
        };
        let honest = Message::Intent(intent.clone());
        let number = Envelope { number: 7, identity: 5 }.encode();
        session
            .put("dragnet/m/robots/2/observation", vec![1, 2, 3])
            .attachment(number.clone())
            .await
            .unwrap();
        session.put("dragnet/m/robots/3/intent", convert::encode(&honest)).attachment(number).await.unwrap();
        session.put("dragnet/m/robots/2/intent", convert::encode(&honest)).await.unwrap();
        mouth.publish(8, Audience::All, &honest).await.unwrap();

        // Messages of different senders have no order.
        let mut refused = Vec::new();
        for _ in 0..4 {
            match next_message(&mut ear).await {
                Incoming::Rejected { key, .. } => refused.push(key),
                Incoming::Message { from, number, message, .. } => {
                    assert_eq!((from, number, message), (robot(2), 8, honest.clone()));
                }
                received => panic!("{received:?}"),
            }
        }
        refused.sort();
        let places = ["robots/2/intent", "robots/2/observation", "robots/3/intent"];
        assert_eq!(refused, places.map(|place| format!("dragnet/m/{place}")));
    }
}
