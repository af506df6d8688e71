use super::*;
use crate::plan::tests::{areas, plan};

fn problems(plan: &MissionPlan) -> Vec<Problem> {
    let problems = plan.review().problems;
    assert_eq!(plan.scenario().is_ok(), problems.is_empty());
    problems
}

#[test]
fn a_whole_plan_says_what_comes_of_it() {
    let mut plan = plan();
    plan.scenario.robots.count = 3;
    let review = plan.review();
    assert_eq!((&review.problems, &review.warnings), (&vec![], &vec![]));
    let size = review.size.unwrap();
    assert_eq!((size.rows, size.columns), (56, 56));
    assert!(size.traversable < size.searched && size.searched <= 56 * 56, "{size:?}");
    assert_eq!(review.suggested_cell_meters, Some(20.0));
    let poas: Vec<_> =
        review.effects.iter().filter_map(|effect| Some((effect.name.as_deref(), effect.poa?))).collect();
    assert_eq!(poas[..2], [(Some("Hut"), 0.5), (Some("Bench"), 0.2)]);
    assert!(poas[2].0.is_none() && (poas[2].1 - 0.3).abs() < 1e-9, "{poas:?}");
    // Robots start at the places in turn, in the middle of a cell.
    let starts: Vec<[f64; 2]> = review.starts.iter().map(|start| start.unwrap()).collect();
    assert!((starts[0][1] - 0.0005).abs() < 2e-4 && (starts[1][1] - 0.0095).abs() < 2e-4, "{starts:?}");
    assert_eq!(starts[0].map(f64::to_bits), starts[2].map(f64::to_bits));
}

#[test]
fn a_problem_stands_where_it_is() {
    let check = |change: &dyn Fn(&mut MissionPlan), at: Place, words: &[&str]| {
        let mut plan = plan();
        change(&mut plan);
        let found = problems(&plan);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].at, at, "{found:?}");
        for word in words {
            assert!(found[0].message.contains(word), "{word}: {found:?}");
        }
        assert!(!found[0].message.contains(DRAWN), "{found:?}");
    };
    let key = |key: &str| Place::Key(key.to_owned());
    check(&|plan| plan.scenario.robots.count = 0, key("robots.count"), &["0 is not", "1 to 1000"]);
    check(
        &|plan| plan.scenario.mission.speed_meters_per_second = 0.0,
        key("mission.speed_meters_per_second"),
        &["0.001"],
    );
    check(&|plan| plan.scenario.mission.budget_seconds = Some(-1.0), key("mission.budget_seconds"), &["-1"]);
    // Clearing the only budget of a plan is a problem of a table, which has no field.
    check(&|plan| plan.scenario.mission.budget_seconds = None, key("mission"), &["time budget", "distance"]);
    check(&|plan| plan.scenario.map.cell_meters = 0.0, key("map.cell_meters"), &["0.001"]);
    check(&|plan| plan.scenario.sensor.radius = 60, key("sensor.radius"), &["1 to 56"]);
    check(&|plan| plan.scenario.name = "../a".to_owned(), key("name"), &["letters"]);
    check(&|plan| plan.features.truncate(0), Place::Map, &["no search area yet"]);
    check(&|plan| plan.scenario.map.cell_meters = 1e5, Place::Map, &["without a traversable cell"]);
    let set = |number: usize, from: &'static str, to: &'static str| {
        move |plan: &mut MissionPlan| {
            plan.features[number] = plan.features[number].to_string().replace(from, to).parse().unwrap();
        }
    };
    check(&set(2, "0.5", "25"), Place::Feature(2), &["poa is 25", "0 to 1"]);
    check(&set(2, "prior", "priority"), Place::Feature(2), &["priority", "last_known_position"]);
    check(&set(4, "0.0005", "95.0"), Place::Feature(4), &["95", "latitude"]);
    check(&set(3, "80", "-80"), Place::Feature(3), &["spread_meters is -80"]);
    // A bow tie.
    check(&set(0, "[0.01,0.01],[0.0,0.01]", "[0.0,0.01],[0.01,0.01]"), Place::Feature(0), &["ring"]);
}

#[test]
fn each_wrong_feature_has_its_problem_and_overlaps_are_told() {
    let mut plan = plan();
    plan.features[1].properties = None;
    plan.features[1].geometry = None;
    plan.features[2] = plan.features[2].to_string().replace("0.5", "2").parse().unwrap();
    let places: Vec<Place> = problems(&plan).into_iter().map(|problem| problem.at).collect();
    assert_eq!(places, [Place::Feature(1), Place::Feature(2)]);
    let mut plan = MissionPlan::of_areas("moor", &areas()).unwrap();
    let [first, ..] = &areas().areas[..] else { panic!() };
    plan.features.push(first.feature());
    let review = plan.review();
    assert!(review.problems.is_empty(), "{review:?}");
    assert!(review.warnings.iter().any(|it| it.starts_with("search areas overlap")), "{review:?}");
}

#[test]
fn ground_out_of_sight_has_a_place_on_the_earth() {
    let mut plan = plan();
    // A wall with a wide band of ground behind it.
    plan.features[1] =
        r#"{"type":"Feature","properties":{"kind":"no_go","name":"Pond"},"geometry":{"type":"Polygon",
        "coordinates":[[[0.006,-0.001],[0.0065,-0.001],[0.0065,0.011],[0.006,0.011],[0.006,-0.001]]]}}"#
            .parse()
            .unwrap();
    plan.scenario.robots.count = 1;
    plan.scenario.sensor.radius = 5;
    let review = plan.review();
    let warning = review.warnings.iter().find(|it| it.contains("out of every robot's sight")).unwrap();
    assert!(warning.contains("the first one at 0.000") && !warning.contains('['), "{warning}");
    let parts = "the area is in 2 parts that no way connects; 1 has no robot";
    assert!(review.warnings.iter().any(|it| it.starts_with(parts)), "{review:?}");
    let [[south, west, north, east]] = review.unseen[..] else { panic!("{:?}", review.unseen) };
    assert!(south.abs() < 2e-4 && (north - 0.01).abs() < 3e-4, "{south} to {north}");
    assert!((0.0065..0.008).contains(&west) && (east - 0.01).abs() < 3e-4, "{west} to {east}");
    // A start in the wall is moved to a place, not to a cell.
    plan.features[4] =
        plan.features[4].to_string().replace("[0.0005,0.0005]", "[0.00625,0.005]").parse().unwrap();
    let warnings = plan.review().warnings.join("; ");
    assert!(warnings.contains("start in the nearest one, at 0.00") && !warnings.contains('['), "{warnings}");
}
