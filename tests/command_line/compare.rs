//! `dragnet compare`.

use std::fs;

use dragnet_scenario::Scenario;
use dragnet_search::policy::PolicyName;
use dragnet_sim::episode;
use dragnet_sim::simulation::End;
use serde_json::Value;

use super::{Place, keys};

/// Rows without the columns that depend on the computer.
fn rows(place: &Place, arguments: &[&str]) -> Vec<Value> {
    let report = place.json(&[&["compare", "small.toml", "--json"], arguments].concat());
    let mut rows = report["rows"].as_array().unwrap().clone();
    for row in &mut rows {
        assert_eq!(keys(&row["decision_ms"]), ["p50", "p99"]);
        row["decision_ms"] = Value::Null;
    }
    rows
}

#[test]
fn a_row_holds_means_their_errors_and_a_curve() {
    let rows = rows(&Place::new(), &["--policies", "random,path", "--seeds", "4", "--budget", "60"]);
    assert_eq!(rows.len(), 2);
    for (row, policy) in rows.iter().zip(["random", "path"]) {
        assert_eq!((&row["scenario"], &row["policy"]), (&"small".into(), &policy.into()));
        assert_eq!(
            (&row["map"], &row["robots"], &row["seeds"]),
            (&"all_traversable".into(), &2.into(), &4.into())
        );
        assert_eq!(
            (keys(&row["auc_f1"]), keys(&row["average_recall"])),
            (vec!["mean", "sem"], vec!["mean", "sem"])
        );
        let cells = ["mean", "reached", "recall", "restricted_mean", "restricted_sem", "sem"];
        assert_eq!(keys(&row["cells_to_full_recall"]), cells);
        let parts = row["cells_to_recall"].as_array().unwrap();
        assert!(parts.len() == 3 && parts.iter().all(|part| keys(part) == cells), "{row}");
        let curve = &row["curve"];
        assert_eq!(keys(curve), ["cells", "mean", "sem"]);
        assert!(["cells", "mean", "sem"].iter().all(|key| curve[key].as_array().unwrap().len() == 61));
        assert_eq!(curve["cells"][60], 60.0);
    }
    let area = |row: &Value| row["auc_f1"]["mean"].as_f64().unwrap();
    assert!(area(&rows[1]) > area(&rows[0]), "{rows:?}");
}

#[test]
fn the_area_is_the_mean_of_the_curve() {
    let rows = rows(&Place::new(), &["--policies", "path", "--seeds", "3", "--budget", "60"]);
    let curve: Vec<f64> =
        rows[0]["curve"]["mean"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
    // Robots move whole cells here, so that F1 is constant from each cell to the next.
    let mean = curve[..60].iter().sum::<f64>() / 60.0;
    assert!((rows[0]["auc_f1"]["mean"].as_f64().unwrap() - mean).abs() < 1e-9);
}

#[test]
fn average_recall_is_that_of_the_episodes() {
    let place = Place::new();
    let rows = rows(&place, &["--policies", "path", "--seeds", "3", "--budget", "60"]);
    let scenario = Scenario::load(&place.path("small.toml")).unwrap();
    let scenario = scenario.with_policy(PolicyName::Path).unwrap().with_budget_cells(60).unwrap();
    let recall = |seed| episode::run(&scenario, seed, End::AllFound).unwrap().outcome.recall.mean_until(60.0);
    let mean = (0..3).map(recall).sum::<f64>() / 3.0;
    assert!((rows[0]["average_recall"]["mean"].as_f64().unwrap() - mean).abs() < 1e-12);
    assert!((rows[0]["auc_f1"]["mean"].as_f64().unwrap() - mean).abs() > 1e-3);
}

#[test]
fn a_search_that_ends_at_rest_has_a_tail_and_leaves_the_expected_number() {
    let arguments = ["--policies", "path", "--seeds", "3", "--budget", "10000"];
    let ended = |end: &str| rows(&Place::new(), &[&arguments[..], &["--end", end]].concat()).remove(0);
    let (found, resting) = (ended("all_found"), ended("resting"));
    let mean = |row: &Value, key: &str| row[key]["mean"].as_f64().unwrap();
    assert!(mean(&found, "tail_s") < mean(&resting, "tail_s"), "{found} {resting}");
    assert!((0.0..=0.05).contains(&mean(&resting, "expected_remaining")), "{resting}");
    assert_eq!(resting["seeds_with_remaining"] == 0, mean(&resting, "remaining") < f64::MIN_POSITIVE);
    assert_eq!(found["cells_to_full_recall"], resting["cells_to_full_recall"]);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let place = Place::new();
    let with = |threads| rows(&place, &["--policies", "guts,path", "--seeds", "2..6", "--threads", threads]);
    assert_eq!(with("1"), with("2"));
}

#[test]
fn one_seed_has_no_standard_error() {
    let rows = rows(&Place::new(), &["--policies", "path", "--seeds", "7..8"]);
    assert_eq!(rows[0]["auc_f1"]["sem"], Value::Null);
    assert_eq!(rows[0]["curve"]["sem"][0], Value::Null);
}

#[test]
fn an_unreached_recall_has_no_mean() {
    let rows =
        rows(&Place::new(), &["--policies", "coverage", "--seeds", "2", "--robots", "1", "--budget", "1"]);
    let full = &rows[0]["cells_to_full_recall"];
    assert_eq!((&full["mean"], &full["reached"]), (&Value::Null, &0.into()));
    assert_eq!((&full["restricted_mean"], &full["restricted_sem"]), (&1.0.into(), &0.0.into()));
}

#[test]
fn the_table_is_aligned_and_explains_how_episodes_end() {
    let place = Place::new();
    let text =
        place.succeed(&["compare", "small.toml", "--policies", "greedy,path-additive", "--seeds", "3"]);
    assert!(text.contains("An episode ends when"), "{text}");
    let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("path-additive")).collect();
    let heads: Vec<&str> =
        text.lines().filter(|line| line.starts_with("policy") || line.starts_with("less")).collect();
    assert_eq!((lines.len(), heads.len()), (3, 3), "{text}");
    for (line, head) in lines.iter().zip(heads).take(2) {
        assert_eq!(line.chars().count(), head.chars().count(), "{text}");
        assert!(line.contains(" ± "), "{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(text.contains("small: 2 robots, ") && text.contains("budget 60 cells\n"), "{text}");
}

#[test]
fn policies_take_parameters_and_are_compared_with_a_baseline() {
    let place = Place::new();
    let with = |more: &[&str]| {
        let policies = "path,path( path_length_weight = 1 ),tour(evaluations=10)";
        place.json(
            &[&["compare", "small.toml", "--json", "--policies", policies, "--seeds", "6"], more].concat(),
        )
    };
    let report = with(&[]);
    let rows = report["rows"].as_array().unwrap();
    let labels: Vec<&Value> = rows.iter().map(|row| &row["policy"]).collect();
    assert_eq!(labels, ["path", "path(path_length_weight=1)", "tour(evaluations=10)"]);
    let row = |label: &str| rows.iter().find(|row| row["policy"] == label).unwrap();
    let differences = report["differences"].as_array().unwrap();
    assert_eq!(differences.len(), 2);
    for difference in differences {
        assert_eq!((&difference["scenario"], &difference["baseline"]), (&"small".into(), &"path".into()));
        for (key, mean) in
            [("cells_to_full_recall", "restricted_mean"), ("average_recall", "mean"), ("auc_f1", "mean")]
        {
            let of = |label: &str| row(label)[key][mean].as_f64().unwrap();
            let interval = &difference[key];
            let found = interval["mean"].as_f64().unwrap();
            assert!((found - (of(difference["policy"].as_str().unwrap()) - of("path"))).abs() < 1e-9);
            let [low, high] = ["low", "high"].map(|end| interval[end].as_f64().unwrap());
            assert!(low <= found && found <= high, "{difference}");
            assert_eq!(interval["verdict"].is_null(), low <= 0.0 && high >= 0.0, "{difference}");
        }
    }
    let other = with(&["--baseline", "tour(evaluations = 10)"]);
    assert_eq!(other["differences"][0]["baseline"], "tour(evaluations=10)");
    place.refuse(
        &["compare", "small.toml", "--policies", "path,greedy", "--baseline", "tour"],
        &["--baseline tour", "path, greedy"],
    );
}

#[test]
fn tables_and_curves_are_written_where_asked() {
    let place = Place::new();
    let arguments =
        ["--policies", "greedy,path", "--seeds", "2", "--density", "0.05", "--out", "deep/results"];
    let rows = rows(&place, &arguments);
    let read = |name: &str| fs::read_to_string(place.path("deep/results").join(name)).unwrap();
    assert_eq!(read("summary.csv").lines().count(), 3);
    assert_eq!(read("episodes.csv").lines().count(), 5);
    assert_eq!(read("differences.csv").lines().count(), 2);
    let points = rows[0]["curve"]["cells"].as_array().unwrap().len();
    assert_eq!(read("curves.csv").lines().count(), 1 + 2 * points);
    let drawing = read("small.svg");
    assert!(
        ["<svg", "Path length", "F1", "greedy", "path", "<polygon"].iter().all(|part| drawing.contains(part))
    );
}

#[test]
fn a_bound_stands_beside_the_policies() {
    let place = Place::new();
    let arguments = ["compare", "small.toml", "--policies", "greedy,path", "--seeds", "3", "--bound"];
    let report = place.json(&[&arguments[..], &["--json", "--out", "results"]].concat());
    let bounds = report["bounds"].as_array().unwrap();
    assert_eq!(bounds.len(), 2);
    for (gap, row) in bounds.iter().zip(report["rows"].as_array().unwrap()) {
        assert_eq!(keys(gap), ["above_percent", "bound_cells", "cells", "policy", "scenario"]);
        assert_eq!((&gap["scenario"], &gap["policy"]), (&row["scenario"], &row["policy"]));
        assert_eq!(gap["cells"], row["cells_to_full_recall"]["restricted_mean"]);
        let [bound, cells, above] =
            ["bound_cells", "cells", "above_percent"].map(|key| gap[key].as_f64().unwrap());
        assert!(bound > 1.0 && bound < 60.0, "{gap}");
        assert!((bound * (1.0 + above / 100.0) - cells).abs() < 1e-9, "{gap}");
    }
    assert_eq!(fs::read_to_string(place.path("results/bounds.csv")).unwrap().lines().count(), 3);
    let text = place.succeed(&arguments);
    assert!(text.contains("Proven: no policy needs fewer than "), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let small = fs::read_to_string(place.path("small.toml")).unwrap();
    place.write("known.toml", &small.replace("count = 4", "cells = [[1, 1]]"));
    let refused = ["compare", "known.toml", "--policies", "path", "--bound"];
    place.refuse(&refused, &["--bound: small: objects in given cells", "objects.density or objects.count"]);
}
