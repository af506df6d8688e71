//! Weights files that a scenario names.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use dragnet_learn::network::Network;
use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_learn::shape::Shape;
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_scenario::{Policy, Scenario, ScenarioError};
use dragnet_search::policy::PolicyName as Exact;
use tempfile::TempDir;

const GNN: PolicyName = PolicyName::Learned(Shipped::General);

/// Weights that differ by the scale.
fn weights(scale: f32) -> Weights {
    let fill = |_: &str, shape: &[usize]| {
        let count = u16::try_from(shape.iter().product::<usize>()).unwrap();
        (0..count).map(|place| (f32::from(place) * scale).sin()).collect()
    };
    Weights::build(Shape::DEFAULT, Recipe::default(), fill).unwrap()
}

/// A folder with `a.toml`, which is yet to be written, and the weights `nets/mine.safetensors`.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self { folder: TempDir::new().unwrap() };
        fs::create_dir(place.path("nets")).unwrap();
        fs::write(place.path("nets/mine.safetensors"), weights(0.1).to_bytes().unwrap()).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// With this table of robots in the last lines, from line 9 on.
    fn load(&self, robots: &str) -> Result<Scenario, ScenarioError> {
        let text = format!(
            "name = 'a'\n[map]\nshape = 'all_traversable'\nrows = 12\ncolumns = 12\n\
             [objects]\ncount = 1\n[robots]\n{robots}\n[mission]\nbudget_meters = 300\n"
        );
        fs::write(self.path("a.toml"), text).unwrap();
        Scenario::load(&self.path("a.toml"))
    }

    /// The robots are rejected with this message.
    fn refuse(&self, robots: &str, said: &[&str]) {
        let error = self.load(robots).unwrap_err().to_string();
        assert!(said.iter().all(|said| error.contains(said)), "{error}\n{robots}");
    }
}

fn network(scale: f32) -> Arc<Network> {
    Arc::new(Network::new(&weights(scale)))
}

fn networks(scenario: &Scenario) -> Vec<Option<Arc<Network>>> {
    scenario.robots().iter().map(|robot| robot.policy.network.clone()).collect()
}

#[test]
fn weights_are_relative_to_the_scenario_and_each_robot_may_have_its_own() {
    let place = Place::new();
    let other = place.path("other.safetensors");
    fs::write(&other, weights(0.2).to_bytes().unwrap()).unwrap();
    let scenario = place
        .load(&format!(
            "count = 4\npolicy = {{ name = 'gnn', weights = 'nets/mine.safetensors', replan_after_cells = 3 }}\n\
             [[robots.robot]]\nnumber = 2\npolicy = {{ name = 'gnn', weights = '{}' }}\n\
             [[robots.robot]]\nnumber = 3\npolicy = 'gnn'\n",
            other.display()
        ))
        .unwrap();
    assert_ne!(network(0.1), network(0.2));
    let (mine, other) = (Some(network(0.1)), Some(network(0.2)));
    assert_eq!(networks(&scenario), [mine.clone(), other, None, mine]);
    assert!(scenario.robots().iter().all(|robot| robot.policy.name == GNN));
    assert_eq!(scenario.robots()[3].policy.replan_after_cells.unwrap().get(), 3);
}

#[test]
fn unreadable_weights_name_the_key_the_file_and_the_reason() {
    let place = Place::new();
    let policy = |file: &str| format!("policy = {{ name = 'gnn', weights = '{file}' }}");
    let key = "line 9: robots.policy.weights: ";
    place.refuse(&policy("no.safetensors"), &[key, "no.safetensors: ", "No such file"]);
    place.refuse(&policy("nets"), &[key, "nets: "]);
    place.refuse(&policy("a.toml"), &[key, "a.toml: no weights file"]);
    let bytes = fs::read(place.path("nets/mine.safetensors")).unwrap();
    for kept in [0, 7, bytes.len() / 2, bytes.len() - 1] {
        fs::write(place.path("cut.safetensors"), &bytes[..kept]).unwrap();
        place.refuse(&policy("cut.safetensors"), &[key, "cut.safetensors: ", "truncated"]);
    }
    place.refuse(
        &format!("[[robots.robot]]\nnumber = 1\n{}", policy("no.safetensors")),
        &["a.toml, line 11: robots.robot[0].policy.weights: ", "no.safetensors"],
    );
}

#[test]
fn only_the_general_network_takes_weights() {
    let place = Place::new();
    for name in ["path", "gnn-path", "random"] {
        place.refuse(
            &format!("policy = {{ name = '{name}', weights = 'nets/mine.safetensors' }}"),
            &[
                "a.toml, line 9: robots.policy.weights is ",
                &format!("\"nets/mine.safetensors\" for {name}"),
                "gnn only",
            ],
        );
    }
    place.refuse(
        "policy = { name = 'gnn', weights = 3 }",
        &["line 9: robots.policy.weights: ", "integer `3`"],
    );
}

#[test]
fn weights_of_the_command_line_are_those_of_every_robot() {
    let place = Place::new();
    let scenario = place.load("count = 2\n[[robots.robot]]\nnumber = 2\npolicy = 'greedy'\n").unwrap();
    let changed = scenario.with_weights(&place.path("nets/mine.safetensors")).unwrap();
    assert_eq!(networks(&changed), [Some(network(0.1)), Some(network(0.1))]);
    assert!(changed.robots().iter().all(|robot| robot.policy.name == GNN));
    // Other processes receive the scenario as text, which must be complete wherever they read it.
    let text = toml::to_string(changed.file()).unwrap();
    let elsewhere = Scenario::from_text(Path::new("elsewhere/b.toml"), text).unwrap();
    assert_eq!((elsewhere.robots(), elsewhere.file()), (changed.robots(), changed.file()));
    let plain = Policy::from(PolicyName::from(Exact::Path));
    assert!(changed.with_policy(Exact::Path).unwrap().robots().iter().all(|robot| robot.policy == plain));
}

#[test]
fn a_relative_path_of_the_command_line_is_one_in_the_working_directory() {
    let place = Place::new();
    let scenario = place.load("count = 2").unwrap();
    let error = scenario.with_weights(Path::new("nets/mine.safetensors")).unwrap_err().to_string();
    let file = std::env::current_dir().unwrap().join("nets/mine.safetensors");
    let said = format!("changed on the command line: robots.policy.weights: {}: cannot", file.display());
    assert!(error.contains(&said), "{error}");
}
