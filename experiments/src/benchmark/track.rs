//! Tracks: searches and seeds that never change under one version.

use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_search::evidence::Digest;
use dragnet_search::generated::Generated;
use dragnet_sim::world::World;
use xxhash_rust::xxh3::Xxh3;

use crate::ExperimentError;
use crate::seeds::Seeds;

/// The first seed of episodes and generated maps. No parameter was tuned and no network was trained on seeds from here to
/// 99999.
const FIRST_SEED: u64 = 30_000;

/// Densities of objects: percent of the searched cells.
const PERCENTS: [u32; 2] = [1, 20];

/// The paper's maps.
const PAPER_MAPS: [&str; 4] = ["ice_cream_cone", "open_asterisk", "figure_four", "all_traversable"];

/// The definitions of all tracks, in the order in which they are listed. A track changes with its version
/// only; `FROZEN` in the tests holds the digests.
const PLANS: [Plan; 5] = [
    Plan {
        name: "smoke",
        version: 1,
        about: "one robot on two of the paper's maps, to try things out; no result to publish",
        robots: 1,
        maps: Maps::Named(&["ice_cream_cone", "open_asterisk"]),
        side: 30,
        budget_cells: 300,
        seeds: 3,
    },
    Plan {
        name: "single",
        version: 1,
        about: "one robot on the paper's four maps, 30 x 30 cells",
        robots: 1,
        maps: Maps::Named(&PAPER_MAPS),
        side: 30,
        budget_cells: 300,
        seeds: 50,
    },
    Plan {
        name: "generated",
        version: 1,
        about: "one robot on 100 generated maps (caves, blocks, rooms), 30 x 30 cells",
        robots: 1,
        maps: Maps::Generated(100),
        side: 30,
        budget_cells: 500,
        seeds: 1,
    },
    Plan {
        name: "team-3",
        version: 1,
        about: "three robots on the paper's four maps, 30 x 30 cells",
        robots: 3,
        maps: Maps::Named(&PAPER_MAPS),
        side: 30,
        budget_cells: 200,
        seeds: 30,
    },
    Plan {
        name: "team-8",
        version: 1,
        about: "eight robots on the paper's four maps, 60 x 60 cells",
        robots: 8,
        maps: Maps::Named(&PAPER_MAPS),
        side: 60,
        budget_cells: 300,
        seeds: 10,
    },
];

/// A track, from which its searches are made.
struct Plan {
    name: &'static str,
    version: u32,
    about: &'static str,
    robots: u32,
    maps: Maps,
    /// Rows and columns of each map.
    side: u32,
    /// Path length that each robot may drive.
    budget_cells: u32,
    /// Episodes of each search.
    seeds: u64,
}

/// The maps of a track.
enum Maps {
    /// Shapes of these names.
    Named(&'static [&'static str]),
    /// This many generated maps, of all kinds in turn.
    Generated(u64),
}

/// A frozen set of searches and seeds.
pub struct Track {
    name: &'static str,
    version: u32,
    about: &'static str,
    searches: Vec<Search>,
}

/// A scenario of a track and the seeds of its episodes.
pub struct Search {
    /// Its robots use a policy that the policy under test replaces.
    pub scenario: Scenario,
    /// The searches of one group, such as `caves, 1 %`, are summed up in one line.
    pub group: String,
    /// The seeds of its episodes.
    pub seeds: Seeds,
}

impl Track {
    /// Names of all tracks.
    pub fn names() -> impl Iterator<Item = &'static str> {
        PLANS.iter().map(|plan| plan.name)
    }

    /// The track of a name.
    ///
    /// # Errors
    /// If there is none: the names of all.
    pub fn named(name: &str) -> Result<Self, ExperimentError> {
        let plan = PLANS.iter().find(|plan| plan.name == name).ok_or_else(|| {
            let names: Vec<&str> = Self::names().collect();
            ExperimentError::Input(format!("track {name:?}: no such track; allowed are {}", names.join(", ")))
        })?;
        Ok(Self { name: plan.name, version: plan.version, about: plan.about, searches: plan.searches()? })
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// Its version. Results of two versions are not comparable.
    #[must_use]
    pub const fn version(&self) -> u32 {
        self.version
    }

    /// A summary.
    #[must_use]
    pub const fn about(&self) -> &'static str {
        self.about
    }

    /// Its searches, in the order of results.
    #[must_use]
    pub fn searches(&self) -> &[Search] {
        &self.searches
    }

    /// Each episode of one policy, by the index of its search and its seed, in the order of results.
    pub fn episodes(&self) -> impl Iterator<Item = (usize, u64)> {
        self.searches.iter().enumerate().flat_map(|(index, search)| {
            let seeds = search.seeds;
            (0..seeds.count()).map(move |place| (index, seeds.at(place)))
        })
    }

    /// XXH3-128 of its name and version, and of each search: the text of the scenario, the map, the prior, and of each
    /// seed the objects and the robots' start cells.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut hash = Xxh3::new();
        hash.update(format!("{} {}\n", self.name, self.version).as_bytes());
        for search in &self.searches {
            search.hash(&mut hash);
        }
        Digest(hash.digest128())
    }
}

impl Search {
    fn hash(&self, hash: &mut Xxh3) {
        let (terrain, prior) = (self.scenario.terrain(), self.scenario.prior());
        hash.update(self.scenario.source().text.as_bytes());
        for cell in terrain.grid().cells() {
            hash.update(&[u8::from(terrain.is_traversable(cell)), u8::from(terrain.is_searched(cell))]);
            // In f32, where rounding differences of a machine's logarithm disappear.
            #[expect(clippy::cast_possible_truncation, reason = "that is what it is for")]
            hash.update(&(prior.log_odds_nats(cell) as f32).to_le_bytes());
        }
        for place in 0..self.seeds.count() {
            let seed = self.seeds.at(place);
            let world = World::new(&self.scenario, seed);
            hash.update(&seed.to_le_bytes());
            let starts = self.scenario.robots().iter().map(|robot| world.body(robot.id).cell);
            for cell in world.truth().objects().iter().copied().chain(starts) {
                hash.update(&cell.number().to_le_bytes());
            }
        }
    }
}

impl Plan {
    fn searches(&self) -> Result<Vec<Search>, ExperimentError> {
        let mut searches = Vec::new();
        match self.maps {
            Maps::Named(shapes) => {
                for shape in shapes {
                    for percent in PERCENTS {
                        searches.push(self.search(shape, None, percent, FIRST_SEED)?);
                    }
                }
            }
            Maps::Generated(count) => {
                let kinds = Generated::ALL.iter().cycle();
                for (seed, kind) in (FIRST_SEED..FIRST_SEED + count).zip(kinds) {
                    for percent in PERCENTS {
                        searches.push(self.search(kind.as_str(), Some(seed), percent, seed)?);
                    }
                }
            }
        }
        Ok(searches)
    }

    fn search(
        &self,
        shape: &str,
        map_seed: Option<u64>,
        percent: u32,
        first: u64,
    ) -> Result<Search, ExperimentError> {
        let number = map_seed.map_or_else(String::new, |seed| format!("_{seed}"));
        let name = format!("{shape}{number}_{percent}");
        let text = self.text(&name, shape, map_seed, percent);
        let path = format!("{}/{name}.toml", self.name);
        let scenario = Scenario::from_text(Path::new(&path), text).map_err(ExperimentError::run)?;
        let seeds = format!("{first}..{}", first + self.seeds).parse().map_err(ExperimentError::Run)?;
        Ok(Search { scenario, group: format!("{}, {percent} %", shape.replace('_', " ")), seeds })
    }

    /// Every key is written out, so that a default that changes changes no track.
    fn text(&self, name: &str, shape: &str, map_seed: Option<u64>, percent: u32) -> String {
        let Self { robots, side, budget_cells, .. } = self;
        let map_seed = map_seed.map_or_else(String::new, |seed| format!("seed = {seed}\n"));
        format!(
            "\
name = \"{name}\"

[map]
shape = \"{shape}\"
rows = {side}
columns = {side}
{map_seed}cell_meters = 30.0
connectivity = 4

[sensor]
radius = 5
noise_variance = 0.005
noise = \"gaussian\"

[objects]
density = {density}
placement = \"prior\"

[robots]
count = {robots}
policy = \"path\"
start = \"random\"

[mission]
detection_threshold = 0.95
budget_meters = {budget_meters}.0
speed_meters_per_second = 2.0
stop_when_expected_remaining = 0.05
heartbeat_seconds = 10.0
liveness_timeout_seconds = 30.0
start_stagger_seconds = 0.1
max_clock_skew_seconds = 60.0

[network]
loss = 0.0
delay_seconds = 0.0
jitter_seconds = 0.0
duplication = 0.0
reorder = 0.0
",
            density = f64::from(percent) / 100.0,
            budget_meters = budget_cells * 30,
        )
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Name, version, episodes and digest of each track. A track that changes has a new version.
    const FROZEN: [(&str, u32, usize, &str); 5] = [
        ("smoke", 1, 12, "23fed181162f0cd697c538c4a1a73593"),
        ("single", 1, 400, "246157cedd98018105548a3fddf61e3c"),
        ("generated", 1, 200, "94d8178c7253b653d7927dd8a1048584"),
        ("team-3", 1, 240, "c6381ea0513d60f8d6b9401dff92d916"),
        ("team-8", 1, 80, "49924573e4e27b1c153496d8e9d8f96d"),
    ];

    #[test]
    fn tracks_are_frozen() {
        let found: Vec<_> = Track::names()
            .map(|name| {
                let track = Track::named(name).unwrap();
                (name, track.version(), track.episodes().count(), track.digest().to_string())
            })
            .collect();
        let frozen = FROZEN.map(|(name, version, count, digest)| (name, version, count, digest.to_owned()));
        assert_eq!(found, frozen);
    }

    #[test]
    fn searches_have_names_of_their_own_and_seeds_that_nothing_was_tuned_on() {
        for name in Track::names() {
            let track = Track::named(name).unwrap();
            let names: BTreeSet<&str> = track.searches().iter().map(|it| it.scenario.name()).collect();
            assert_eq!(names.len(), track.searches().len(), "{name}");
            let seeds: BTreeSet<u64> = track.episodes().map(|(_, seed)| seed).collect();
            assert!(seeds.iter().all(|seed| (30_000..100_000).contains(seed)), "{name}: {seeds:?}");
        }
    }

    #[test]
    fn a_digest_depends_on_the_map_the_objects_and_the_seeds() {
        let digest = |change: &dyn Fn(&mut Search)| {
            let mut track = Track::named("smoke").unwrap();
            track.searches.iter_mut().for_each(change);
            track.digest()
        };
        let first = digest(&|_| ());
        assert_eq!(first, digest(&|_| ()));
        assert_ne!(first, digest(&|search| search.seeds = "30000..30002".parse().unwrap()));
        assert_ne!(first, digest(&|search| search.seeds = "30001..30004".parse().unwrap()));
        // Both keep the text as it was read.
        assert_ne!(first, digest(&|search| search.scenario = search.scenario.with_density(0.3).unwrap()));
        assert_ne!(first, digest(&|search| search.scenario = search.scenario.with_robots(2).unwrap()));
    }

    #[test]
    fn an_unknown_track_is_refused_with_the_names_of_all() {
        let refused = Track::named("double").err().unwrap().to_string();
        assert!(refused.contains("\"double\"") && refused.contains("single, generated, team-3"), "{refused}");
    }
}
