//! The belief before the first observation.

use std::path::Path;

use dragnet_search::belief::Belief;
use dragnet_search::terrain::Terrain;

use super::check::{self, Invalid};
use super::error::Fault;
use super::file::PriorTable;
use super::objects::Objects;
use crate::map_file::areas::{Claims, RegionPrior};
use crate::map_file::{Areas, MapFile, load_probabilities};

/// The belief before the first observation, and its origin.
#[derive(Clone, Debug)]
pub(super) struct Prior {
    pub belief: Belief,
    /// Regions that it was made of.
    pub claims: Option<Claims>,
    /// Those of `prior.file`.
    pub areas: Areas,
}

impl Prior {
    /// The prior of a map that was read from `map_file`, if from any.
    pub(super) fn new(
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

    /// Checks that nothing is found before the first observation.
    pub(super) fn check_undecided(&self, terrain: &Terrain, detection_threshold: f64) -> Result<(), Invalid> {
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
        Ok(Self { belief, claims: Some(prior.claims), areas })
    }
}

impl From<Belief> for Prior {
    fn from(belief: Belief) -> Self {
        Self { belief, claims: None, areas: Areas::default() }
    }
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
}
