//! The settings of episodes, as named in tables.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use dragnet_scenario::Scenario;
use dragnet_scenario::file::{PolicyField, RecordingTable, RobotsTable, ScenarioFile, ZenohTable};
use dragnet_search::evidence::Digest;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use crate::simulation::End;

/// Approximate maximum number of points of a curve.
const MAX_POINTS: f64 = 1000.0;

/// One policy on one scenario, as named in tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Name of the scenario.
    pub scenario: String,
    /// The built-in shape, or the map's file without folder and extension.
    pub map: String,
    /// Label of the robots' policy.
    pub policy: String,
    /// Robots in the team.
    pub robots: usize,
    /// The objects, in words.
    pub objects: String,
    /// Path length that each robot may drive.
    pub budget_cells: f64,
    /// When an episode ends.
    pub end: End,
    /// Digest of everything that determines an episode, except its seed and the program: 32 hexadecimal digits.
    pub digest: String,
}

impl Setting {
    /// The setting of a scenario whose robots use the policy of the label; an episode ends when every object is found,
    /// as the paper's trials do.
    #[must_use]
    pub fn new(scenario: &Scenario, policy: String) -> Self {
        Self {
            scenario: scenario.name().to_owned(),
            map: map_name(scenario.file()),
            policy,
            robots: scenario.robots().len(),
            objects: scenario.objects().to_string(),
            budget_cells: scenario.budget_cells(),
            end: End::AllFound,
            digest: digest(scenario).to_string(),
        }
    }

    /// Path lengths (cells) at which curves are sampled: from 0 on every cell of the budget, or every few of a large
    /// one; the budget last.
    #[must_use]
    pub fn lengths(&self) -> Vec<f64> {
        let step = (self.budget_cells / MAX_POINTS).ceil().max(1.0);
        let steps = std::iter::successors(Some(0.0), |length| Some(length + step));
        steps.take_while(|&length| length < self.budget_cells).chain([self.budget_cells]).collect()
    }
}

/// `path on small`
impl fmt::Display for Setting {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} on {}", self.policy, self.scenario)
    }
}

fn map_name(file: &ScenarioFile) -> String {
    let stem =
        || file.map.file.as_ref().and_then(|file| Some(Path::new(file).file_stem()?.to_string_lossy()));
    file.map.shape.clone().or_else(|| stem().map(Into::into)).unwrap_or_default()
}

/// XXH3-128 of the scenario with its overrides, and of the map, the prior and the networks that it may read from files.
#[must_use]
pub fn digest(scenario: &Scenario) -> Digest {
    let mut file = ScenarioFile {
        recording: RecordingTable::default(),
        zenoh: ZenohTable::default(),
        ..scenario.file().clone()
    };
    forget_places_of_weights(&mut file.robots);
    let (terrain, prior) = (scenario.terrain(), scenario.prior());
    let mut hash = Xxh3::new();
    // It names every field, in the same way for the same program.
    hash.update(format!("{file:?}").as_bytes());
    for cell in terrain.grid().cells() {
        hash.update(&[u8::from(terrain.is_traversable(cell)), u8::from(terrain.is_searched(cell))]);
        // In f32, where rounding differences of a machine's logarithm disappear.
        #[expect(clippy::cast_possible_truncation, reason = "that is what it is for")]
        hash.update(&(prior.log_odds_nats(cell) as f32).to_le_bytes());
    }
    let mut networks: Vec<_> =
        scenario.robots().iter().filter_map(|robot| robot.policy.network.as_ref()).collect();
    // A whole team may share one.
    networks.dedup_by(|a, b| Arc::ptr_eq(a, b));
    for network in networks {
        hash.update(format!("{network:?}").as_bytes());
    }
    Digest(hash.digest128())
}

/// The content of weights counts, not their paths.
fn forget_places_of_weights(robots: &mut RobotsTable) {
    let own = robots.robot.iter_mut().filter_map(|robot| robot.policy.as_mut());
    for policy in own.chain([&mut robots.policy]) {
        if let PolicyField::Table(table) = policy {
            table.weights = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_learn::shape::Shape;
    use dragnet_learn::weights::{Recipe, Weights};

    use super::*;

    fn setting(budget_cells: f64) -> Setting {
        Setting { budget_cells, ..of("cells = [[1, 1]]", "") }
    }

    fn of(objects: &str, rest: &str) -> Setting {
        let text = format!(
            "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 5, columns = 5 }}\nsensor.radius = 2\n\
             objects = {{ {objects} }}\nmission.budget_meters = 600.0\n{rest}"
        );
        Setting::new(&Scenario::from_text(Path::new("a.toml"), text).unwrap(), "path".to_owned())
    }

    #[test]
    fn a_curve_is_read_at_every_cell_and_at_the_budget() {
        assert_eq!(setting(2.5).lengths(), [0.0, 1.0, 2.0, 2.5]);
        assert_eq!(setting(2.0).lengths(), [0.0, 1.0, 2.0]);
        assert_eq!(setting(0.4).lengths(), [0.0, 0.4]);
        let large = setting(12_345.0).lengths();
        assert_eq!((large[1], large.len()), (13.0, 951));
    }

    #[test]
    fn a_digest_depends_on_what_determines_an_episode_and_nothing_else() {
        let digest = |objects: &str, rest: &str| of(objects, rest).digest;
        let first = digest("count = 2", "");
        assert_eq!(first, digest("count = 2", "# a remark\nrecording.belief_period_seconds = 3.0\n"));
        assert_ne!(first, digest("count = 3", ""));
        assert_ne!(first, digest("count = 2", "prior.probability = 0.3\n"));
        assert_ne!(first, digest("count = 2", "network.loss = 0.1\n"));
    }

    #[test]
    fn the_content_of_files_counts_and_not_their_names_alone() {
        let folder = tempfile::tempdir().unwrap();
        let digest = |map: &str, prior: &str| {
            std::fs::write(folder.path().join("map.txt"), map).unwrap();
            std::fs::write(folder.path().join("prior.csv"), prior).unwrap();
            let text = "name = 'a'\nmap.file = 'map.txt'\nprior.file = 'prior.csv'\nsensor.radius = 1\n\
                        objects.count = 1\nmission.budget_meters = 60.0\n";
            let scenario = Scenario::from_text(&folder.path().join("a.toml"), text.to_owned()).unwrap();
            Setting::new(&scenario, "path".to_owned()).digest
        };
        let first = digest("....\n", "0.1,0.1,0.1,0.1\n");
        assert_eq!(first, digest("....\n", "0.1,0.1,0.1,0.10\n"));
        assert_ne!(first, digest("..,.\n", "0.1,0.1,0.0,0.1\n"));
        assert_ne!(first, digest("....\n", "0.1,0.1,0.1,0.2\n"));
    }

    #[test]
    fn the_content_of_weights_counts_and_not_their_path() {
        let folder = tempfile::tempdir().unwrap();
        let digest = |file: &str, value: f32| {
            let fill = |_: &str, shape: &[usize]| vec![value; shape.iter().product()];
            let weights = Weights::build(Shape::DEFAULT, Recipe::default(), fill).unwrap();
            let path = folder.path().join(file);
            std::fs::write(&path, weights.to_bytes().unwrap()).unwrap();
            let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 5, columns = 5 }\n\
                        sensor.radius = 2\nobjects.count = 1\nmission.budget_meters = 60.0\n";
            let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
            Setting::new(&scenario.with_weights(&path).unwrap(), "gnn".to_owned()).digest
        };
        let first = digest("a.safetensors", 0.1);
        assert_eq!(first, digest("b.safetensors", 0.1));
        assert_ne!(first, digest("a.safetensors", 0.2));
    }
}
