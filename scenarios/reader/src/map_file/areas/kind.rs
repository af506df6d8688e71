//! The convention: the kinds of features, and their required geometry and properties.

use std::path::Path;

use geo::{LineString, MultiLineString, MultiPolygon};

use super::feature::{Conflict, Facts, Feature, number};
use super::{Area, Purpose, Quartiles, Spread, rings};
use crate::map_file::MapFileError;
use crate::map_file::georeference::GeoPoint;

pub(super) const SEARCH: &str = "search";
pub(super) const NO_GO: &str = "no_go";
pub(super) const PRIOR: &str = "prior";
pub(super) const LAST_KNOWN_POSITION: &str = "last_known_position";
pub(super) const LINEAR_FEATURE: &str = "linear_feature";
pub(super) const START: &str = "start";

/// Kinds that an export adds to the areas of its mission, which are not inputs of a search.
const EXPORTED: [&str; 7] = ["found", "dismissed", "clue", "searched", TRACK, "cleared", "not_searched"];
/// The kind of a robot's track in an export.
pub(super) const TRACK: &str = "track";

/// The widest spread of a last known position, meters.
const MAX_SPREAD_METERS: f64 = 100_000.0;

/// The area of a feature; `None` if it is not one of Dragnet's. Without a kind, polygons are search areas or, with a
/// probability, prior regions; a point with a probability is a last known position, a line with quartiles a linear feature. The faults of polygons that were
/// mended are added to `mended`.
pub(super) fn area(
    file: &Path,
    feature: &Feature,
    mended: &mut Vec<String>,
) -> Result<Option<Area>, MapFileError> {
    check_agreement(file, feature)?;
    let Some(kind) = kind(file, feature)? else { return Ok(None) };
    check_likelihood(file, feature, kind)?;
    let purpose = match kind {
        SEARCH => Purpose::Search(polygons(file, feature, kind, mended)?),
        NO_GO => no_go(file, feature, mended)?,
        PRIOR => Purpose::Prior { region: polygons(file, feature, kind, mended)?, poa: poa(file, feature)? },
        LINEAR_FEATURE => linear_feature(file, feature)?,
        START => Purpose::Start(point(file, feature, kind)?),
        _ => last_known_position(file, feature)?,
    };
    let name = feature.name.clone().unwrap_or_else(|| feature.place.clone());
    Ok(Some(Area { name, purpose }))
}

/// Contradictory properties, also between properties and description, are an error.
fn check_agreement(file: &Path, feature: &Feature) -> Result<(), MapFileError> {
    let Some(Conflict { key, first, second }) = feature.facts.conflict() else { return Ok(()) };
    let allowed = "one value in all properties and the description";
    Err(invalid(file, feature, key, format!("{first:?} and {second:?}"), allowed))
}

/// Search areas and no-go areas have no probability: a number that would not count is an error, except in an export,
/// which contains results of a search.
fn check_likelihood(file: &Path, feature: &Feature, kind: &str) -> Result<(), MapFileError> {
    match feature.facts.get(Facts::POA) {
        Some(poa) if kind == START => {
            Err(invalid(file, feature, Facts::POA, format!("{poa:?}"), &format!("none with {START}")))
        }
        Some(poa) if matches!(kind, SEARCH | NO_GO) && !feature.facts.is_account() => {
            let allowed = format!(
                "none with {kind}; the same polygon once more, with kind: {PRIOR}, gives its probability"
            );
            Err(invalid(file, feature, Facts::POA, format!("{poa:?}"), &allowed))
        }
        _ => Ok(()),
    }
}

fn kind(file: &Path, feature: &Feature) -> Result<Option<&'static str>, MapFileError> {
    let Some(word) = feature.facts.get(Facts::KIND) else { return kind_unsaid(file, feature) };
    if is_result(feature) {
        return Ok(None);
    }
    let plain = plain(word);
    Purpose::KINDS.into_iter().find(|known| *known == plain).map(Some).ok_or_else(|| {
        let shown: String = word.chars().take(40).collect();
        invalid(file, feature, Facts::KIND, format!("{shown:?}"), &Purpose::KINDS.join(", "))
    })
}

/// Whether a feature is what an export has added to the areas of its mission.
pub(super) fn is_result(feature: &Feature) -> bool {
    feature.facts.get(Facts::KIND).is_some_and(|word| EXPORTED.contains(&plain(word).as_str()))
}

/// Whether a feature says that it is a linear feature.
pub(super) fn is_linear(feature: &Feature) -> bool {
    feature.facts.get(Facts::KIND).is_some_and(|word| plain(word) == LINEAR_FEATURE)
}

fn plain(word: &str) -> String {
    word.to_lowercase().replace([' ', '-'], "_")
}

/// A feature without a kind. One that seems to be meant for a search is an error rather than ignored: it may be a
/// cliff.
fn kind_unsaid(file: &Path, feature: &Feature) -> Result<Option<&'static str>, MapFileError> {
    if let Some(unclear) = feature.facts.unclear() {
        let found = format!("{unclear}, which is not understood");
        let allowed = "a property, or a line of the description, such as `kind: no_go` or `poa: 60%`; \
                       `kind: search` of a polygon that is searched";
        return Err(MapFileError::value(file, &feature.place, found, allowed));
    }
    let shapes = &feature.shapes;
    let is_likely = feature.facts.get(Facts::POA).is_some();
    let is_line = !shapes.lines.is_empty() && shapes.points.is_empty();
    match (shapes.polygons.is_empty(), is_likely) {
        (false, false) => Ok(Some(SEARCH)),
        (false, true) => Ok(Some(PRIOR)),
        (true, _) if is_line && feature.facts.get(Facts::QUARTILES).is_some() => Ok(Some(LINEAR_FEATURE)),
        (true, _) if feature.facts.are_some() && shapes.points.len() == 1 => Ok(Some(LAST_KNOWN_POSITION)),
        (true, _) if feature.facts.are_some() => {
            Err(wrong_shape(file, feature, "a likely place", "a polygon or one point"))
        }
        (true, _) => Ok(None),
    }
}

fn polygons(
    file: &Path,
    feature: &Feature,
    kind: &str,
    mended: &mut Vec<String>,
) -> Result<MultiPolygon<f64>, MapFileError> {
    if feature.shapes.polygons.is_empty() {
        return Err(wrong_shape(file, feature, kind, "a polygon"));
    }
    rings::polygons(file, &feature.place, &feature.shapes.polygons, mended)
}

fn no_go(file: &Path, feature: &Feature, mended: &mut Vec<String>) -> Result<Purpose, MapFileError> {
    let shapes = &feature.shapes;
    if shapes.polygons.is_empty() && shapes.lines.is_empty() {
        return Err(wrong_shape(file, feature, NO_GO, "a polygon or a line"));
    }
    let lines: Result<Vec<LineString<f64>>, _> =
        shapes.lines.iter().map(|line| rings::line(file, &feature.place, line)).collect();
    let polygons = rings::polygons(file, &feature.place, &shapes.polygons, mended)?;
    Ok(Purpose::NoGo(polygons, MultiLineString(lines?)))
}

fn point(file: &Path, feature: &Feature, kind: &str) -> Result<GeoPoint, MapFileError> {
    let [point] = &feature.shapes.points[..] else {
        return Err(wrong_shape(file, feature, kind, "one point"));
    };
    Ok(GeoPoint::from(rings::corner(file, &feature.place, point)?))
}

fn last_known_position(file: &Path, feature: &Feature) -> Result<Purpose, MapFileError> {
    let point = point(file, feature, LAST_KNOWN_POSITION)?;
    let spread = match (quartiles(file, feature)?, feature.facts.get(Facts::SPREAD)) {
        (Some(_), Some(spread)) => {
            let found = format!("{spread}, beside {}", Facts::QUARTILES);
            return Err(invalid(file, feature, Facts::SPREAD, found, "one of the two"));
        }
        (Some(quartiles), None) => Spread::Quartiles(quartiles),
        (None, spread) => Spread::Normal(spread_meters(file, feature, spread.unwrap_or("missing"))?),
    };
    Ok(Purpose::LastKnownPosition { point, spread, poa: poa(file, feature)? })
}

fn spread_meters(file: &Path, feature: &Feature, spread: &str) -> Result<f64, MapFileError> {
    let allowed = "meters above 0 to 100000, or quartiles_meters instead";
    spread
        .parse()
        .ok()
        .filter(|&meters: &f64| meters > 0.0 && meters <= MAX_SPREAD_METERS)
        .ok_or_else(|| invalid(file, feature, Facts::SPREAD, spread, allowed))
}

fn linear_feature(file: &Path, feature: &Feature) -> Result<Purpose, MapFileError> {
    if feature.shapes.lines.is_empty() {
        return Err(wrong_shape(file, feature, LINEAR_FEATURE, "a line"));
    }
    let lines: Result<Vec<LineString<f64>>, _> =
        feature.shapes.lines.iter().map(|line| rings::line(file, &feature.place, line)).collect();
    let quartiles = quartiles(file, feature)?
        .ok_or_else(|| invalid(file, feature, Facts::QUARTILES, "missing", Quartiles::ALLOWED))?;
    Ok(Purpose::LinearFeature { lines: MultiLineString(lines?), quartiles, poa: poa(file, feature)? })
}

/// The quartiles of a distance, if they are given.
fn quartiles(file: &Path, feature: &Feature) -> Result<Option<Quartiles>, MapFileError> {
    let Some(text) = feature.facts.get(Facts::QUARTILES) else { return Ok(None) };
    let allowed = || invalid(file, feature, Facts::QUARTILES, text, Quartiles::ALLOWED);
    Quartiles::parse(text).map(Some).ok_or_else(allowed)
}

/// A share, or a percentage with its sign: a bare 25 is ambiguous.
fn poa(file: &Path, feature: &Feature) -> Result<f64, MapFileError> {
    let text = feature.facts.get(Facts::POA).unwrap_or("missing");
    number(text).filter(|share| (0.0..=1.0).contains(share)).ok_or_else(|| {
        let allowed = "a share from 0 to 1, or percent with their sign, such as 25%";
        invalid(file, feature, Facts::POA, text, allowed)
    })
}

fn wrong_shape(file: &Path, feature: &Feature, kind: &str, allowed: &str) -> MapFileError {
    let found = format!("{kind} drawn as {}", feature.shapes.describe());
    MapFileError::value(file, &feature.place, found, allowed)
}

fn invalid(
    file: &Path,
    feature: &Feature,
    key: &str,
    found: impl std::fmt::Display,
    allowed: &str,
) -> MapFileError {
    MapFileError::value(file, format!("{}, {key}", feature.place), found, allowed)
}
