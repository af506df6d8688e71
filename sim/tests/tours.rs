//! Teams of tours under message loss and without one of their robots.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;

use dragnet_agent::agent::Agent;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::faults::{Crash, Faults};
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules};

/// Robots that leave one cell.
fn team(robots: u32, policy: &str, loss: f64) -> Scenario {
    let text = format!(
        "name = \"tours\"\n[map]\nshape = \"all_traversable\"\nrows = 30\ncolumns = 30\n\
         [objects]\ndensity = 0.01\n[robots]\ncount = {robots}\npolicy = {policy}\n\
         [mission]\nbudget_meters = 20000.0\n[network]\nloss = {loss:?}\n"
    );
    Scenario::from_text(Path::new("tours.toml"), text).unwrap()
}

const TOUR: &str = "{ name = \"tour\", evaluations = 200 }";

fn search(team: &Scenario, seed: u64, end: End, faults: Faults) -> Episode {
    let mut robots = episode::team(team, seed, Agent::new);
    let mut participants = LocalParticipants::new(&mut robots, None);
    let rules = Rules { end, coordinator: Membership::Absent };
    episode::run_with_faults(team, seed, rules, faults, &mut participants, &mut |_, _| ()).unwrap()
}

/// Path length of the farthest robot until all was found, a mean over the searches that found all.
fn mean_cells(team: &Scenario) -> f64 {
    let cells = |seed| search(team, seed, End::AllFound, Faults::default()).outcome.cells_to_full_recall;
    let cells: Vec<f64> = (0..12).filter_map(cells).collect();
    assert!(cells.len() >= 10, "{} of 12 found all", cells.len());
    cells.iter().sum::<f64>() / cells.len() as f64
}

#[test]
fn four_robots_divide_the_search_although_half_of_all_messages_are_lost() {
    let alone = mean_cells(&team(1, TOUR, 0.0));
    let (four, lossy) = (mean_cells(&team(4, TOUR, 0.0)), mean_cells(&team(4, TOUR, 0.5)));
    println!("one {alone}, four {four}, with half of all messages lost {lossy}");
    assert!(four < alone / 3.0 && lossy < alone / 2.8, "{alone}, {four}, {lossy}");
}

#[test]
fn searches_end_although_half_is_lost_or_a_robot_dies() {
    for seed in 0..4 {
        for loss in [0.0, 0.5] {
            let lost = Participant::Robot(RobotId::new(2).unwrap());
            let crash = Crash { at: MissionTime(100_000_000_000), back: None };
            let faults = Faults { crashes: [(lost, crash)].into(), ..Faults::default() };
            let scenario = team(3, TOUR, loss);
            let episode = search(&scenario, seed, End::Resting, faults);
            assert!(episode.outcome.beliefs_equal, "{seed}");
            assert!(episode.expected_remaining < 0.1, "{seed}: {} remain", episode.expected_remaining);
            assert!(episode.path_cells.iter().all(|&cells| cells < 400.0), "{:?}", episode.path_cells);
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_search() {
    let lossy = team(4, TOUR, 0.5);
    let run = |seed| {
        let episode = search(&lossy, seed, End::AllFound, Faults::default());
        (episode.outcome.digest, episode.outcome.ended, episode.path_cells)
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3).0, run(4).0);
}

/// A robot that stands at the only stop of the lanes has no lane to drive.
#[test]
fn a_team_in_a_room_that_one_cell_overlooks_searches_it() {
    for seed in 0..30 {
        let text = format!(
            "name = \"room\"\n[map]\nshape = \"all_traversable\"\nrows = 2\ncolumns = 5\n\
             [sensor]\nradius = 3\nnoise_variance = 0.2\n[objects]\ncount = 1\n\
             [robots]\ncount = 2\npolicy = {TOUR}\n[mission]\nbudget_meters = 20000.0\n"
        );
        let room = Scenario::from_text(Path::new("room.toml"), text).unwrap();
        let episode = search(&room, seed, End::Resting, Faults::default());
        assert!(episode.expected_remaining < 0.1, "{seed}: {} remain", episode.expected_remaining);
    }
}
