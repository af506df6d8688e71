use std::fs;
use std::time::Duration;

use dragnet_learn::policy::PolicyName;
use dragnet_search::cell::Position;
use dragnet_search::observation::RobotId;
use dragnet_search::policy::{AfterPattern, Parameters, Pattern, PolicyName as Exact};
use dragnet_search::utility::Utility;
use proptest::prelude::*;

use super::*;
use crate::mentions::assert_mentions;

/// A scenario on `maps/a.txt`, which is the drawing.
const SMALL: &str = "name = 'small'
[map]
file = 'a.txt'
[sensor]
radius = 1
[objects]
count = 1
[mission]
budget_meters = 300
";
const DRAWING: &str = "...#\n.,.~\n";

fn load_with(text: &str, drawing: &str) -> Result<Scenario, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.txt"), drawing).unwrap();
    fs::write(folder.path().join("low.csv"), "0,0,0,0.5\n0,0.5,0,0\n").unwrap();
    fs::write(folder.path().join("zenoh.json5"), "{}").unwrap();
    let file = folder.path().join("a.toml");
    fs::write(&file, text).unwrap();
    Scenario::load(&file).map_err(|error| error.to_string())
}

fn load(text: &str) -> Result<Scenario, String> {
    load_with(text, DRAWING)
}

fn small(change: impl Fn(&str) -> String) -> Scenario {
    load(&change(SMALL)).unwrap()
}

/// A policy with default parameters.
fn plain(name: Exact) -> Policy {
    PolicyName::from(name).into()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

#[test]
fn a_budget_of_path_length_precedes_one_of_time() {
    let cells = |mission: &str| {
        let text = format!(
            "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 5, columns = 5, cell_meters = 0.7 }}\n\
             sensor.radius = 2\nobjects.count = 1\n[mission]\nspeed_meters_per_second = 1.4\n{mission}"
        );
        Scenario::from_text(Path::new("a.toml"), text).unwrap()
    };
    assert!(close(cells("budget_meters = 7.0\nbudget_seconds = 100.0\n").budget_cells(), 10.0));
    let time = cells("budget_seconds = 100.0\n");
    assert!(close(time.budget_cells(), 200.0));
    assert!(close(time.with_budget_cells(90).unwrap().budget_cells(), 90.0));
}

#[test]
fn missing_keys_have_their_defaults() {
    let scenario = load(&SMALL.replace("[sensor]\nradius = 1\n", "").replace("...#\n", "")).unwrap_err();
    assert_mentions(&scenario, "sensor.radius .. 5 .. 1 to 4");
    let scenario = small(str::to_owned);
    assert_eq!(scenario.connectivity(), Connectivity::Four);
    assert!(close(scenario.terrain().cell_meters(), 30.0));
    let mission = scenario.mission();
    assert!(close(mission.detection_threshold, 0.95) && close(mission.speed_meters_per_second, 2.0));
    assert_eq!(mission.stop_when_expected_remaining, Some(0.05));
    assert_eq!((mission.budget.meters(), mission.budget.time()), (Some(300.0), None));
    assert_eq!((mission.heartbeat.as_secs(), mission.lost_after.as_secs()), (10, 30));
    assert_eq!(mission.stagger, Duration::from_millis(100));
    assert_eq!(scenario.network(), &Network::default());
    let [robot] = scenario.robots() else { panic!("{:?}", scenario.robots()) };
    assert_eq!(
        (robot.id, &robot.policy, robot.start),
        (RobotId::FIRST, &plain(Exact::Path), Start::Together { area: 0 })
    );
    assert_eq!(scenario.only_class(), Some(&*robot.class));
    assert_eq!((&*robot.class.sensor, robot.class.flies), (scenario.sensor(), false));
    assert_eq!(scenario.recording(), &Recording { file: None, belief_period: Duration::from_secs(10) });
}

#[test]
fn robots_of_a_class_differ_in_what_it_gives() {
    let scenario = small(|text| {
        format!(
            "{text}[robots]\ncount = 3\nclass = 'rover'\n[[robots.robot]]\nnumber = 2\nclass = 'drone'\n\
             [classes.drone]\nspeed_meters_per_second = 6.0\nbudget_seconds = 900.0\nflies = true\n\
             sensor = {{ radius = 3, noise_variance = 0.02 }}\n[classes.rover.sensor]\nradius = 1\n"
        )
    });
    let [rover, drone, other] = scenario.robots() else { panic!("{:?}", scenario.robots()) };
    assert_eq!((rover.class.name.as_deref(), drone.class.name.as_deref()), (Some("rover"), Some("drone")));
    assert_eq!((&rover.class, scenario.only_class()), (&other.class, None));
    let of = |robot: &Robot| {
        let Class { sensor, speed_meters_per_second, budget, flies, .. } = &*robot.class;
        let budget = (budget.meters(), budget.time().map(|time| time.as_secs()));
        (sensor.radius(), sensor.noise_variance(), *speed_meters_per_second, budget, *flies)
    };
    assert_eq!(of(rover), (1, scenario.sensor().noise_variance(), 2.0, (Some(300.0), None), false));
    assert_eq!(of(drone), (3, 0.02, 6.0, (Some(300.0), Some(900)), true));
    let all = scenario.with_budget_cells(20).unwrap();
    assert_eq!(of(&all.robots()[1]).3, (Some(600.0), None), "a budget of all robots replaces every other");
    let text = toml::to_string(scenario.file()).unwrap();
    assert_eq!(load(&text).unwrap().robots(), scenario.robots());
}

#[test]
fn a_reserve_is_left_out_of_what_robots_plan_with_if_they_return() {
    let of =
        |rest: &str| load(&SMALL.replace("budget_meters = 300", &format!("budget_meters = 300\n{rest}")));
    let left = |rest: &str, path_meters: f64| {
        of(rest).unwrap().mission().remaining_meters(path_meters, Duration::from_secs(10)).to_string()
    };
    assert_eq!(left("", 100.0), "200");
    assert_eq!(left("budget_reserve = 0.5", 100.0), "200", "it may end anywhere");
    assert_eq!(left("return_to_base = true", 100.0), "170");
    assert_eq!(left("return_to_base = true\nbudget_reserve = 0.5", 100.0), "50");
    assert_eq!(left("return_to_base = true\nbudget_reserve = 0.5", 200.0), "0");
    assert_eq!(left("return_to_base = true\nbudget_reserve = 0\nbudget_seconds = 15", 0.0), "10");
    for (rest, found) in [
        ("budget_reserve = 1", "is 1"),
        ("budget_reserve = -0.1", "is -0.1"),
        ("budget_reserve = nan", "is NaN"),
    ] {
        let error = of(rest).unwrap_err();
        assert!(
            error.contains("mission.budget_reserve") && error.contains(found) && error.contains("below 1"),
            "{error}"
        );
    }
}

#[test]
fn classes_that_make_no_sense_are_refused() {
    let check = |text: &str, parts: &[&str]| {
        let error = load(&format!("{SMALL}{text}")).unwrap_err();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    };
    check("[robots]\nclass = 'drone'", &["robots.class is \"drone\"", "has none", "[classes.NAME]"]);
    check(
        "[robots]\ncount = 2\nrobot = [{ number = 1, class = 'boat' }]\n[classes.drone]\n[classes.rover]\n",
        &["robots.robot[0].class is \"boat\"", "drone, rover"],
    );
    check("[classes.'a b']\n", &["the name of classes.a b", "letters, digits"]);
    check("[classes.a]\nsensor.radius = 0\n", &["classes.a.sensor.radius is 0"]);
    check("[classes.a]\nsensor.noise_variance = -1\n", &["classes.a.sensor.noise_variance is -1"]);
    check("[classes.a]\nspeed_meters_per_second = nan\n", &["classes.a.speed_meters_per_second is NaN"]);
    check("[classes.a]\nbudget_seconds = 0\n", &["classes.a.budget_seconds is 0"]);
    check("[classes.a]\nradius = 3\n", &["radius", "unknown"]);
    check(
        "[classes.a]\nspeed_meters_per_second = 0.001\n",
        &["mission.heartbeat_seconds", "classes.a.speed_meters_per_second"],
    );
}

#[test]
fn robots_differ_as_the_scenario_specifies() {
    let scenario = small(|text| {
        format!(
            "{text}[robots]\ncount = 3\nstart = [0, 0]\n\
             [[robots.robot]]\nnumber = 3\npolicy = {{ name = 'coverage', lane_spacing_cells = 2, pattern = 'sector', after_pattern = 'path', replan_after_cells = 4 }}\nstart = 'scattered'\n\
             [[robots.robot]]\nnumber = 2\npolicy = {{ name = 'greedy', utility = 'recall' }}\n"
        )
    });
    let cell = scenario.terrain().grid().cell(Position { row: 0, column: 0 }).unwrap();
    let robots = scenario.robots();
    assert_eq!((&robots[0].policy, robots[0].start), (&plain(Exact::Path), Start::Cell(cell)));
    let greedy = &robots[1].policy;
    assert_eq!((greedy.name, greedy.parameters.utility), (Exact::Greedy.into(), Utility::Recall));
    assert_eq!(robots[1].start, Start::Cell(cell));
    assert_eq!((robots[2].id, robots[2].start), (RobotId::new(3).unwrap(), Start::Scattered));
    let Parameters { lane_spacing_cells, pattern, after_pattern, .. } = robots[2].policy.parameters;
    assert_eq!((lane_spacing_cells, pattern, after_pattern), (Some(2), Pattern::Sector, AfterPattern::Path));
    assert_eq!(robots[2].policy.replan_after_cells.unwrap().get(), 4);
}

#[test]
fn the_prior_is_the_expected_density_unless_it_is_given() {
    // Six of the eight cells are searched, the first in the south-west.
    let of = |change: &dyn Fn(&str) -> String| {
        let scenario = small(change);
        let first = scenario.terrain().searched_cells().next().unwrap();
        scenario.prior().probability(first)
    };
    assert!(close(of(&str::to_owned), 1.0 / 6.0));
    assert!(close(of(&|text| text.replace("count = 1", "count = 0")), 0.5 / 6.0));
    assert!(close(of(&|text| text.replace("count = 1", "count = 6")), 5.5 / 6.0));
    assert!(close(of(&|text| text.replace("count = 1", "density = 0.3")), 0.3));
    assert!(close(of(&|text| text.replace("count = 1", "cells = [[1, 0], [0, 0]]")), 2.0 / 6.0));
    assert!(close(of(&|text| format!("{text}[prior]\nprobability = 0.01\n")), 0.01));
    let error = load(&format!("{SMALL}[prior]\nfile = 'low.csv'\n")).unwrap_err();
    assert_mentions(&error, "prior.file .. 0");
}

/// Replaces a part of [`SMALL`], or adds to its end.
fn check(from: &str, to: &str, said: &[&str]) {
    let text = if from.is_empty() { format!("{SMALL}{to}\n") } else { SMALL.replace(from, to) };
    let error = load(&text).unwrap_err();
    assert!(error.contains("a.toml, line ") && said.iter().all(|it| error.contains(it)), "{error}\n{text}");
}

#[test]
fn a_keep_out_mask_lies_beside_a_ros_map() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let header =
        "resolution: 30\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\nimage:";
    for (name, pixels) in [("map", "255 255 255  255 255 255"), ("mask", "255 0 255  255 255 255")] {
        write(&format!("{name}.yaml"), &format!("{header} {name}.pgm\n"));
        write(&format!("{name}.pgm"), &format!("P2 3 2 255  {pixels}\n"));
    }
    let read = |mask: &str| {
        let text = SMALL.replace("file = 'a.txt'", &format!("file = 'map.yaml'\nkeepout = '{mask}'"));
        Scenario::from_text(&folder.path().join("a.toml"), text)
    };
    let expected = Terrain::from_ascii(".~.\n...", 30.0).unwrap();
    assert!(read("mask.yaml").unwrap().terrain().is_equal_ground(&expected));
    assert_mentions(
        &read("gone.yaml").unwrap_err().to_string(),
        "a.toml, line 4: .. gone.yaml: No such file",
    );
}

#[test]
fn a_map_or_a_sensor_out_of_range_names_line_value_and_range() {
    check("'small'", "'a b'", &["line 1: name is \"a b\"", "1 to 64 letters, digits, '_' and '-'"]);
    check("file = 'a.txt'", "shape = 'cone'", &["line 3: map.shape is \"cone\"", "ice_cream_cone, open_"]);
    check("file = 'a.txt'", "shape = 'open_asterisk'", &["line 2: map.rows is missing", "a number of cells"]);
    check("file = 'a.txt'", "", &["line 2: map is without shape or file", "exactly one"]);
    check("file = 'a.txt'", "file = 'a.txt'\nshape = 'x'", &["map is shape and file", "exactly one"]);
    check(
        "file = 'a.txt'",
        "file = 'a.txt'\nrows = 3",
        &["line 4: map.rows is 3", "no such key beside map.file"],
    );
    check(
        "file = 'a.txt'",
        "shape = 'all_traversable'\nrows = 9999\ncolumns = 9999",
        &["line 2: map is 9999 x 9999 cells", "1 to 16777216 cells"],
    );
    check(
        "file = 'a.txt'",
        "file = 'a.txt'\nkeepout = 'mask.yaml'",
        &["line 4: map.keepout is given", "beside a ROS map (.yaml)"],
    );
    check("file = 'a.txt'", "file = 'b.txt'", &["line 3: "]);
    check("file = 'a.txt'", "file = 'b.txt'", &["b.txt: No such file"]);
    check("file = 'a.txt'", "file = 'a.txt'\nconnectivity = 6", &["line 4: map.connectivity is 6", "4 or 8"]);
    check("file = 'a.txt'", "file = 'a.txt'\ncell_meters = 0", &["map.cell_meters is 0", "from 0.001"]);
    check("file = 'a.txt'", "file = 'a.txt'\ncell_meters = nan", &["map.cell_meters is NaN"]);
    check("radius = 1", "radius = 0", &["line 5: sensor.radius is 0", "1 to 4"]);
    check("radius = 1", "radius = 5", &["sensor.radius is 5"]);
    check("radius = 1", "noise_variance = -1", &["sensor.radius is 5"]);
    check(
        "radius = 1",
        "radius = 1\nnoise_variance = inf",
        &["line 6: sensor.noise_variance is inf", "0.000005 to 10000.000"],
    );
    check(
        "radius = 1",
        "radius = 1\nnoise = 'pink'",
        &["sensor.noise is \"pink\"", "\"gaussian\" or \"clipped\""],
    );
}

#[test]
fn walls_hide_from_robots_on_the_ground_if_the_sensor_needs_a_line_of_sight() {
    let hides = |line: &str| {
        let scenario =
            load_with(&SMALL.replace("radius = 1", &format!("radius = 4\n{line}")), "..#..").unwrap();
        let grid = scenario.terrain().grid();
        let [west, east] = [0, 4].map(|number| grid.cell_numbered(number).unwrap());
        scenario.terrain().line_of_sight().hides(west, grid.offset(west, east))
    };
    assert!(hides("line_of_sight = true") && !hides("line_of_sight = false") && !hides(""));
    let large = "name = 'large'\nmap = { shape = 'all_traversable', rows = 100, columns = 100 }\n\
                 sensor = { radius = 100, line_of_sight = true }\nobjects.count = 1\n\
                 mission.budget_seconds = 60.0\n";
    let error = load(large).unwrap_err();
    let expected =
        "line 3: sensor.line_of_sight is true on a map of 10000 cells with a radius of 100; allowed";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn objects_or_a_mission_out_of_range_name_line_value_and_range() {
    check("count = 1", "", &["line 6: objects is 0 of them", "exactly one of count, density and cells"]);
    check("count = 1", "count = 1\ndensity = 0.1", &["objects is 2 of them"]);
    check("count = 1", "count = 7", &["line 7: objects.count is 7", "0 to 6"]);
    check("count = 1", "count = -1", &["objects.count is -1"]);
    check("count = 1", "density = 1", &["objects.density is 1", "above 0 and below 1"]);
    check("count = 1", "density = nan", &["objects.density is NaN"]);
    check(
        "count = 1",
        "cells = [[0, 0], [2, 0]]",
        &["objects.cells[1] is [2, 0]", "[row, column] from [0, 0] to [1, 3]"],
    );
    check("count = 1", "cells = [[1, 3]]", &["objects.cells[0] is [1, 3], not searched", "a searched cell"]);
    check(
        "count = 1",
        "cells = [\n[0, 0],\n[0, 0]]",
        &["line 9: objects.cells[1] is [0, 0], again", "each cell once"],
    );
    check(
        "budget_meters = 300",
        "",
        &["line 8: mission is without a budget", "mission.budget_meters, mission.budget_seconds"],
    );
    check("budget_meters = 300", "budget_meters = inf", &["line 9: mission.budget_meters is inf", "above 0"]);
    check("", "budget_seconds = -3", &["line 10: mission.budget_seconds is -3"]);
    check("", "detection_threshold = 0.5", &["mission.detection_threshold is 0.5", "above 0.5 and below 1"]);
    check("", "detection_threshold = nan", &["mission.detection_threshold is NaN"]);
    check("", "speed_meters_per_second = 0", &["mission.speed_meters_per_second is 0", "from 0.001"]);
    check(
        "",
        "stop_when_expected_remaining = -0.1",
        &["mission.stop_when_expected_remaining is -0.1", "from 0"],
    );
    check(
        "",
        "heartbeat_seconds = 30",
        &["mission.liveness_timeout_seconds is 30", "above mission.heartbeat_seconds, 30"],
    );
    check("", "start_stagger_seconds = nan", &["mission.start_stagger_seconds is NaN", "from 0"]);
    check("", "[prior]\nprobability = 1", &["prior.probability is 1", "above 0 and below 1"]);
    check(
        "",
        "[prior]\nprobability = 0.96",
        &["prior is 0.96 in cell [0, 0]", "below mission.detection_threshold, 0.95"],
    );
    check("", "[prior]\nprobability = 0.1\nfile = 'low.csv'", &["prior is probability and file"]);
    check("", "[prior]\nfile = 'a.txt'", &["line 11: "]);
    check("", "[recording]\nbelief_period_seconds = 0", &["recording.belief_period_seconds is 0"]);
    check("", "[zenoh]\nconfig = 'no.json5'", &["no.json5, no such file", "a JSON5 file, relative"]);
}

#[test]
fn a_robot_or_a_network_out_of_range_names_line_value_and_range() {
    let check = |added: &str, said: &[&str]| {
        let error = load(&format!("{SMALL}{added}\n")).unwrap_err();
        assert!(
            error.contains("a.toml, line ") && said.iter().all(|it| error.contains(it)),
            "{error}\n{added}"
        );
    };
    check("[robots]\ncount = 0", &["line 11: robots.count is 0", "1 to 1000"]);
    check("[robots]\ncount = 1001", &["robots.count is 1001"]);
    check(
        "[robots]\npolicy = 'astar'",
        &[
            "robots.policy is \"astar\"",
            "random, coverage, greedy, path-additive, path, tour, nats, guts, gnn, gnn-greedy",
        ],
    );
    check(
        "[robots]\npolicy = {name = 'path', evaluations = 9}",
        &["robots.policy.evaluations is 9 for path", "a value for tour only"],
    );
    check(
        "[robots]\npolicy = {name = 'tour', evaluations = 1000000000}",
        &["robots.policy.evaluations is 1000000000", "0 to 1000000"],
    );
    check("[robots.policy]\nname = 'astar'", &["line 11: robots.policy.name is \"astar\""]);
    check(
        "[robots]\npolicy = {name = 'path', path_length_weight = nan}",
        &["robots.policy.path_length_weight is NaN"],
    );
    check(
        "[robots]\npolicy = {name = 'path', lane_spacing_cells = 2}",
        &["robots.policy.lane_spacing_cells is 2 for path", "coverage only"],
    );
    check(
        "[robots]\npolicy = {name = 'path', utility = 'speed'}",
        &["robots.policy.utility is \"speed\"", "information, recall"],
    );
    check(
        "[robots]\npolicy = {name = 'tour', utility = 'recall'}",
        &["robots.policy.utility is \"recall\" for tour", "greedy and path only"],
    );
    check(
        "[robots]\npolicy = {name = 'coverage', pattern = 'lawnmower'}",
        &[
            "robots.policy.pattern is \"lawnmower\"",
            "parallel_track, creeping_line, expanding_square, sector",
        ],
    );
    check(
        "[robots]\npolicy = {name = 'path', replan_after_cells = 0}",
        &["robots.policy.replan_after_cells is 0"],
    );
    check("[robots]\nstart = 'north'", &["robots.start is \"north\"", "\"random\", \"scattered\", a cell"]);
    check("[robots]\nstart = [1, 3]", &["robots.start is [1, 3], not traversable", "a traversable cell"]);
    let point = "{ latitude_degrees = 49.2, longitude_degrees = -2.1 }";
    check(
        &format!("[robots]\nstart = {point}"),
        &["robots.start is latitude 49.2, longitude -2.1", "the map is not georeferenced"],
    );
    check("[robots]\nstart = [0, 4]", &["robots.start is [0, 4]", "[row, column] from [0, 0] to [1, 3]"]);
    let robot = "[[robots.robot]]\nnumber = ";
    check(&format!("{robot}2"), &["line 11: robots.robot[0].number is 2", "1 to 1"]);
    check(
        &format!("{robot}1\n{robot}1"),
        &["line 13: robots.robot[1].number is 1, again", "each robot once"],
    );
    check("[network]\nloss = 1", &["line 11: network.loss is 1", "at least 0 and below 1"]);
    check("[network]\nduplication = -0.1", &["network.duplication is -0.1"]);
    check("[network]\ndelay_seconds = inf", &["network.delay_seconds is inf", "from 0"]);
    check("[network]\njitter_seconds = -1", &["network.jitter_seconds is -1"]);
    check("[network]\nreorder = 0.1", &["network.reorder_seconds is 0", "above 0 where network.reorder"]);
    let partition = "[[network.partitions]]\nto_seconds = 2\n";
    let check_partition = |added: &str, said: &[&str]| check(&format!("{partition}{added}"), said);
    check_partition(
        "from_seconds = 2\ngroups = [[1]]",
        &["network.partitions[0].to_seconds is 2", "above from_seconds, 2"],
    );
    check_partition(
        "from_seconds = 1\ngroups = []",
        &["network.partitions[0].groups is empty", "at least one"],
    );
    check_partition(
        "from_seconds = 1\ngroups = [[2]]",
        &["line 13: network.partitions[0].groups[0][0] is 2", "a robot from 1 to 1"],
    );
    check_partition("from_seconds = 1\ngroups = [['base']]", &["groups[0][0] is \"base\""]);
    check_partition("from_seconds = 1\ngroups = [[1], [1]]", &["groups[1][0] is 1", "each participant once"]);
}

#[test]
fn an_invalid_scenario_names_line_key_and_allowed_values() {
    let check = |from: &str, to: &str, messages: [&str; 2]| {
        let text = if from.is_empty() { format!("{SMALL}{to}\n") } else { SMALL.replace(from, to) };
        let error = load(&text).unwrap_err();
        for message in messages {
            assert_mentions(&error, message);
        }
    };
    check("name = 'small'", "name = ", ["a.toml, line 1: ", "string"]);
    check("name = 'small'\n", "", ["a.toml", "missing field `name`"]);
    check("radius = 1", "radus = 1", ["line 5: sensor", "`radus` .. `radius`"]);
    check("radius = 1", "radius = 1.5", ["line 5: sensor.radius: ", "`1.5` .. a whole number"]);
    check("", "[robot]\ncount = 3", ["line 10: ", "`robot` .. `name`"]);
    check("", "[robots]\npolicy = 3", ["line 11: robots.policy: ", "name .. table"]);
    check(
        "",
        "[robots]\npolicy = { name = 'tour', evaluations = 10.5 }",
        ["line 11: robots.policy.evaluations: ", "`10.5` .. a whole number"],
    );
    check(
        "",
        "[robots]\npolicy = { name = 'path', weight = 1 }",
        ["line 11: robots.policy", "`path_length_weight`"],
    );
    check("", "[robots]\nstart = [1]", ["line 11: robots.start: ", "a cell as [row, column]"]);
    check("", "[robots]\nstart = [1.0, 1]", ["line 11: robots.start: ", "a cell as [row, column]"]);
    check("", "[robots]\ncount = 1\ncount = 2", ["line 12: ", "count is given twice"]);
    check(
        "",
        "[[network.partitions]]\nfrom_seconds = 1",
        ["line 10: network.partitions[0]", "missing field"],
    );
}

#[test]
fn too_deep_long_or_large_values_are_reported_briefly() {
    let check = |line: &str, message: &str| {
        let error = load(&format!("{SMALL}{line}\n")).unwrap_err();
        assert!(error.len() < 700, "{error}");
        assert_mentions(&error, message);
    };
    let [parts, letters] = ["a.", "x"].map(|unit| unit.repeat(5000));
    check(&format!("{parts}a = 1"), "a.toml .. line 10 .. too many parts");
    check(&format!("[{parts}a]"), "a.toml .. line 10 .. too many parts");
    check(&format!("detection_threshold = {0}1{1}", "[".repeat(5000), "]".repeat(5000)), "a.toml .. line 10");
    check(&format!("{letters} = 1"), "a.toml .. line 10");
    check(&format!("[robots]\npolicy = '{letters}'"), "\" .. allowed .. random");
    check(
        "detection_threshold = 1e308",
        "a.toml .. line 10 .. mission.detection_threshold .. 1e308 .. above 0.5 and below 1",
    );
    check("speed_meters_per_second = -5e-324", "mission.speed_meters_per_second .. -5e-324 .. from 0.001");
    let sigma = load(&SMALL.replace("radius = 1", "radius = 1\nnoise_variance = 1e300")).unwrap_err();
    assert_mentions(&sigma, "sensor.noise_variance .. 1e300 .. allowed");
    check(&"#".repeat(Scenario::MAX_BYTES), "longer than .. 4194304 bytes");
    let error = Scenario::from_text(Path::new("a.toml"), " ".repeat(Scenario::MAX_BYTES + 1)).unwrap_err();
    let error = error.to_string();
    assert_mentions(&error, "4194305 bytes .. at most 4194304 bytes");
}

#[test]
#[cfg(target_os = "linux")]
fn a_device_is_no_scenario_and_no_weights() {
    let error = Scenario::load(Path::new("/dev/zero")).unwrap_err().to_string();
    assert!(error.contains("/dev/zero") && error.contains("no plain file"), "{error}");
    let weights = "[robots]\npolicy = { name = 'gnn', weights = '/dev/zero' }\n";
    let error = load(&format!("{SMALL}{weights}")).unwrap_err();
    assert!(error.contains("/dev/zero") && error.contains("no plain file"), "{error}");
}

/// Opening such a pipe would block for ever.
#[test]
#[cfg(unix)]
fn a_pipe_without_a_writer_is_rejected_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("a.kml");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let refused = |file: &Path, kind: &str| {
        let error = Scenario::load(file).unwrap_err().to_string();
        assert!(error.ends_with(&format!("a.kml: no plain file, but {kind}")), "{error}");
    };
    refused(&pipe, "a pipe");
    let scenario = folder.path().join("a.toml");
    fs::write(&scenario, SMALL.replace("a.txt", "a.kml")).unwrap();
    refused(&scenario, "a pipe");
    fs::remove_file(&pipe).unwrap();
    let _listener = std::os::unix::net::UnixListener::bind(&pipe).unwrap();
    refused(&pipe, "a socket");
    fs::remove_file(&pipe).unwrap();
    fs::create_dir(&pipe).unwrap();
    refused(&pipe, "a folder");
}

/// So short or so slow that a mission never ends.
#[test]
fn endless_missions_are_rejected() {
    let check = |more: &str, message: &str| {
        let error = load(&format!("{SMALL}{more}")).unwrap_err();
        assert_mentions(&error, message);
    };
    check("heartbeat_seconds = 1e-9", "mission.heartbeat_seconds .. 0.000000001 .. from 0.01");
    check(
        "[recording]\nbelief_period_seconds = 1e-6",
        "recording.belief_period_seconds .. 0.000001 .. from 0.01",
    );
    check(
        "speed_meters_per_second = 1e-308",
        "mission.speed_meters_per_second .. 1e-308 .. 0.001 to 1000000000",
    );
    check(
        "speed_meters_per_second = 0.01\nheartbeat_seconds = 0.02",
        "mission.heartbeat_seconds .. 0.02 .. at least 3",
    );
}

/// Serde reads as much of a list as it needs, and accepts a list for a table.
#[test]
fn a_list_longer_than_what_is_read_is_rejected() {
    let check = |from: &str, to: &str, message: &str| {
        let error = load(&SMALL.replace(from, to)).unwrap_err();
        assert_mentions(&error, message);
    };
    check(
        "count = 1",
        "cells = [[0, 0],\n[0, 0, 1]]",
        "a.toml .. line 8 .. objects.cells[1] .. 3 .. a list of 2",
    );
    check("count = 1", "cells = [[0, 0], [0, 0]]", "objects.cells[1] .. [0, 0] .. each cell");
    check(
        "file = 'a.txt'",
        "file = 'a.txt'\norigin = [49, -2, 0]",
        "a.toml .. line 4 .. map.origin .. a list .. a table .. latitude_degrees",
    );
}

#[test]
fn a_map_without_ground_is_rejected() {
    let check = |drawing: &str, message: &str| {
        let error = load_with(SMALL, drawing).unwrap_err();
        assert_mentions(&error, &format!("line 2 .. map .. without .. {message}"));
    };
    check("~#\n", "at least one traversable cell");
    check(",#\n", "at least one searched cell");
}

#[test]
fn overrides_change_one_value_and_are_checked() {
    let scenario = small(|text| {
        format!(
            "{text}[robots]\ncount = 2\npolicy = {{ name = 'path', replan_after_cells = 3 }}\n[[robots.robot]]\nnumber = 2\npolicy = 'nats'\n"
        )
    });
    let greedy = scenario.with_policy(Exact::Greedy).unwrap();
    assert!(greedy.robots().iter().all(|robot| robot.policy == plain(Exact::Greedy)));
    assert_eq!(scenario.with_robots(4).unwrap().robots().len(), 4);
    let dense = scenario.with_density(0.25).unwrap();
    assert_eq!(dense.objects(), &Objects::Density(0.25));
    assert!(close(dense.prior().probability(dense.terrain().searched_cells().next().unwrap()), 0.25));
    assert_eq!(scenario.with_budget_cells(7).unwrap().mission().budget.meters(), Some(210.0));
    let check = |changed: Result<Scenario, ScenarioError>, message: &str| {
        let error = changed.unwrap_err().to_string();
        assert_mentions(&error, &format!("a.toml .. changed on the command line .. {message}"));
    };
    check(scenario.with_robots(0), "robots.count .. 0 .. 1 to 1000");
    check(scenario.with_robots(1), "robots.robot[0].number .. 2 .. 1 to 1");
    check(scenario.with_density(f64::NAN), "objects.density .. NaN .. above 0 and below 1");
    check(scenario.with_budget_cells(0), "mission.budget_meters .. 0 .. above 0");
}

fn check_warnings(scenario: &Scenario, expected: &[&str]) {
    let warnings: Vec<String> = scenario.warnings().iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), expected.len(), "{warnings:?}");
    for (warning, parts) in warnings.iter().zip(expected) {
        assert_mentions(warning, parts);
    }
}

#[test]
fn robots_that_keep_apart_start_apart_or_find_no_room() {
    let robots = |robots: &str| load(&format!("{SMALL}[robots]\n{robots}\n"));
    let starts = |text: &str| {
        let scenario = robots(text).unwrap();
        let number = |robot: &Robot| match robot.start {
            Start::Cell(cell) => Some(cell.number()),
            _ => None,
        };
        scenario.robots().iter().map(number).collect::<Vec<_>>()
    };
    assert_eq!(starts("count = 3\nstart = [0, 0]"), [Some(0); 3]);
    assert_eq!(starts("count = 3\nstart = [0, 0]\nseparation_meters = 30.0"), [0, 1, 4].map(Some));
    assert_eq!(starts("count = 2\nstart = [0, 0]\nseparation_meters = 31.0"), [0, 2].map(Some));
    let drawn = robots("count = 4\nstart = 'random'\nseparation_meters = 30.0").unwrap();
    let cells: Vec<Cell> = drawn.terrain().grid().cells().collect();
    assert_eq!(drawn.apart(vec![cells[0]; 4]), [0, 1, 4, 2].map(|place| cells[place]));
    for (text, found) in [
        ("count = 7\nseparation_meters = 30.0", "30.0 meters for 7 robots"),
        ("count = 3\nstart = [0, 0]\nseparation_meters = 31.0", "31.0 meters for 3 robots"),
        ("separation_meters = -1.0", "-1"),
        ("separation_meters = nan", "NaN"),
    ] {
        let error = robots(text).unwrap_err();
        assert_mentions(
            &error,
            &format!("a.toml, line .. robots.separation_meters is .. {found} .. allowed is"),
        );
    }
}

#[test]
fn cells_out_of_reach_and_areas_apart_are_warned_of() {
    let check = |drawing: &str, robots: &str, expected: &[&str]| {
        let scenario = load_with(&format!("{SMALL}[robots]\n{robots}"), drawing).unwrap();
        check_warnings(&scenario, expected);
    };
    check("....~", "", &[]);
    check("...#~.", "", &["2 of 5 searched cells .. [0, 4]"]);
    check("...#~.", "start = [0, 5]", &["3 of 5 searched cells .. [0, 0]"]);
    let apart = "count = 2\n[[robots.robot]]\nnumber = 2\nstart = [0, 5]";
    check("...#~.", apart, &["robots 1 and 2 .. areas"]);
}

#[test]
fn objects_that_the_prior_does_not_expect_are_warned_of() {
    let check = |objects: &str, prior: &str, expected: &[&str]| {
        let text = SMALL.replace("count = 1", objects);
        let scenario = load_with(&format!("{text}[prior]\n{prior}"), "....\n....\n").unwrap();
        check_warnings(&scenario, expected);
    };
    check("count = 0", "", &[]);
    check("count = 2", "probability = 0.5", &[]);
    check("count = 1", "probability = 0.5", &["prior .. 4.00 .. [objects] .. 1.00"]);
    check("density = 0.9", "probability = 0.1", &["prior .. 0.80 .. [objects] .. 7.20"]);
    // From the file, 0.5 in [1, 3] and [0, 1].
    check("cells = [[1, 3]]", "file = 'low.csv'", &[]);
    let excluded = "1 of 2 given objects .. prior is 0 .. [0, 0]";
    check("cells = [[0, 0], [0, 1]]", "file = 'low.csv'", &[excluded]);
    let hidden = load_with(&SMALL.replace("count = 1", "cells = [[0, 4]]"), "...#~.").unwrap();
    check_warnings(
        &hidden,
        &[
            "2 of 5 searched cells .. 40.0 % of the probability .. [0, 4]",
            "1 of 1 given objects .. sight .. [0, 4]",
        ],
    );
}

#[test]
fn over_radios_robots_decide_one_after_the_other() {
    let stagger = |mission: &str, network: &str| {
        let text = SMALL.replace("[mission]", &format!("[mission]\n{mission}"));
        load_with(&format!("{text}[network]\n{network}"), "....\n").unwrap().mission().stagger.as_secs_f64()
    };
    for (mission, network, expected) in [
        ("", "", 0.1),
        ("", "bytes_per_second = 125.0", 2.4),
        ("start_stagger_seconds = 5.0", "bytes_per_second = 125.0", 5.0),
        ("", "bytes_per_second = 1e9", 0.1),
    ] {
        assert!(close(stagger(mission, network), expected), "{mission} {network}");
    }
}

#[test]
fn a_search_that_ends_at_once_and_a_sensor_that_misleads_are_warned_of() {
    let check = |text: &str, expected: &[&str]| {
        let scenario = load_with(text, "....\n....\n").unwrap();
        check_warnings(&scenario, expected);
    };
    let stop = |limit: &str| {
        SMALL.replace("[mission]", &format!("[mission]\nstop_when_expected_remaining = {limit}"))
    };
    check(&stop("1.0"), &["stop_when_expected_remaining is 1 .. 1.000 .. ends before it begins"]);
    check(&stop("0.9"), &[]);
    let noisy = |variance: &str, noise: &str| {
        SMALL.replace("radius = 1", &format!("radius = 2\nnoise_variance = {variance}\nnoise = '{noise}'"))
    };
    check(&noisy("0.1", "clipped"), &["clipped .. 0.4 at distance 2 .. below 0.3"]);
    check(&noisy("0.1", "gaussian"), &[]);
    check(&noisy("0.07", "clipped"), &[]);
}

#[test]
fn a_placement_that_cannot_be_names_key_and_allowed_values() {
    let check = |objects: &str, expected: &str| {
        let text = SMALL.replace("count = 1", objects);
        let loaded = load_with(&format!("{text}[prior]\nfile = 'low.csv'"), "....\n....\n");
        assert_mentions(&loaded.unwrap_err(), expected);
    };
    check("count = 1\nplacement = 'prio'", "objects.placement .. \"prio\" .. \"prior\" or \"uniform\"");
    check("cells = [[0, 1]]\nplacement = 'prior'", "objects.placement .. none with objects.cells");
    check("count = 3", "objects.count .. 3 .. at most 2 .. uniform");
}

/// A field of 30 x 20 cells at the equator, a fence through it, and areas beyond it.
#[test]
fn areas_that_close_nothing_are_warned_of() {
    let polygon = |[west, south, east, north]: [f64; 4]| {
        format!(
            r#"{{"type":"Polygon","coordinates":[[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]]}}"#
        )
    };
    let feature = |properties: &str, geometry: &str| {
        format!(r#"{{"type":"Feature","properties":{{{properties}}},"geometry":{geometry}}}"#)
    };
    let lines =
        r#"{"type":"MultiLineString","coordinates":[[[0,0.001],[0.003,0.001]],[[0,0.1],[0.003,0.1]]]}"#;
    let drawn = [
        feature(r#""name":"field""#, &polygon([0.0, 0.0, 0.003, 0.002])),
        feature(r#""name":"speck""#, &polygon([0.0032, 0.0, 0.00321, 0.00001])),
        feature(r#""name":"pond","kind":"no_go""#, &polygon([0.001, 0.0012, 0.0012, 0.0014])),
        feature(r#""name":"sea","kind":"no_go""#, &polygon([0.1, 0.0, 0.2, 0.1])),
        feature(r#""name":"fence","kind":"no_go""#, lines),
    ];
    let folder = tempfile::tempdir().unwrap();
    let text = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, drawn.join(","));
    fs::write(folder.path().join("a.geojson"), text).unwrap();
    let file = folder.path().join("a.toml");
    fs::write(&file, SMALL.replace("a.txt'", "a.geojson'\ncell_meters = 11.1")).unwrap();
    let scenario = Scenario::load(&file).unwrap();
    let cells: Vec<(String, usize)> = scenario.drawn().into_iter().map(|it| (it.name, it.cells)).collect();
    let cells: Vec<(&str, usize)> = cells.iter().map(|(name, cells)| (name.as_str(), *cells)).collect();
    assert_eq!(cells, [("field", 600), ("speck", 0), ("pond", 9), ("sea", 0), ("fence", 30)]);
    let expected = [
        "searched cells .. sight",
        "in 2 parts .. 1 has no robot, of 270 cells .. 1 robot starts in that of 291 cells",
        "search \"speck\" .. no searched cell",
        "no_go \"sea\" .. closes no cell",
        "2 .. no_go \"fence\" .. 1 beyond the map",
    ];
    check_warnings(&scenario, &expected);
}

/// A scenario of these features alone, `(properties, rings)` in degrees.
fn of_map(features: &[(&str, &str)]) -> Scenario {
    let feature = |(properties, rings): &(&str, &str)| {
        format!(
            r#"{{"type":"Feature","properties":{{{properties}}},"geometry":{{"type":"Polygon","coordinates":[{rings}]}}}}"#
        )
    };
    let features = features.iter().map(feature).collect::<Vec<_>>().join(",");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.geojson");
    fs::write(&file, format!(r#"{{"type":"FeatureCollection","features":[{features}]}}"#)).unwrap();
    Scenario::load(&file).unwrap()
}

#[test]
fn a_probability_that_regions_leave_with_a_narrow_gap_is_told() {
    let area = ("", "[[0,0],[0.01,0],[0.01,0.01],[0,0.01],[0,0]]");
    let west = (r#""poa":0.5"#, "[[0,0],[0.00497,0],[0.00497,0.01],[0,0.01],[0,0]]");
    let check = |east: &str, poa: &str, expected: &[&str]| {
        let east = (poa, east);
        check_warnings(&of_map(&[area, west, east]), expected);
    };
    let (apart, meeting) = (
        "[[0.00503,0],[0.01,0],[0.01,0.01],[0.00503,0.01],[0.00503,0]]",
        "[[0.00497,0],[0.01,0],[0.01,0.01],[0.00497,0.01],[0.00497,0]]",
    );
    check(
        apart,
        r#""poa":0.3"#,
        &["20.0 % of the probability and 0.6 % of the search area .. beyond the map"],
    );
    check(meeting, r#""poa":0.3"#, &[]);
    check(apart, r#""poa":0.5"#, &[]);
}

#[test]
fn mended_polygons_are_counted_and_the_first_are_named() {
    let spiked = |west: u32| {
        let [a, b] = [west, west + 1].map(|at| f64::from(at) / 100.0);
        format!("[[{a},0],[{b},0],[{b},0.01],[{b},0.011],[{b},0.01],[{a},0.01],[{a},0]]")
    };
    let rings: Vec<String> = (0..5).map(spiked).collect();
    let features: Vec<(&str, &str)> = rings.iter().map(|rings| ("", rings.as_str())).collect();
    let told = "mended 5 polygons .. feature 1, polygon 1 .. feature 2, .. feature 3, .. and 2 more";
    check_warnings(&of_map(&features), &[told]);
    check_warnings(
        &of_map(&features[..1]),
        &["mended a polygon, .. feature 1, polygon 1: ring 1 crosses or touches"],
    );
}

#[test]
fn the_effective_file_reads_back_as_itself() {
    let scenario = small(|text| format!("{text}[zenoh]\nconfig = 'zenoh.json5'\n[robots]\nstart = [0, 0]\n"));
    let text = toml::to_string(scenario.file()).unwrap();
    assert_eq!(load(&text).unwrap().file(), scenario.file());
    assert!(scenario.zenoh_config().is_some_and(|path| path.ends_with("zenoh.json5")));
}

proptest! {
    #[test]
    fn any_text_is_read_or_rejected(
        text in "\\PC{0,60}",
        table in "(robots|map|network|prior|objects|sensor)",
        key in "(count|policy|start|robot|rows|partitions|cells|density|radius|probability)",
        value in "([-0-9.e]{1,20}|nan|inf|\\[\\[[-0-9, ]{0,6}\\]\\]|\\{name='path'\\}|'[a-z]{0,4}')",
    ) {
        let path = Path::new("a.toml");
        let _ = Scenario::from_text(path, text.clone());
        let shape = "shape = 'all_traversable'\nrows = 6\ncolumns = 6";
        let base = SMALL.replace("file = 'a.txt'", shape);
        let _ = Scenario::from_text(path, format!("{table}.{key} = {value}\n{base}"));
        let _ = Scenario::from_text(path, format!("{base}{table}.{key} = {value}\n"));
    }
}
