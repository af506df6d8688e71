//! `scale/`: sweeps over Ray and Slurm give the results of one process.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

use super::interpreter::interpreter;
use super::shards::assert_same_results;
use super::{Place, root, stderr};

/// Six episodes.
const COMPARISON: [&str; 8] =
    ["compare", "small.toml", "--policies", "random,path", "--seeds", "3", "--budget", "40"];

/// One Ray cluster at a time: each uses all cores.
static CLUSTER: Mutex<()> = Mutex::new(());

/// A program that runs these lines of shell first, and then dragnet.
fn program(place: &Place, first: &str) {
    let dragnet = env!("CARGO_BIN_EXE_dragnet");
    place.write("program", &format!("#!/bin/sh\n{first}\nexec {dragnet} \"$@\"\n"));
    fs::set_permissions(place.path("program"), fs::Permissions::from_mode(0o755)).unwrap();
}

/// A sweep in this folder by a Ray cluster of two cores.
fn sweep(place: &Place, options: &[&str]) -> Output {
    let _alone = CLUSTER.lock().unwrap_or_else(PoisonError::into_inner);
    Command::new(interpreter(root()))
        .arg(root().join("scale/ray_sweep.py"))
        .args(["--cores", "2", "--program", "./program"])
        .args(options)
        .current_dir(place.path(""))
        // Files that Ray leaves are deleted with the folder.
        .env("HOME", place.path(""))
        .env("RAY_TMPDIR", place.path(""))
        .output()
        .unwrap()
}

fn run_whole(place: &Place) {
    place.succeed(&[&COMPARISON as &[&str], &["--out", "whole"]].concat());
}

#[test]
fn a_sweep_survives_a_killed_command_and_a_lost_worker() {
    let place = Place::new();
    program(
        &place,
        "case \"$*\" in\n\
         *'--shard 2/4'*) [ -e lost ] || { touch lost; kill -9 $PPID; } ;;\n\
         *'--shard 3/4'*) [ -e killed ] || { touch killed; kill -9 $$; } ;;\n\
         esac",
    );
    let options = [&["--shards", "4", "--out", "swept", "--"] as &[&str], &COMPARISON].concat();
    let output = sweep(&place, &options);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(place.path("lost").exists() && place.path("killed").exists(), "the hard case was not met");
    assert!(stderr(&output).contains("has ended: 4 of 4"), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.starts_with("3 seeds (0 to 2): 6 episodes in 4 parts\n"), "{text}");
    run_whole(&place);
    assert_same_results(&place, "whole", "swept");
}

#[test]
fn a_sweep_without_a_shared_folder_brings_everything_there_and_back() {
    let place = Place::new();
    fs::create_dir(place.path("bundle")).unwrap();
    // Shards find the copied folder, and nothing around it.
    program(&place, "case \"$1\" in merge) ;; *) [ ! -e ../small.toml ] || exit 1 ;; esac");
    for name in ["program", "small.toml"] {
        fs::copy(place.path(name), place.path("bundle").join(name)).unwrap();
    }
    let options =
        ["--shards", "2", "--out", "swept", "--collect", "--upload", "bundle", "--retries", "0", "--"];
    let output = sweep(&place, &[&options as &[&str], &COMPARISON].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    run_whole(&place);
    assert_same_results(&place, "whole", "swept");
}

/// Exit code of a sweep of one shard whose command ends with this code, and the number of attempts.
fn tries(command_code: u8) -> (Option<i32>, usize, String) {
    let place = Place::new();
    program(
        &place,
        &format!("echo tried >> {}; echo why >&2; exit {command_code}", place.path("tries").display()),
    );
    let options = ["--shards", "1", "--out", "swept", "--retries", "2", "--"];
    let output = sweep(&place, &[&options as &[&str], &COMPARISON].concat());
    let tries = fs::read_to_string(place.path("tries")).unwrap().lines().count();
    (output.status.code(), tries, stderr(&output))
}

#[test]
fn a_shard_that_fails_is_tried_again_and_bad_input_is_not() {
    let (code, count, said) = tries(1);
    assert_eq!((code, count), (Some(1), 3), "{said}");
    assert!(said.contains("exit code 1\nwhy\n") && said.contains("1 of 1 shards failed"), "{said}");
    let (code, count, said) = tries(2);
    assert_eq!((code, count), (Some(2), 1), "{said}");
    assert!(said.contains("error: shard 1") && said.contains("exit code 2\nwhy\n"), "{said}");
}

#[test]
fn a_sweep_that_cannot_start_reports_why() {
    let place = Place::new();
    for (options, said) in [
        (["--shards", "0", "--out", "swept"], "--shards: '0': allowed is a whole number, 1 to 100000"),
        (["--shards", "2", "--out", "small.toml"], "--out small.toml: cannot make the folder"),
        (["--shards", "2", "--out", "swept"], "--program ./program: there is no such program"),
        (["--shards", "2", "--upload", "nowhere"], "--upload: there is no folder nowhere"),
    ] {
        let output = sweep(&place, &[&options as &[&str], &["--"], &COMPARISON].concat());
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        assert!(stderr(&output).contains(said), "{options:?}\n{}", stderr(&output));
    }
    program(&place, "");
    let options = ["--address", "127.0.0.1:1", "--shards", "2", "--out", "swept", "--"];
    let output = sweep(&place, &[&options as &[&str], &COMPARISON].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--address 127.0.0.1:1: "), "{}", stderr(&output));
}

/// A task of a job array, as started by Slurm.
fn slurm_task(place: &Place, task: &str, environment: &[(&str, &str)]) -> Output {
    Command::new("bash")
        .arg(root().join("scale/slurm_array.sbatch"))
        .args(COMPARISON)
        .current_dir(place.path(""))
        .env("DRAGNET", env!("CARGO_BIN_EXE_dragnet"))
        .env("SLURM_ARRAY_TASK_ID", task)
        .envs(environment.iter().copied())
        .output()
        .unwrap()
}

fn parts(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn the_tasks_of_a_job_array_run_every_shard_once() {
    let place = Place::new();
    run_whole(&place);
    for (out, tasks, shards) in
        [("one_each", "3", None), ("several", "2", Some("5")), ("spare", "4", Some("3"))]
    {
        let mut environment = vec![("OUT", out), ("TASKS", tasks)];
        environment.extend(shards.map(|shards| ("SHARDS", shards)));
        let mut run = 0;
        for task in 1..=tasks.parse::<u32>().unwrap() {
            let output = slurm_task(&place, &task.to_string(), &environment);
            assert!(output.status.success(), "{}", stderr(&output));
            run += String::from_utf8_lossy(&output.stdout).matches("written: ").count();
        }
        let shards: usize = shards.unwrap_or(tasks).parse().unwrap();
        assert_eq!((run, parts(&place.path(out)).len()), (shards, shards), "{out}");
        place.succeed(&["merge", out, "--out", out]);
        assert_same_results(&place, "whole", out);
    }
}

#[test]
fn a_task_outside_the_array_is_rejected() {
    let place = Place::new();
    for (task, said) in [("0", "allowed are 1 to 2"), ("3", "allowed are 1 to 2"), ("", "job array")] {
        let output = slurm_task(&place, task, &[("TASKS", "2")]);
        assert!(!output.status.success() && stderr(&output).contains(said), "{task}: {}", stderr(&output));
    }
    assert!(!place.path("results").exists());
}
