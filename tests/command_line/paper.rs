//! `dragnet paper`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::Place;

/// Files of a folder by name.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let read = |entry: fs::DirEntry| {
        (entry.file_name().into_string().unwrap(), fs::read_to_string(entry.path()).unwrap())
    };
    fs::read_dir(folder).unwrap().map(|entry| read(entry.unwrap())).collect()
}

/// The report and its files, for two seeds that were not used for training.
fn report(experiment: &str) -> (String, BTreeMap<String, String>) {
    let place = Place::new();
    let said = place.succeed(&["paper", experiment, "--seeds", "2", "--out", "deep/report"]);
    assert_eq!(said, "written: deep/report/report.html\n");
    let mut files = files(&place.path("deep/report"));
    (files.remove("report.html").unwrap(), files)
}

/// Names of the elements of a page in order; panics unless the page is well-formed XML.
fn elements(page: &str) -> Vec<&str> {
    let (mut open, mut seen) = (Vec::new(), Vec::new());
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    for markup in body.split('<').skip(1) {
        let (tag, text) = markup.split_once('>').unwrap();
        assert!(!text.contains('>') || seen.last() == Some(&"style"), "{markup}");
        let mut entities = markup.split('&').skip(1);
        assert!(entities.all(|it| ["amp;", "lt;", "gt;", "quot;"].iter().any(|known| it.starts_with(known))));
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap();
        check_attributes(tag);
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else {
            seen.push(name);
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
    seen
}

/// Checks that every attribute has a value, in quotes.
fn check_attributes(tag: &str) {
    let mut outside: Vec<&str> = tag.split('"').step_by(2).collect();
    let rest = outside.pop().unwrap();
    assert!(outside.iter().all(|it| it.ends_with('=')) && !rest.contains('='), "{tag}");
}

/// Checks that a page is self-contained and accessible, and says how it was made.
fn check(page: &str, experiment: &str) {
    let elements = elements(page);
    let count = |name: &str| elements.iter().filter(|&&element| element == name).count();
    assert_eq!((count("script"), count("link"), count("img"), count("iframe")), (0, 0, 0, 0));
    for reference in ["src=", "url(", "@import", "href=\"http", "href=\"/"] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(count("table") > 0);
    assert_eq!(count("caption"), count("table"));
    assert_eq!(count("figcaption"), count("figure"));
    assert_eq!(page.matches("<svg").count(), page.matches("role=\"img\"").count());
    for said in [
        &format!("dragnet paper {experiment} --seeds 1000..1002 --out DIR") as &str,
        "2 seeds (1000 to 1001)",
        "<h2>What holds</h2>",
        "claims hold",
        "Differences from the paper's set-up",
        "radius 5 cells; variance 0.005",
    ] {
        assert!(page.contains(said), "{said}");
    }
}

#[test]
fn figure_8_shows_beliefs_and_tracks_on_a_self_contained_page() {
    let (page, files) = report("figure-8");
    check(&page, "figure-8");
    assert_eq!(page.matches("<figure class=\"panel\">").count(), 1 + 2 * 6);
    for said in ["greedy, decision 2, ", "path, decision 9, ", "guts, decision 9, ", "entered again"] {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("Table I:"), "only what was asked for");
    assert_eq!(files.keys().collect::<Vec<_>>(), ["figure-8.csv"]);
    assert_eq!(files["figure-8.csv"].lines().count(), 1 + 6 * 2);
}

#[test]
fn table_3_is_driven_again_to_the_byte_by_any_number_of_threads() {
    let (page, files) = report("table-3");
    check(&page, "table-3");
    for said in
        ["<td>05:15</td>", "<td>2.86</td>", "<code>path</code>, 3 robots", "30 s a waypoint", "74,857"]
    {
        assert!(page.contains(said), "{said}");
    }
    assert_eq!(files.keys().collect::<Vec<_>>(), ["table-3.csv"]);
    let lines: Vec<&str> = files["table-3.csv"].lines().collect();
    assert_eq!(lines.len(), 1 + (3 + 2) * 8);
    assert!(
        lines[0].starts_with("configuration,seed,policy,robots,")
            && lines[1].starts_with("A,90001,nats,1,0,")
    );
    let place = Place::new();
    place.succeed(&["paper", "table-3", "--seeds", "1", "--threads", "1", "--out", "one"]);
    let one = fs::read_to_string(place.path("one/table-3.csv")).unwrap();
    assert_eq!(one.lines().collect::<Vec<_>>(), lines[..=(3 + 1) * 8]);
}

#[test]
fn table_2_stands_beside_the_papers_own() {
    let (page, files) = report("table-2");
    check(&page, "table-2");
    for printed in ["0.7960", "0.7425", "0.7292", "0.7366", "0.7538", "+1.2 %"] {
        assert!(page.contains(&format!("<td>{printed}</td>")), "{printed}");
    }
    for policy in ["greedy", "gnn-greedy-four", "random", "coverage", "nats", "guts"] {
        assert!(page.contains(&format!("<code>{policy}</code>")), "{policy}");
    }
    assert!(page.contains("Cells to full recall: ") && page.contains("Gap closed: "));
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(names, ["table-2-episodes.csv", "table-2-summary.csv"]);
    // Four maps, nine policies, two seeds.
    assert_eq!(files["table-2-episodes.csv"].lines().count(), 1 + 4 * 9 * 2);
}

#[test]
fn beyond_the_paper_there_are_tours_a_bound_and_a_team() {
    let (page, files) = report("beyond");
    assert!(elements(&page).contains(&"svg") && !page.contains("What holds"));
    for said in
        ["gnn-tour", "path(path_length_weight=1)", "no policy needs fewer than", "99 % ms", "A team of 8"]
    {
        assert!(page.contains(said), "{said}");
    }
    let maps = ["at", "four", "icc", "oa"].map(|map| format!("beyond-{map}.svg"));
    let tables =
        ["curves", "summary-few", "summary-many", "summary-team"].map(|it| format!("beyond-{it}.csv"));
    let mut names = [maps, tables].concat();
    names.sort_unstable();
    assert_eq!(files.keys().cloned().collect::<Vec<_>>(), names);
    // Four maps, five policies; two policies of a team.
    assert_eq!(files["beyond-summary-many.csv"].lines().count(), 1 + 4 * 5);
    assert_eq!(files["beyond-summary-team.csv"].lines().count(), 1 + 2);
    for policy in ["path", "tour", "gnn"] {
        assert!(files["beyond-at.svg"].contains(policy), "{policy}");
    }
}

/// A table without the columns of times.
fn without_times(csv: &str) -> Vec<Vec<&str>> {
    let titles: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let is_kept = |column: &usize| !titles[*column].starts_with("decision_ms");
    csv.lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            (0..cells.len()).filter(is_kept).map(|column| cells[column]).collect()
        })
        .collect()
}

#[test]
fn the_same_seeds_give_the_same_numbers() {
    for experiment in ["figure-8", "table-2"] {
        let (first, again) = (report(experiment).1, report(experiment).1);
        assert_eq!(first.keys().collect::<Vec<_>>(), again.keys().collect::<Vec<_>>());
        for (name, table) in &first {
            assert_eq!(without_times(table), without_times(&again[name]), "{name}");
        }
    }
}

#[test]
fn an_older_report_is_replaced_as_a_whole() {
    let place = Place::new();
    fs::create_dir(place.path("report")).unwrap();
    place.write("report/report.html", "older");
    place.write("report/mine.txt", "mine");
    place.succeed(&["paper", "figure-8", "--seeds", "5000..5001", "--out", "report"]);
    let files = files(&place.path("report"));
    assert_eq!(files.keys().collect::<Vec<_>>(), ["figure-8.csv", "mine.txt", "report.html"]);
    check_one_seed(&files["report.html"]);
}

/// With one seed nothing has a standard error.
fn check_one_seed(page: &str) {
    elements(page);
    assert!(page.contains("seed 5000") && !page.contains('±') && !page.contains("NaN"));
}

#[test]
fn seeds_that_were_used_before_are_warned_of() {
    let place = Place::new();
    let output = place.dragnet(&["paper", "figure-8", "--seeds", "0..1", "--out", "report"]);
    assert!(output.status.success());
    let warning = super::stderr(&output);
    assert!(warning.starts_with("warning: --seeds: seed 0: ") && warning.contains("tune"), "{warning}");
    assert!(fs::read_to_string(place.path("report/report.html")).unwrap().contains("seed 0: some of them"));
}

#[test]
fn impossible_requests_are_rejected_before_the_work() {
    let place = Place::new();
    fs::create_dir_all(place.path("taken/report.html")).unwrap();
    for (arguments, said) in [
        (&["paper"] as &[&str], &["--out"] as &[&str]),
        (&["paper", "table-4", "--out", "report"], &["table-4", "table-2", "figure-9", "table-3", "all"]),
        (&["paper", "--out", "small.toml"], &["--out small.toml", "cannot make the folder"]),
        (&["paper", "--out", "small.toml/deep"], &["--out small.toml/deep"]),
        (&["paper", "--out", "taken"], &["--out taken", "taken/report.html is a folder"]),
        (&["paper", "--out", "report", "--seeds", "0"], &["--seeds", "a number of seeds"]),
        (&["paper", "--out", "report", "--seeds", "9..3"], &["--seeds", "9..3"]),
        (&["paper", "--out", "report", "--threads", "0"], &["--threads", "1..=1024"]),
    ] {
        place.refuse(arguments, said);
    }
    assert!(!place.path("report").exists());
}
