//! Bad input: exit code 2, nothing on stdout, and a message that names what is wrong and where.

use super::{Place, SMALL};

#[test]
fn a_wrong_option_is_named_with_what_is_allowed() {
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
        (&["run", "small.toml", "--seed", "-1"], &["--seed", "-1"]),
        (&["run", "small.toml", "--seed", "1.5"], &["--seed", "1.5"]),
        (&["run", "small.toml", "--real-time", "0"], &["--real-time", "0.001 to 10000"]),
        (&["run", "small.toml", "--real-time", "nan"], &["--real-time", "0.001 to 10000"]),
        (&["run", "small.toml", "--real-time", "-2"], &["--real-time", "0.001 to 10000"]),
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
fn a_wrong_option_of_compare_is_named_with_what_is_allowed() {
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
        (&["small.toml", "--policies", "path"], &["small.toml", "also named \"small\""]),
    ] {
        place.refuse(&[&["compare", "small.toml"], arguments].concat(), said);
    }
}

#[test]
fn a_wrong_scenario_is_refused_by_all_who_read_one() {
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
fn nothing_is_recorded_of_what_is_refused() {
    let place = Place::new();
    place.refuse(&["run", "small.toml", "--robots", "0", "--record", "a.mcap"], &["--robots"]);
    assert!(!place.path("a.mcap").exists());
}
