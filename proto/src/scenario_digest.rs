//! Digests of what the scenarios of all participants of a mission must have in common.
//!
//! Each participant reads a copy of the scenario of its own. If they differ in the map, observations are of other cells; in
//! the prior or the sensor, beliefs differ; in speeds or sensors, observations are rejected; in the detection threshold, a robot
//! reports finds that the others do not; in the rate of the radios, messages are packed otherwise. What may differ is left out:
//! names, files, policies, budgets, periods, simulated objects and faults.

use std::fmt;
use std::str::FromStr;

use dragnet_scenario::{Robot, Scenario};
use xxhash_rust::xxh3::Xxh3;

/// Digests of the parts of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ScenarioDigest {
    /// Cells, their size, their ground, and where they are.
    pub map: u32,
    /// Each robot's sensor and speed, what hides cells, and how far apart robots keep.
    pub robots: u32,
    /// The belief before the first observation.
    pub prior: u32,
    /// Detection threshold, and rate of the radios.
    pub mission: u32,
}

/// What computed numbers are rounded to: computers differ in the last digits of functions such as the logarithm.
const STEPS_A_UNIT: f64 = 1024.0;
/// The same for degrees of latitude and longitude: a tenth of a meter.
const STEPS_A_DEGREE: f64 = 1e6;

impl ScenarioDigest {
    /// The digest of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        Self {
            map: map(scenario),
            robots: robots(scenario),
            prior: prior(scenario),
            mission: mission(scenario),
        }
    }

    /// How another scenario differs; `None` if it does not. The prior is only compared on the same map.
    #[must_use]
    pub fn difference(self, other: Self) -> Option<Difference> {
        let difference = Difference {
            map: self.map != other.map,
            robots: self.robots != other.robots,
            prior: self.map == other.map && self.prior != other.prior,
            mission: self.mission != other.mission,
        };
        (difference != Difference::default()).then_some(difference)
    }
}

fn map(scenario: &Scenario) -> u32 {
    let (terrain, origin) = (scenario.terrain(), scenario.origin());
    let corner = scenario.georeference().map(|frame| {
        let corner = frame.south_west();
        [corner.longitude_degrees, corner.latitude_degrees].map(|it| rounded(it, STEPS_A_DEGREE))
    });
    let yaw = scenario.georeference().map(|frame| rounded(frame.yaw_radians(), STEPS_A_UNIT));
    let pose = [origin.x_meters, origin.y_meters, origin.yaw_radians].map(|it| rounded(it, STEPS_A_UNIT));
    let ground = terrain.digest().0.to_le_bytes().map(i64::from);
    let place = corner.into_iter().flatten().chain(yaw).chain(pose);
    digest(ground.into_iter().chain(place))
}

fn robots(scenario: &Scenario) -> u32 {
    let of_robot = |robot: &Robot| {
        let class = &robot.class;
        [
            class.sensor.radius().into(),
            exact(class.sensor.noise_variance()),
            exact(class.speed_meters_per_second),
            class.flies.into(),
        ]
    };
    let hidden = scenario.terrain().line_of_sight().radius();
    let radius = hidden.map_or(-1, i64::from);
    let apart = Some(scenario.separation()).filter(|it| it.is_kept()).map(|it| i64::from(it.cells()));
    digest(std::iter::once(radius).chain(scenario.robots().iter().flat_map(of_robot)).chain(apart))
}

fn prior(scenario: &Scenario) -> u32 {
    let subjects = scenario.subjects();
    let rest = subjects.map_or(-1, |subjects| rounded(subjects.rest_of_world(), STEPS_A_UNIT));
    let several = subjects.map(|subjects| i64::from(subjects.number())).filter(|&number| number > 1);
    let cells = scenario.prior().prior_log_odds().iter().map(|&nats| rounded(nats, STEPS_A_UNIT));
    digest(std::iter::once(rest).chain(cells).chain(several))
}

fn mission(scenario: &Scenario) -> u32 {
    let rate = scenario.network().bytes_per_second.map(exact);
    digest(std::iter::once(exact(scenario.mission().detection_threshold)).chain(rate))
}

/// A number that is in a scenario as it is written.
const fn exact(number: f64) -> i64 {
    number.to_bits().cast_signed()
}

/// A number that was computed, in whole steps; of one that is not finite the nearest there is.
#[expect(clippy::cast_possible_truncation, reason = "it saturates")]
fn rounded(number: f64, steps: f64) -> i64 {
    (number * steps).round() as i64
}

/// The lower half of XXH3-64 of the numbers, little-endian.
#[expect(clippy::cast_possible_truncation, reason = "half of a hash is one")]
fn digest(numbers: impl Iterator<Item = i64>) -> u32 {
    let mut hash = Xxh3::new();
    numbers.for_each(|number| hash.update(&number.to_le_bytes()));
    hash.digest() as u32
}

/// Four numbers of 8 hexadecimal digits, joined by `-`.
impl fmt::Display for ScenarioDigest {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { map, robots, prior, mission } = self;
        write!(formatter, "{map:08x}-{robots:08x}-{prior:08x}-{mission:08x}")
    }
}

/// A text that is no [`ScenarioDigest`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoDigest;

impl FromStr for ScenarioDigest {
    type Err = NoDigest;

    fn from_str(text: &str) -> Result<Self, NoDigest> {
        let parts: Option<Vec<u32>> =
            text.split('-').map(|part| u32::from_str_radix(part, 16).ok()).collect();
        let Some(&[map, robots, prior, mission]) = parts.as_deref() else { return Err(NoDigest) };
        let digest = Self { map, robots, prior, mission };
        // One digest has one spelling, so that a key has only one.
        if digest.to_string() == text { Ok(digest) } else { Err(NoDigest) }
    }
}

/// The parts in which two scenarios differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "one for each part")]
pub struct Difference {
    map: bool,
    robots: bool,
    prior: bool,
    mission: bool,
}

/// What the other scenario has, in words.
impl fmt::Display for Difference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            (self.map, "another map"),
            (self.robots, "other sensors, speeds or number of robots"),
            (self.prior, "another prior"),
            (self.mission, "another detection threshold or rate of radios"),
        ];
        let parts: Vec<&str> =
            parts.into_iter().filter(|(differs, _)| *differs).map(|(_, what)| what).collect();
        formatter.write_str(&parts.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const TEXT: &str = "name = 'a'\n\
        [map]\nshape = 'all_traversable'\nrows = 6\ncolumns = 8\n\
        [objects]\ncount = 2\n\
        [sensor]\nradius = 3\n\
        [robots]\ncount = 2\npolicy = 'path'\n\
        [mission]\nbudget_seconds = 600.0\nspeed_meters_per_second = 1.5\ndetection_threshold = 0.95\n";

    fn digest_of(text: &str) -> ScenarioDigest {
        ScenarioDigest::of(&Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap())
    }

    #[track_caller]
    fn check(from: &str, to: &str, expected: &str) {
        assert!(TEXT.contains(from), "{from}");
        let difference = digest_of(TEXT).difference(digest_of(&TEXT.replace(from, to)));
        assert_eq!(difference.map_or_else(String::new, |it| it.to_string()), expected, "{to}");
    }

    #[test]
    fn what_may_differ_makes_no_difference() {
        check("name = 'a'", "name = 'b'", "");
        check("policy = 'path'", "policy = 'tour'", "");
        check("budget_seconds = 600.0", "budget_seconds = 900.0\nheartbeat_seconds = 3.0", "");
        check("[mission]", "[network]\nloss = 0.5\n[mission]", "");
    }

    #[test]
    fn each_difference_is_told_by_the_part_that_it_is_in() {
        check("columns = 8", "columns = 8\ncell_meters = 7.0", "another map");
        check("rows = 6\ncolumns = 8", "rows = 8\ncolumns = 6", "another map");
        let robots = "other sensors, speeds or number of robots";
        check("radius = 3", "radius = 4", robots);
        check("radius = 3", "radius = 3\nnoise_variance = 0.01", robots);
        check("second = 1.5", "second = 2.5", robots);
        check("count = 2\npolicy", "count = 3\npolicy", robots);
        check("count = 2\n[sensor]", "count = 3\n[sensor]", "another prior");
        check("threshold = 0.95", "threshold = 0.9", "another detection threshold or rate of radios");
        let slow = "[network]\nbytes_per_second = 200.0\n[mission]";
        check("[mission]", slow, "another detection threshold or rate of radios");
        let both = "radius = 4\n[prior]\nprobability = 0.2";
        check("radius = 3", both, &format!("{robots}, another prior"));
    }

    #[test]
    fn what_walls_hide_is_a_matter_of_the_sensor_and_makes_no_difference_without_walls() {
        check("radius = 3", "radius = 3\nline_of_sight = true", "");
        let walls =
            TEXT.replace("all_traversable'\nrows = 6\ncolumns = 8", "blocks'\nrows = 20\ncolumns = 20");
        let opaque = walls.replace("radius = 3", "radius = 3\nline_of_sight = true");
        let difference = digest_of(&walls).difference(digest_of(&opaque)).unwrap();
        assert_eq!(difference.to_string(), "other sensors, speeds or number of robots");
    }

    #[test]
    fn a_digest_is_read_as_it_was_written_and_nothing_else_is_one() {
        let digest = ScenarioDigest { map: 1, robots: u32::MAX, prior: 0xab, mission: 0 };
        assert_eq!(digest.to_string(), "00000001-ffffffff-000000ab-00000000");
        assert_eq!(digest.to_string().parse(), Ok(digest));
        for text in ["", "00000001-ffffffff-000000ab", "1-ffffffff-000000ab-00000000", "+0000001-0-0-0"] {
            assert_eq!(text.parse::<ScenarioDigest>(), Err(NoDigest), "{text}");
        }
    }
}
