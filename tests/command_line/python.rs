//! The package for Python: its own tests, by pytest, in the environment that `test.sh` makes.

use std::process::Command;

use super::interpreter::interpreter;
use super::root;

/// Runs one file of tests. Whoever has no such package is told how to make it.
fn check(file: &str) {
    let output = Command::new(interpreter(root()))
        .args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider"])
        .arg(root().join("python/tests").join(file))
        .current_dir(root().join("python"))
        .env("DRAGNET", env!("CARGO_BIN_EXE_dragnet"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let (told, wrong) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let hint = "the package is built by `.venv/bin/maturin develop --manifest-path python/Cargo.toml`";
    assert!(output.status.success(), "{told}{wrong}\n{hint}");
    assert!(told.contains(" passed"), "{told}");
}

#[test]
fn environments_are_what_gymnasium_and_pettingzoo_ask_for() {
    check("test_standards.py");
}

#[test]
fn an_episode_in_python_is_that_of_the_command_line() {
    check("test_equality.py");
}

#[test]
fn a_team_in_python_believes_what_its_network_brings() {
    check("test_teams.py");
}

#[test]
fn bad_input_from_python_is_an_exception_that_says_what_is_wrong() {
    check("test_bad_input.py");
}

#[test]
fn the_examples_in_python_run_and_do_what_they_say() {
    check("test_examples.py");
}
