//! Teams of unlike robots: a drone sees what no rover can, sooner, and all believe the same.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use dragnet_scenario::Scenario;
use dragnet_search::cell::Position;
use dragnet_search::policy::PolicyName;

mod resting;

use resting::search;

/// A yard behind walls that a rover's sensor does not see into, with an object in its middle.
const MAP: &str = "\
............
....#######.
....#.....#.
....#.....#.
....#.....#.
....#.....#.
....#.....#.
....#######.
............
";

fn scenario(rest: &str) -> Scenario {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("yard.txt"), MAP).unwrap();
    let text = format!(
        "name = 'yard'\nmap = {{ file = 'yard.txt', cell_meters = 10.0 }}\nsensor.radius = 2\n\
         objects = {{ cells = [[4, 7], [8, 0]] }}\n\
         mission = {{ budget_seconds = 1800.0, stop_when_expected_remaining = 0.001 }}\n\
         [robots]\ncount = 2\nstart = [0, 0]\n{rest}"
    );
    Scenario::from_text(&folder.path().join("yard.toml"), text).unwrap()
}

const DRONE: &str = "robot = [{ number = 2, class = 'drone' }]\n[classes.drone]\nflies = true\n\
                     speed_meters_per_second = 6.0\nsensor = { radius = 3, noise_variance = 0.01 }\n";

#[test]
fn a_drone_finds_what_rovers_cannot_reach_and_everybody_believes_it() {
    let (rovers, mixed) = (scenario(""), scenario(DRONE));
    assert!(
        rovers.warnings().iter().any(|warning| warning.to_string().contains("out of every robot's sight"))
    );
    assert!(mixed.warnings().is_empty(), "{:?}", mixed.warnings());
    let yard = mixed.terrain().grid().cell(Position { row: 4, column: 7 }).unwrap();
    for policy in
        [PolicyName::Path, PolicyName::Tour, PolicyName::Greedy, PolicyName::Coverage, PolicyName::Nats]
    {
        let mixed = mixed.with_policy(policy).unwrap();
        for seed in 0..5 {
            let (episode, robots) = search(&mixed, seed);
            assert!(episode.outcome.beliefs_equal, "{policy} {seed}");
            assert!(robots.iter().all(|robot| robot.is_found(yard)), "{policy} {seed}");
            let (_, robots) = search(&rovers, seed);
            assert!(robots.iter().all(|robot| !robot.is_found(yard)), "{policy} {seed}");
        }
    }
}

#[test]
fn each_robot_goes_at_the_speed_of_its_class() {
    let slow = DRONE.replace("6.0", "0.5");
    let ways = [DRONE, slow.as_str()].map(|classes| {
        let (episode, _) = search(&scenario(classes), 1);
        let [rover, drone] = episode.path_cells[..] else { panic!("two robots") };
        let seconds = episode.outcome.ended.as_seconds();
        let of_class = if classes == DRONE { 6.0 } else { 0.5 };
        assert!(rover * 10.0 <= 2.0 * seconds + 10.0, "{rover} cells in {seconds} s");
        assert!(drone * 10.0 <= of_class * seconds + 10.0, "{drone} cells in {seconds} s");
        (rover, drone)
    });
    assert!(ways[0].1 > ways[0].0, "the fast one goes farther: {ways:?}");
    assert!(ways[1].1 < ways[1].0, "the slow one does not: {ways:?}");
}

#[test]
fn a_class_has_a_budget_of_its_own() {
    let (episode, _) = search(&scenario(&format!("{DRONE}budget_meters = 50.0\n")), 3);
    let [rover, drone] = episode.path_cells[..] else { panic!("two robots") };
    assert!(drone <= 6.5 && rover > 6.5, "{rover} {drone}");
}
