//! Bad input: exit code 2, nothing on stdout, and a message that names what is wrong and where.

use super::{Place, SMALL};

#[test]
fn a_wrong_option_is_named_with_the_allowed_values() {
    let place = Place::new();
    for (arguments, said) in [
        (
            &["run", "small.toml", "--policy", "best"] as &[&str],
            &["--policy", "best", "path-additive"] as &[&str],
        ),
        (&["run", "small.toml", "--robots", "0"], &["--robots 0", "1 to 1000"]),
        (&["run", "small.toml", "--robots", "1001"], &["--robots 1001", "1 to 1000"]),
        (&["run", "small.toml", "--robots", "-1"], &["--robots", "-1"]),
        (&["run", "small.toml", "--robots", "two"], &["--robots", "two"]),
        (&["run", "small.toml", "--seed", "-1"], &["--seed", "-1", "a whole number from 0"]),
        (&["run", "small.toml", "--seed", "1.5"], &["--seed", "1.5", "a whole number from 0"]),
        (&["run", "small.toml", "--real-time-factor", "0"], &["--real-time-factor", "0.001 to 10000"]),
        (&["run", "small.toml", "--real-time-factor", "nan"], &["--real-time-factor", "0.001 to 10000"]),
        (&["run", "small.toml", "--real-time-factor", "-2"], &["--real-time-factor", "0.001 to 10000"]),
        (&["run", "small.toml", "--record", "no/where.mcap"], &["--record no/where.mcap", "no folder no"]),
        (&["run", "small.toml", "--wrong"], &["--wrong"]),
        (&["run"], &["<SCENARIO>"]),
        (&["compare", "small.toml"], &["--policies"]),
        (&["wrong"], &["wrong"]),
        (&["completions", "wrong"], &["wrong", "bash"]),
        (&["agent"], &["--config"]),
        (&["agent", "--config", "missing.toml"], &["missing.toml"]),
        (&["coordinator", "--config", "missing.toml"], &["missing.toml"]),
        (&["sim", "small.toml", "--config", "missing.toml"], &["missing.toml"]),
    ] {
        place.refuse(arguments, said);
    }
}

#[test]
fn a_scenario_that_cannot_be_run_live_is_refused_before_it_is_served() {
    let place = Place::new();
    place.write("lossy.toml", &format!("{SMALL}\n[network]\nloss = 0.5\n"));
    for (option, served) in [("--live", "live page"), ("--foxglove=0", "ws://")] {
        place.refuse(&["run", "lossy.toml", option], &["[network] faults"]);
        assert!(!super::stderr(&place.dragnet(&["run", "lossy.toml", option])).contains(served));
    }
}

#[test]
fn a_wrong_option_of_compare_is_named_with_the_allowed_values() {
    let place = Place::new();
    for (arguments, said) in [
        (&["--policies", "path,best"] as &[&str], &["--policies", "best", "path-additive"] as &[&str]),
        (&["--policies", "path,greedy,path"], &["--policies", "path is there twice"]),
        (&["--policies", "path", "--seeds", "0"], &["--seeds", "a number of seeds"]),
        (&["--policies", "path", "--seeds", "9..3"], &["--seeds", "9..3"]),
        (&["--policies", "path", "--density", "0"], &["--density 0", "above 0 and below 1"]),
        (&["--policies", "path", "--density", "1"], &["--density 1", "above 0 and below 1"]),
        (&["--policies", "path", "--density", "nan"], &["--density NaN", "above 0 and below 1"]),
        (&["--policies", "path", "--density", "-0.1"], &["--density -0.1", "above 0 and below 1"]),
        (&["--policies", "path", "--budget", "0"], &["--budget 0", "above 0"]),
        (&["--policies", "path", "--robots", "0"], &["--robots 0", "1 to 1000"]),
        (&["--policies", "path", "--threads", "0"], &["--threads", "1..=1024"]),
        (&["--policies", "path", "--out", "small.toml"], &["--out small.toml"]),
        (&["--policies", "path", "--shard", "1/2"], &["--out <DIR>"]),
        (&["--policies", "path", "--out", "parts", "--shard", "0/2"], &["--shard", "0/2", "I/N"]),
        (&["--policies", "path", "--out", "parts", "--shard", "3/2"], &["--shard", "3/2", "I/N"]),
        (&["--policies", "path", "--out", "parts", "--shard", "1/100001"], &["--shard", "100000"]),
        (&["--policies", "path", "--out", "parts", "--shard", "1/2", "--json"], &["--shard", "--json"]),
        (&["small.toml", "--policies", "path"], &["small.toml", "\"small\"", "taken"]),
    ] {
        place.refuse(&[&["compare", "small.toml"], arguments].concat(), said);
    }
}

#[test]
fn a_wrong_scenario_is_rejected_by_all_commands() {
    let place = Place::new();
    place.write("syntax.toml", "name = 'a\n");
    place.write("unknown.toml", &SMALL.replace("count = 4", "number = 4"));
    place.write("range.toml", &SMALL.replace("1800.0", "-1.0"));
    place.write("policy.toml", &SMALL.replace("count = 2", "count = 2\npolicy = 'best'"));
    place.write(
        "map.toml",
        &SMALL.replace("shape = 'all_traversable'\nrows = 12\ncolumns = 12", "file = 'no.txt'"),
    );
    place.write("robots.toml", &format!("{SMALL}[[robots.robot]]\nnumber = 2\n"));
    for (file, said) in [
        ("missing.toml", &["missing.toml"] as &[&str]),
        ("syntax.toml", &["syntax.toml, line 1"]),
        ("unknown.toml", &["unknown.toml, line 7", "number"]),
        ("range.toml", &["range.toml, line 11", "mission.budget_meters is -1", "above 0"]),
        ("policy.toml", &["policy.toml, line 10", "\"best\"", "path-additive"]),
        ("map.toml", &["map.toml, line 3", "no.txt"]),
    ] {
        place.refuse(&["check", file], said);
        place.refuse(&["run", file], said);
        place.refuse(&["compare", file, "--policies", "path"], said);
        place.refuse(&["sim", file, "--config", "none.toml"], said);
    }
    place.refuse(&["run", "robots.toml", "--robots", "1"], &["--robots 1", "robots.robot[0].number"]);
}

#[test]
fn rejected_observations_are_not_recorded() {
    let place = Place::new();
    place.refuse(&["run", "small.toml", "--robots", "0", "--record", "a.mcap"], &["--robots"]);
    assert!(!place.path("a.mcap").exists());
}

/// A device never ends, and opening a pipe can block for ever.
#[test]
fn irregular_files_are_rejected() {
    let place = Place::new();
    place.write(
        "yaml.toml",
        &SMALL.replace("shape = 'all_traversable'\nrows = 12\ncolumns = 12", "file = 'a.yaml'"),
    );
    std::os::unix::fs::symlink("/dev/zero", place.path("a.yaml")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", place.path("part-1-of-1.json")).unwrap();
    let agent = "mission = 'small'\nscenario = 'small.toml'\nzenoh.config = '/dev/zero'\n";
    place.write("agent.toml", &format!("robot = 1\n[common]\n{agent}"));
    let pipe = std::process::Command::new("mkfifo").arg(place.path("pipe")).status();
    assert!(pipe.unwrap().success());
    let endless = "no plain file, but a device";
    for (arguments, said) in [
        (&["check", "/dev/zero"] as &[&str], &["/dev/zero", endless] as &[&str]),
        (&["check", "yaml.toml"], &["a.yaml", endless]),
        (&["agent", "--config", "/dev/zero"], &["/dev/zero", endless]),
        (&["coordinator", "--config", "/dev/zero"], &["/dev/zero", endless]),
        (&["sim", "small.toml", "--config", "/dev/zero"], &["/dev/zero", endless]),
        (&["agent", "--config", "agent.toml"], &["/dev/zero: no plain file"]),
        (&["calibrate", "/dev/zero"], &["/dev/zero", endless]),
        (&["inspect", "/dev/zero"], &["/dev/zero", endless]),
        (&["check", "pipe"], &["pipe: no plain file, but a pipe"]),
        (&["agent", "--config", "pipe"], &["pipe", "no plain file, but a pipe"]),
        (&["calibrate", "pipe"], &["pipe", "no plain file, but a pipe"]),
        (&["inspect", "pipe"], &["pipe", "no plain file, but a pipe"]),
    ] {
        place.refuse(arguments, said);
    }
}

#[test]
fn errors_of_settings_name_the_line_and_the_key_in_words() {
    let place = Place::new();
    for (command, text, said) in [
        ("agent", "robot = 1\nrobot = 2\n", ["line 2", "robot is given twice"]),
        ("agent", "robot = 1\n[common]\nmision = 'a'\n", ["line 3", "common.mision: unknown field `mision`"]),
        ("coordinator", "recording = [1]\n", ["line 1", "recording: invalid type: a list, expected a path"]),
        ("coordinator", "\nrecording = \n", ["line 2", "string values must be quoted"]),
    ] {
        place.write("settings.toml", text);
        place.refuse(&[command, "--config", "settings.toml"], &said);
        place.refuse(&["check", "settings.toml"], &said[..1]);
    }
}

#[test]
fn a_file_of_another_kind_is_told_with_what_reads_it() {
    let place = Place::new();
    let settings = place.succeed(&["agent", "--print-config"]);
    place.write("agent.toml", &settings);
    place.refuse(
        &["run", "agent.toml"],
        &["agent.toml, line", "no scenario", "agent or coordinator reads with --config"],
    );
    place.succeed(&["scenarios", "--write", "ice_cream_cone"]);
    let said = ["ice_cream_cone.toml, line", "no settings", "a scenario, which run reads"];
    for command in ["agent", "coordinator"] {
        place.refuse(&[command, "--config", "ice_cream_cone.toml"], &said);
    }
}

/// A byte-order mark is not part of any text.
#[test]
fn a_byte_order_mark_is_not_part_of_a_text() {
    let place = Place::new();
    let mark = "\u{feff}";
    let observations =
        format!("distance,object,value\n{}", "1,1,0.9\n1,0,0.1\n2,1,1.3\n2,0,-0.2\n".repeat(20));
    let files = [
        ("m.pgm", "P2 3 2 255 254 254 254 254 254 254", ""),
        (
            "m.yaml",
            "image: m.pgm\nresolution: 1.0\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
            mark,
        ),
        ("m.txt", "...\n...\n", mark),
        ("m.map", "type octile\nheight 2\nwidth 3\nmap\n...\n...\n", mark),
        ("prior.csv", "0.1,0.2,0.3\n0.1,0.2,0.3\n", mark),
        ("m.geojson", r#"{"type":"Polygon","coordinates":[[[0,0],[0.001,0],[0.001,0.001],[0,0]]]}"#, mark),
        (
            "m.kml",
            "<kml><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 0.001,0 0.001,0.001 0,0\
                   </coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></kml>",
            mark,
        ),
        ("scores.csv", &*observations, mark),
    ];
    for (name, text, mark) in files {
        place.write(name, &format!("{mark}{text}"));
    }
    for map in ["m.yaml", "m.txt", "m.map", "m.geojson", "m.kml"] {
        let prior =
            if map.starts_with("m.g") || map.starts_with("m.k") { "" } else { "prior.file = 'prior.csv'\n" };
        let text = format!(
            "{mark}name = 't'\nmap = {{ file = '{map}', cell_meters = 1.0 }}\nsensor.radius = 1\nobjects.count = 1\n{prior}\
             mission.budget_meters = 30.0\n"
        );
        place.write("t.toml", &text);
        assert!(place.succeed(&["check", "t.toml"]).contains("t.toml: ok"), "{map}");
    }
    place.succeed(&["calibrate", "scores.csv"]);
    let utf16: Vec<u8> = format!("{mark}{SMALL}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    std::fs::write(place.path("wide.toml"), utf16).unwrap();
    assert!(place.succeed(&["check", "wide.toml"]).contains("wide.toml: ok"));
    std::fs::write(place.path("wide.toml"), [0xff, 0xfe, 0x41]).unwrap();
    place.refuse(&["check", "wide.toml"], &["no UTF-16 text"]);
}
