//! Help, completions, the schema, checks, and readers that stop reading.

use std::fs::{self, File};
use std::io::pipe;

use super::{Place, root, stderr};

#[test]
fn every_command_explains_itself_with_an_example() {
    let place = Place::new();
    let help = place.succeed(&["--help"]);
    for command in [
        "run",
        "compare",
        "merge",
        "paper",
        "check",
        "schema",
        "inspect",
        "recover",
        "agent",
        "coordinator",
        "sim",
        "completions",
    ] {
        assert!(help.lines().any(|line| line.trim_start().starts_with(command)), "{command}\n{help}");
        let help = place.succeed(&[command, "--help"]);
        assert!(help.contains(&format!("  dragnet {command}")), "{command}\n{help}");
    }
}

#[test]
fn the_version_names_the_commit() {
    let version = Place::new().succeed(&["--version"]);
    assert!(version.starts_with(&format!("dragnet {} (", env!("CARGO_PKG_VERSION"))), "{version}");
}

#[test]
fn every_shell_gets_completions() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = Place::new().succeed(&["completions", shell]);
        assert!(script.contains("dragnet") && script.contains("policies"), "{shell}");
    }
}

#[test]
fn the_schema_is_the_one_that_is_committed() {
    let committed = |file: &str| fs::read_to_string(root().join(file)).unwrap();
    let place = Place::new();
    assert_eq!(place.succeed(&["schema"]), committed("scenarios/scenario.schema.json"));
    for kind in ["agent", "coordinator", "sim"] {
        assert_eq!(place.succeed(&["schema", kind]), committed(&format!("deploy/{kind}.schema.json")));
        let reference = place.succeed(&["schema", kind, "--markdown"]);
        assert!(committed("docs/settings.md").contains(&reference), "docs/settings.md: {kind}");
    }
}

#[test]
fn printed_settings_and_shipped_examples_are_valid() {
    let place = Place::new();
    let text = fs::read_to_string(root().join("deploy/examples/valley.toml")).unwrap();
    place.write("valley.toml", &text);
    for command in ["agent", "coordinator", "sim"] {
        place.write("printed.toml", &place.succeed(&[command, "--print-config"]));
        let reported = place.succeed(&["check", "printed.toml"]);
        assert!(reported.contains("printed.toml: ok: ") && reported.contains("mission valley"), "{reported}");
    }
    let examples = ["robot", "vehicle", "nav2", "coordinator", "sim", "valley"];
    let examples = examples.map(|name| root().join(format!("deploy/examples/{name}.toml")));
    let paths: Vec<&str> = examples.iter().map(|path| path.to_str().unwrap()).collect();
    let reported = place.succeed(&[&["check"], &paths[..]].concat());
    assert_eq!(reported.matches(": ok: ").count(), examples.len(), "{reported}");
    for path in examples {
        let text = fs::read_to_string(&path).unwrap();
        let named = text.lines().next().and_then(|line| line.strip_prefix("#:schema "));
        assert!(path.parent().unwrap().join(named.unwrap()).exists(), "{}", path.display());
    }
}

#[test]
fn a_check_sums_up_each_scenario() {
    let place = Place::new();
    let text =
        place.succeed(&["check", "small.toml", root().join("scenarios/warehouse.toml").to_str().unwrap()]);
    let expected = "small.toml: ok: 12 x 12 cells of 30 m, 144 traversable, 144 searched; 4 objects; \
                    2 robots (path), sight 150 m; budget 1800 m, 60 cells";
    assert_eq!(text.lines().next(), Some(expected));
    assert_eq!(text.lines().nth(1), Some("  start: in a cell drawn by the seed"));
    let small = fs::read_to_string(place.path("small.toml")).unwrap();
    fs::write(place.path("apart.toml"), small.replace("[robots]\n", "[robots]\nseparation_meters = 12.5\n"))
        .unwrap();
    let apart = place.succeed(&["check", "apart.toml"]);
    assert!(apart.contains("2 robots (path, at least 30 m apart), sight 150 m"), "{apart}");
    assert_eq!(text.lines().filter(|line| line.contains(": ok: ")).count(), 2, "{text}");
}

#[test]
fn a_check_warns_of_likely_mistakes() {
    let place = Place::new();
    place.write("map.txt", "..##########....\n");
    place.write(
        "apart.toml",
        "name = 'apart'\nmap.file = 'map.txt'\nsensor.radius = 1\nobjects.count = 1\nmission.budget_meters = 90.0\n",
    );
    let text = place.succeed(&["check", "apart.toml"]);
    assert!(text.contains("apart.toml: warning: "), "{text}");
}

#[test]
fn a_check_warns_of_settings_by_which_nobody_is_met() {
    let place = Place::new();
    let settings = |zenoh: &str| {
        place.write(
            "robot.toml",
            &format!("robot = 1\n[common]\nmission = 'small'\nscenario = 'small.toml'\n{zenoh}\n"),
        );
        place.succeed(&["check", "robot.toml"])
    };
    let text = settings("");
    assert!(text.contains("robot.toml: warning: it listens nowhere, connects to nobody"), "{text}");
    assert!(text.contains("listen = [\"tcp/ADDRESS:PORT\"]"), "{text}");
    let text = settings("zenoh.connect = ['tcp/192.168.1.7:7447']");
    assert!(!text.contains("warning"), "{text}");
}

#[test]
fn a_check_warns_of_an_area_that_the_assumed_budget_cannot_cover() {
    let place = Place::new();
    let strip = |degrees: f64| {
        let (east, north) = (10.0 + degrees, 50.0 + degrees);
        let ring = format!("[[10,50],[{east},50],[{east},{north}],[10,{north}],[10,50]]");
        place.write("area.geojson", &format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#));
        place.succeed(&["check", "area.geojson"])
    };
    let text = strip(0.6);
    assert!(text.contains("warning: the assumed budget is short for this map: the robots can look at about"));
    let text = strip(0.02);
    assert!(!text.contains("warning"), "{text}");
}

#[test]
fn a_check_goes_on_after_an_error() {
    let place = Place::new();
    let output = place.dragnet(&["check", "missing.toml", "small.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("small.toml: ok: "));
    let message = stderr(&output);
    assert!(message.contains("missing.toml") && message.contains("1 of 2 files"), "{message}");
}

#[test]
fn a_reader_that_stops_reading_is_no_failure() {
    let place = Place::new();
    for arguments in [
        &["--help"] as &[&str],
        &["schema"],
        &["completions", "zsh"],
        &["check", "small.toml"],
        &["run", "small.toml"],
        &["run", "small.toml", "--json"],
        &["compare", "small.toml", "--policies", "path", "--seeds", "2"],
    ] {
        let (reader, writer) = pipe().unwrap();
        drop(reader);
        let output = place.command(arguments).stdout(writer).output().unwrap();
        assert!(output.status.success(), "{arguments:?} {}\n{}", output.status, stderr(&output));
        assert!(output.stderr.is_empty(), "{arguments:?}\n{}", stderr(&output));
    }
    assert!(place.path("small-0.mcap").is_file(), "the search itself goes on");
}

#[test]
fn output_that_cannot_be_written_is_a_failure() {
    let place = Place::new();
    let full = File::options().write(true).open("/dev/full").unwrap();
    let output = place.command(&["schema"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("cannot write to standard output"), "{}", stderr(&output));
}
