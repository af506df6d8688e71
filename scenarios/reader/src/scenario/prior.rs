//! The belief before the first observation.

use std::path::{Path, PathBuf};

use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::subjects::Subjects;
use dragnet_search::terrain::Terrain;

use super::check::{self, Invalid};
use super::error::Fault;
use super::file::PriorTable;
use super::objects::Objects;
use crate::map_file::areas::{Claims, RegionPrior};
use crate::map_file::{Areas, BeliefFile, MapFile, MapFileError, load_probabilities};

/// The greatest prior that an earlier search gives a cell, so that further readings can change it.
const MOST_CERTAIN: f64 = 0.999_999;
/// The least one: somebody who is sought may have moved since.
const LEAST_CERTAIN: f64 = 1e-9;

/// The key of what a scenario continues beside what its file says.
const PRIOR_FROM: &str = "prior_from";

/// What an earlier search believed in the end: the prior of a scenario where both search.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierBelief {
    /// The recording or belief file that it was read from; messages name it.
    pub file: PathBuf,
    /// The belief.
    pub belief: BeliefFile,
}

/// The belief before the first observation, and its origin.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    pub belief: Belief,
    /// Regions that it was made of.
    pub claims: Option<Claims>,
    /// Those of `prior.file`.
    pub areas: Areas,
    /// That the number of objects is known, if so: the belief and the rest of the world then add up to it.
    pub subjects: Option<Subjects>,
    /// The share of the searched cells that an earlier search covers, 0 to 1, if it continues one: that may have found
    /// something.
    pub continued: Option<f64>,
}

impl Prior {
    /// The prior of a map that was read from `map_file`, if from any; where an earlier search has searched, what it
    /// believed.
    pub(super) fn new(
        table: &PriorTable,
        folder: &Path,
        map_file: Option<&str>,
        map: &MapFile,
        objects: &Objects,
        earlier: Option<&EarlierBelief>,
    ) -> Result<Self, Fault> {
        let own = Self::of_table(table, folder, map_file, map, objects)?;
        let Some(EarlierBelief { file, belief }) = earlier else { return Ok(own) };
        let fault = |source| Fault::MapFile { key: PRIOR_FROM, source };
        check_same_kind(file, belief, own.subjects, objects).map_err(fault)?;
        own.after(PRIOR_FROM, file, belief, map)
    }

    /// The prior that the scenario's file says.
    fn of_table(
        table: &PriorTable,
        folder: &Path,
        map_file: Option<&str>,
        map: &MapFile,
        objects: &Objects,
    ) -> Result<Self, Fault> {
        if let Some(file) = table.file.as_deref().filter(|file| BeliefFile::is_file(Path::new(file))) {
            let own = PriorTable { file: None, ..table.clone() };
            let own = Self::of_table(&own, folder, map_file, map, objects)?;
            let (key, file) = ("prior.file", folder.join(file));
            let fault = |source| Fault::MapFile { key, source };
            let earlier = BeliefFile::load(&file).map_err(fault)?;
            check_same_number(&file, &earlier, own.subjects).map_err(fault)?;
            return own.after(key, &file, &earlier, map);
        }
        let Some(rest_of_world) = table.rest_of_world else {
            return Self::of_cells(table, folder, map_file, map, objects);
        };
        // It is scaled to their number, and to those who are inside.
        let prior = Self::of_cells(table, folder, map_file, map, &Objects::Count(1))?;
        Ok(prior.of_subjects(rest_of_world, table, &map.terrain, objects)?)
    }

    /// The prior of independent cells.
    fn of_cells(
        table: &PriorTable,
        folder: &Path,
        map_file: Option<&str>,
        map: &MapFile,
        objects: &Objects,
    ) -> Result<Self, Fault> {
        let terrain = &map.terrain;
        let map_file = folder.join(map_file.unwrap_or_default());
        let of_map = regions("map.file", &map_file, &map.areas, map, objects)?;
        match (table.probability, &table.file, of_map) {
            (None, None, None) => Ok(uniform("prior", objects.expected_density(terrain), terrain)?.into()),
            (Some(probability), None, None) => {
                let key = "prior.probability";
                Ok(uniform(key, check::between(key, probability, 0.0, 1.0)?, terrain)?.into())
            }
            (None, Some(file), None) => of_file(&folder.join(file), map, objects),
            (None, None, Some(prior)) => Self::of_regions("map.file", prior, Areas::default(), terrain),
            (Some(_), Some(_), _) => {
                let allowed = "probability, file or neither";
                Err(Invalid::new("prior", "probability and file", allowed).into())
            }
            (_, _, Some(_)) => {
                let found = "given beside a map whose areas have probabilities";
                Err(Invalid::new("prior", found, "one of the two").into())
            }
        }
    }

    /// The prior of a known number of objects: each cell keeps its share of those that are inside.
    fn of_subjects(
        self,
        rest_of_world: f64,
        table: &PriorTable,
        terrain: &Terrain,
        objects: &Objects,
    ) -> Result<Self, Invalid> {
        let key = "prior.rest_of_world";
        if !(0.0..1.0).contains(&rest_of_world) {
            return Err(Invalid::new(key, rest_of_world, "at least 0 and below 1"));
        }
        let number = objects.known_number();
        let subjects = number.and_then(|number| Subjects::new(number, rest_of_world)).ok_or_else(|| {
            let most = Subjects::MAX_NUMBER;
            let allowed =
                format!("a known number of objects: objects.count from 1 to {most}, or objects.cells");
            Invalid::new(key, format!("given for {objects}"), allowed)
        })?;
        if table.probability.is_some() {
            let allowed = "one of the two: with rest_of_world the probabilities of all cells follow";
            return Err(Invalid::new("prior", "probability and rest_of_world", allowed));
        }
        let mut probability = self.belief.probabilities();
        let inside: f64 = probability.iter().sum();
        for it in &mut probability {
            *it *= f64::from(subjects.number()) * (1.0 - rest_of_world) / inside;
        }
        Ok(Self { belief: of_probabilities(key, &probability, terrain)?, subjects: Some(subjects), ..self })
    }

    /// What an earlier search believed, where it searched; elsewhere this prior.
    ///
    /// Of several subjects whose number is known the earlier search also says how probable it is that one is in the rest of the world.
    /// Of one subject, it says with which probability it is in no cell that both searches have, and this
    /// prior how that is shared among its other cells and its own rest of the world.
    fn after(
        self,
        key: &'static str,
        file: &Path,
        earlier: &BeliefFile,
        map: &MapFile,
    ) -> Result<Self, Fault> {
        let moved = earlier.moved_to(file, map).map_err(|source| Fault::MapFile { key, source })?;
        let own = self.belief.probabilities();
        let uncovered: Vec<f64> =
            own.iter().zip(&moved.covered).map(|(own, covered)| own * (1.0 - covered)).collect();
        let (found, elsewhere) = (moved.mass.iter().sum::<f64>(), uncovered.iter().sum::<f64>());
        let (mut here, mut there, mut subjects) = (1.0, 1.0, self.subjects);
        if let Some((number, rest)) =
            earlier.subjects.zip(earlier.rest_of_world).filter(|_| subjects.is_some())
        {
            // Cells are independent but for the number, and so go on as they are.
            subjects = Subjects::new(number, rest);
        } else if let Some(one) = self.subjects.filter(|subjects| subjects.number() == 1) {
            let outside = elsewhere + one.rest_of_world();
            if earlier.rest_of_world.is_none() {
                // It counts expected objects, of which one is sought now.
                let factor = (1.0 - one.rest_of_world()) / (found + elsewhere);
                (here, there) = (factor, factor);
            } else if outside > 0.0 {
                there = (1.0 - found).max(0.0) / outside;
                subjects = Subjects::new(1, one.rest_of_world() * there);
            } else {
                here = 1.0 / found;
            }
        }
        let masses = moved.mass.iter().zip(&moved.covered).zip(&uncovered);
        let probability: Vec<f64> = masses
            .map(|((mass, &covered), own)| {
                let least = if covered > 0.0 { LEAST_CERTAIN } else { 0.0 };
                (here * mass + there * own).clamp(least, MOST_CERTAIN)
            })
            .collect();
        let belief = of_probabilities(key, &probability, &map.terrain)?;
        if subjects.is_none() && self.subjects.is_some() {
            let allowed = "some probability that the subject is in the area";
            return Err(Invalid::new(key, "sure that the subject is elsewhere", allowed).into());
        }
        let covered = |cell: Cell| moved.covered[cell.index()];
        let searched = map.terrain.searched_cells();
        let share = searched.map(covered).sum::<f64>() / map.terrain.searched_cells().count() as f64;
        Ok(Self { belief, claims: None, subjects, continued: Some(share), ..self })
    }

    /// Checks that nothing is found before the first observation, except by an earlier search.
    pub(super) fn check_undecided(&self, terrain: &Terrain, detection_threshold: f64) -> Result<(), Invalid> {
        if self.continued.is_some() {
            return Ok(());
        }
        let Some(cell) =
            terrain.searched_cells().find(|&cell| self.belief.is_found(cell, detection_threshold))
        else {
            return Ok(());
        };
        let (place, probability) = (terrain.grid().position(cell), self.belief.probability(cell));
        let found = format!("{probability:?} in cell [{}, {}]", place.row, place.column);
        let allowed = format!(
            "below mission.detection_threshold, {detection_threshold:?}: an object would be declared there before the first observation"
        );
        Err(Invalid::new("prior", found, allowed))
    }

    fn of_regions(
        key: &'static str,
        prior: RegionPrior,
        areas: Areas,
        terrain: &Terrain,
    ) -> Result<Self, Fault> {
        let belief = of_probabilities(key, &prior.probability, terrain)?;
        Ok(Self { belief, claims: Some(prior.claims), areas, subjects: None, continued: None })
    }
}

impl From<Belief> for Prior {
    fn from(belief: Belief) -> Self {
        Self { belief, claims: None, areas: Areas::default(), subjects: None, continued: None }
    }
}

/// An earlier search for one subject and one for several do not mean the same by a probability.
fn check_same_kind(
    file: &Path,
    earlier: &BeliefFile,
    subjects: Option<Subjects>,
    objects: &Objects,
) -> Result<(), MapFileError> {
    check_same_number(file, earlier, subjects)?;
    let is_for_one = subjects.is_some_and(|subjects| subjects.number() == 1);
    let was_for_one = earlier.rest_of_world.is_some() && earlier.subjects.is_none();
    let (found, allowed) = match (was_for_one, is_for_one) {
        (true, false) => (
            "one subject",
            format!(
                "what the scenario seeks, {objects} in cells that are independent of each other; or prior.rest_of_world in \
                 the scenario, which then seeks one subject too"
            ),
        ),
        (false, true) => (
            "objects in cells that are independent of each other",
            "one subject, as the scenario seeks; dragnet export RECORDING --to FILE.belief.json writes a prior.file of \
             several objects, of which the scenario seeks one"
                .to_owned(),
        ),
        (true, true) | (false, false) => return Ok(()),
    };
    Err(MapFileError::value(file, "what it sought", found, allowed))
}

/// Of several subjects, those that an earlier search has found are among those that are sought: of another number it would not
/// be known which.
fn check_same_number(
    file: &Path,
    earlier: &BeliefFile,
    subjects: Option<Subjects>,
) -> Result<(), MapFileError> {
    let (Some(number), Some(subjects)) = (earlier.subjects, subjects) else { return Ok(()) };
    if number == subjects.number() {
        return Ok(());
    }
    let allowed = format!(
        "{}, as the scenario seeks; objects.count counts those too that are found: {number}",
        subjects.number()
    );
    Err(MapFileError::value(file, "the number of its subjects", number, allowed))
}

fn uniform(key: &str, probability: f64, terrain: &Terrain) -> Result<Belief, Invalid> {
    let allowed = "above 0 and below 1";
    Belief::uniform(terrain, probability).map_err(|_| Invalid::new(key, probability, allowed))
}

fn of_file(file: &Path, map: &MapFile, objects: &Objects) -> Result<Prior, Fault> {
    let key = "prior.file";
    let fault = |source| Fault::MapFile { key, source };
    if !Areas::is_file(file) {
        let probability = load_probabilities(file, map.terrain.grid()).map_err(fault)?;
        return Ok(of_probabilities(key, &probability, &map.terrain)?.into());
    }
    let areas = Areas::load(file).map_err(fault)?.likely_ones();
    let prior = regions(key, file, &areas, map, objects)?.ok_or_else(|| {
        let allowed = "at least one area or point with a poa";
        Invalid::new(key, "without a region", allowed)
    })?;
    Prior::of_regions(key, prior, areas, &map.terrain)
}

/// The prior of regions, if there are any; `key` names their file.
fn regions(
    key: &'static str,
    file: &Path,
    areas: &Areas,
    map: &MapFile,
    objects: &Objects,
) -> Result<Option<RegionPrior>, Fault> {
    if areas.areas.iter().all(|area| area.purpose.poa().is_none()) {
        return Ok(None);
    }
    let frame = map.georeference.as_ref().ok_or_else(|| {
        let allowed = "where on earth the map's south-western corner lies";
        Invalid::new("map.origin", format!("missing, and {key} lies on the earth"), allowed)
    })?;
    let expected = objects.expected_count(&map.terrain);
    areas.prior(file, frame, &map.terrain, expected).map_err(|source| Fault::MapFile { key, source })
}

fn of_probabilities(key: &str, probability: &[f64], terrain: &Terrain) -> Result<Belief, Invalid> {
    if terrain.searched_cells().all(|cell| probability[cell.index()] <= 0.0) {
        let allowed = "a probability above 0 in at least one searched cell";
        return Err(Invalid::new(key, "0 in every searched cell", allowed));
    }
    let allowed = "probabilities from 0 to below 1";
    Belief::new(terrain, probability).map_err(|error| Invalid::new(key, error, allowed))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::mentions::assert_mentions;
    use crate::scenario::Scenario;

    const DRAWN: &str = "name = 'drawn'
[map]
file = 'a.txt'
cell_meters = 100
origin = { latitude_degrees = 0, longitude_degrees = 0 }
[prior]
file = 'a.geojson'
[sensor]
radius = 1
[objects]
count = 2
[mission]
budget_meters = 300
";
    /// The western half of the drawing, and a search area, which has no meaning beside another map.
    const REGIONS: &str = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"name":"west","poa":"75%"},"geometry":{"type":"Polygon","coordinates":
            [[[0,0],[0.00179663,0],[0.00179663,0.0018],[0,0.0018],[0,0]]]}},
        {"type":"Feature","properties":{"name":"all"},"geometry":{"type":"Polygon","coordinates":
            [[[0,0],[0.5,0],[0.5,0.5],[0,0]]]}}]}"#;

    fn load(text: &str, regions: &str) -> Result<Scenario, String> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.txt"), "....\n....\n").unwrap();
        fs::write(folder.path().join("a.geojson"), regions).unwrap();
        fs::write(folder.path().join("a.toml"), text).unwrap();
        Scenario::load(&folder.path().join("a.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn regions_share_the_expected_objects_on_any_map_with_an_origin() {
        let scenario = load(DRAWN, REGIONS).unwrap();
        let probability = |cell| scenario.prior().probability(cell);
        let given: Vec<f64> = scenario.terrain().grid().cells().map(probability).collect();
        for (given, expected) in given.iter().zip([0.375, 0.375, 0.125, 0.125].repeat(2)) {
            assert!((given - expected).abs() < 1e-6, "{given} {expected}");
        }
        assert_eq!(scenario.areas().left_out, ["all"]);
        let earth = scenario.earth().unwrap();
        assert_eq!(crate::map_file::Earth::read(&earth.facts(), &earth.areas_geojson()), Ok(earth));
    }

    #[test]
    fn an_invalid_origin_is_rejected() {
        let check = |from: &str, to: &str, message: &str| {
            let error = load(&DRAWN.replace(from, to), REGIONS).unwrap_err();
            assert_mentions(&error, message);
        };
        check(
            "latitude_degrees = 0",
            "latitude_degrees = 90",
            "a.toml .. line 5 .. map.origin .. longitude 0",
        );
        check("latitude_degrees = 0", "latitude_degrees = nan", "latitude NaN .. longitude -180 to");
        check("longitude_degrees = 0", "longitude_degrees = 3", "area \"west\" .. 334 km .. allowed");
        check(
            "origin = { latitude_degrees = 0, longitude_degrees = 0 }",
            "",
            "map.origin .. missing .. allowed",
        );
        check("'a.txt'", "'a.geojson'", "map.origin .. given .. no such key");
        check("file = 'a.geojson'", "probability = 0.1\nfile = 'a.geojson'", "prior .. probability and file");
        let error = load(DRAWN, r#"{"type":"FeatureCollection","features":[]}"#).unwrap_err();
        assert_mentions(&error, "prior.file .. without a region .. at least one area");
    }

    const ONE: &str = "name = 'one'
[map]
file = 'a.txt'
cell_meters = 100
[prior]
rest_of_world = 0.25
[sensor]
radius = 1
[objects]
count = 1
[mission]
budget_meters = 300
";

    #[test]
    fn one_subject_is_in_some_cell_or_in_the_rest_of_the_world() {
        let scenario = load(ONE, REGIONS).unwrap();
        let probability = |scenario: &Scenario| scenario.prior().probabilities();
        assert!(probability(&scenario).iter().all(|it| (it - 0.75 / 8.0).abs() < 1e-12));
        assert!((scenario.subjects().unwrap().rest_of_world() - 0.25).abs() < 1e-12);
        let one_of_regions =
            DRAWN.replace("[prior]", "[prior]\nrest_of_world = 0.2").replace("count = 2", "count = 1");
        let given = probability(&load(&one_of_regions, REGIONS).unwrap());
        for (given, expected) in given.iter().zip([0.15, 0.15, 0.05, 0.05].repeat(2)) {
            assert!((given - expected).abs() < 1e-6, "{given} {expected}");
        }
        assert!(load(DRAWN, REGIONS).unwrap().subjects().is_none());
    }

    #[test]
    fn several_subjects_are_in_as_many_cells_or_in_the_rest_of_the_world() {
        let scenario = load(&ONE.replace("count = 1", "count = 2"), REGIONS).unwrap();
        let probability = scenario.prior().probabilities();
        assert!(probability.iter().all(|it| (it - 2.0 * 0.75 / 8.0).abs() < 1e-12), "{probability:?}");
        let subjects = scenario.subjects().unwrap();
        assert_eq!(subjects.number(), 2);
        let posterior = subjects.posterior(scenario.prior());
        let inside: f64 = posterior.probabilities().iter().sum();
        assert!((inside + posterior.rest_of_world() - 2.0).abs() < 1e-9, "{inside}");
        // About as many are outside as without the knowledge of their number.
        assert!((posterior.rest_of_world() - 0.5).abs() < 0.05, "{}", posterior.rest_of_world());
    }

    /// Without the rest of the world seven are too many for these regions.
    #[test]
    fn regions_hold_as_many_as_are_expected_inside() {
        let seven = |rest: &str| {
            DRAWN.replace("[prior]", &format!("[prior]\n{rest}")).replace("count = 2", "count = 7")
        };
        let scenario = load(&seven("rest_of_world = 0.6"), REGIONS).unwrap();
        let given = scenario.prior().probabilities();
        for (given, expected) in given.iter().zip([0.525, 0.525, 0.175, 0.175].repeat(2)) {
            assert!((given - expected).abs() < 1e-6, "{given} {expected}");
        }
        assert!(load(&seven(""), REGIONS).is_err() && load(&seven("rest_of_world = 0.1"), REGIONS).is_err());
    }

    #[test]
    fn a_rest_of_the_world_needs_a_known_number_and_leaves_some_probability() {
        let check = |from: &str, to: &str, message: &str| {
            assert_mentions(&load(&ONE.replace(from, to), REGIONS).unwrap_err(), message);
        };
        check("0.25", "1", "a.toml .. line 6 .. prior.rest_of_world is 1; allowed is at least 0 and below 1");
        check("0.25", "-0.1", "prior.rest_of_world is -0.1");
        check("0.25", "nan", "prior.rest_of_world is NaN");
        check(
            "count = 1",
            "count = 0",
            "prior.rest_of_world is given for 0 objects .. objects.count from 1 to 100",
        );
        check("count = 1", "density = 0.1", "prior.rest_of_world is given for an object in 10 %");
        check(
            "rest_of",
            "probability = 0.1\nrest_of",
            "prior is probability and rest_of_world .. one of the two",
        );
    }

    /// A belief of two rows and four columns of 100 m on the map of `DRAWN`, its rows from the south.
    fn believed(cell_meters: f64, rows: usize, columns: usize, rest: &str, probability: &str) -> String {
        format!(
            r#"{{"dragnet_belief":1,"mission":"first","rows":{rows},"columns":{columns},"cell_meters":{cell_meters},
            "earth":{{"south_west_latitude_degrees":0.0,"south_west_longitude_degrees":0.0,
            "reference_latitude_degrees":0.0,"yaw_radians":0.0}},
            "origin":{{"x_meters":0.0,"y_meters":0.0,"yaw_radians":0.0}},{rest}"probability":{probability}}}"#
        )
    }

    fn next(belief: &str, from: &str, to: &str) -> Result<Scenario, String> {
        let text = DRAWN.replace("a.geojson", "a.belief.json").replace(from, to);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.txt"), "....\n....\n").unwrap();
        fs::write(folder.path().join("a.belief.json"), belief).unwrap();
        fs::write(folder.path().join("a.toml"), &text).unwrap();
        Scenario::load(&folder.path().join("a.toml")).map_err(|error| error.to_string())
    }

    fn assert_prior(scenario: &Scenario, expected: &[f64]) {
        let given = scenario.prior().probabilities();
        let is_near = |(given, expected): (&f64, &f64)| (given - expected).abs() < 1e-4;
        assert!(given.len() == expected.len() && given.iter().zip(expected).all(is_near), "{given:?}");
    }

    #[test]
    fn a_search_begins_with_what_the_last_one_believed() {
        let same = believed(100.0, 2, 4, "", "[0.1,0.2,0.3,0.999999999,0.0,0.5,null,0.01]");
        let scenario = next(&same, "", "").unwrap();
        // What was found stays found, and can be withdrawn; what was not searched has the own prior, 2 of 8.
        assert_prior(&scenario, &[0.1, 0.2, 0.3, 0.999_999, 0.0, 0.5, 0.25, 0.01]);
    }

    #[test]
    fn cells_that_merge_add_up_and_cells_that_split_share_by_area() {
        // Cells of 50 m in the southern row: two by two of them make one of 100 m.
        let finer = "[0.1,0.02,0.0,0.0,0.0,0.0,0.0,0.0, 0.03,0.05,0.0,0.0,0.0,0.0,0.4,0.4]";
        let scenario = next(&believed(50.0, 2, 8, "", finer), "", "").unwrap();
        assert_prior(&scenario, &[0.2, 0.0, 0.0, 0.8, 0.25, 0.25, 0.25, 0.25]);
        // One cell of 300 m: two ninths of it beside the map, to the north a third.
        let scenario = next(&believed(300.0, 1, 1, "", "[0.9]"), "", "").unwrap();
        assert_prior(&scenario, &[0.1, 0.1, 0.1, 0.25, 0.1, 0.1, 0.1, 0.25]);
        // A cell of 150 m covers half of the next one, which keeps half of its own prior, and a quarter of that above it.
        let scenario = next(&believed(150.0, 1, 1, "", "[0.9]"), "", "").unwrap();
        let (whole, half, quarter) = (0.4, 0.2 + 0.125, 0.1 + 0.75 * 0.25);
        assert_prior(&scenario, &[whole, half, 0.25, 0.25, half, quarter, 0.25, 0.25]);
    }

    #[test]
    fn one_subject_that_was_not_found_is_in_what_is_left_or_in_the_rest_of_the_world() {
        let one = "file = 'a.belief.json'\nrest_of_world = 0.2\n[sensor]\nradius = 1\n[objects]\ncount = 1\n[mission]";
        let old = "file = 'a.belief.json'\n[sensor]\nradius = 1\n[objects]\ncount = 2\n[mission]";
        let rest = "\"rest_of_world\":0.4,";
        let same = believed(100.0, 2, 4, rest, "[0.1,0.2,0.0,0.0,0.1,0.1,0.1,0.0]");
        let scenario = next(&same, old, one).unwrap();
        assert_prior(&scenario, &[0.1, 0.2, 0.0, 0.0, 0.1, 0.1, 0.1, 0.0]);
        assert!((scenario.subjects().unwrap().rest_of_world() - 0.4).abs() < 1e-4);
        // The northern row is new. Its own prior is 0.4, the rest of the world 0.2: they share the 0.6 that are not in the south.
        let south = believed(100.0, 1, 4, "\"rest_of_world\":0.6,", "[0.1,0.2,0.1,0.0]");
        let scenario = next(&south, old, one).unwrap();
        assert_prior(&scenario, &[0.1, 0.2, 0.1, 0.0, 0.1, 0.1, 0.1, 0.1]);
        assert!((scenario.subjects().unwrap().rest_of_world() - 0.2).abs() < 1e-4);
        // The last search was for several: one of the expected objects is here with 0.8.
        let several = believed(100.0, 2, 4, "", "[0.4,0.4,0.0,0.0,0.4,0.4,0.0,0.0]");
        let scenario = next(&several, old, one).unwrap();
        assert_prior(&scenario, &[0.2, 0.2, 0.0, 0.0, 0.2, 0.2, 0.0, 0.0]);
    }

    #[test]
    fn a_belief_that_does_not_fit_is_rejected() {
        let good = believed(100.0, 1, 2, "", "[0.1,0.2]");
        let check = |from: &str, to: &str, message: &str| {
            assert_mentions(&next(&good.replace(from, to), "", "").unwrap_err(), message);
        };
        check(
            "\"dragnet_belief\":1",
            "\"dragnet_belief\":2",
            "a.belief.json: dragnet_belief is 2 .. 1, the version",
        );
        check("[0.1,0.2]", "[0.1]", "probability is 1 numbers; allowed is 2");
        check("[0.1,0.2]", "[0.1,1.2]", "probability[1] is 1.2; allowed is from 0 to 1");
        check("\"cell_meters\":100", "\"cell_meters\":-1", "cell_meters is -1");
        check("\"rows\":1", "\"rows\":0", "a.belief.json");
        check("latitude_degrees\":0.0,\"south_west_l", "latitude_degrees\":89.0,\"south_west_l", "earth");
        check(
            "longitude_degrees\":0.0",
            "longitude_degrees\":0.1",
            "its map is elsewhere .. shares at least one",
        );
        check(
            "longitude_degrees\":0.0",
            "longitude_degrees\":9.0",
            "its map is 1002 km away .. at most 100 km",
        );
        check("\"mission\"", "\"misson\"", "a.belief.json .. misson");
        let unplaced = good.replace("\"earth\"", "\"nowhere\"");
        assert_mentions(&next(&unplaced, "", "").unwrap_err(), "nowhere");
        let (from, to) = (good.find("\"earth\"").unwrap(), good.find("\"origin\"").unwrap());
        let unplaced = format!("{}{}", &good[..from], &good[to..]);
        assert_mentions(&next(&unplaced, "", "").unwrap_err(), "without a position on the earth .. --origin");
        let origin = "origin = { latitude_degrees = 0, longitude_degrees = 0 }";
        assert_mentions(
            &next(&good, origin, "").unwrap_err(),
            "on the earth, the scenario's is not .. map.origin",
        );
        assert_mentions(
            &next(&unplaced, origin, "").unwrap_err(),
            "of 1 rows and 2 columns .. the scenario's own map",
        );
        let same = unplaced
            .replace("\"columns\":2", "\"columns\":4")
            .replace("[0.1,0.2]", "[0,0,0,0,0.1,0.2,0.3,0.4]");
        let same = same.replace("\"rows\":1", "\"rows\":2");
        assert_prior(&next(&same, origin, "").unwrap(), &[0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3, 0.4]);
    }
}
