//! Areas as `GeoJSON` (RFC 7946): reading and writing.

use std::path::Path;

use geo::{LineString, MultiLineString, MultiPolygon};
use geojson::{Feature as Drawn, FeatureCollection, GeoJson, Geometry, GeometryValue, JsonObject, JsonValue};

use super::feature::{Facts, Feature, Shapes};
use super::{Area, Purpose, Spread, unique};
use crate::map_file::MapFileError;

pub(super) fn features(file: &Path, text: &str) -> Result<Vec<Feature>, MapFileError> {
    unique::check(text).map_err(|error| MapFileError::syntax(file, error))?;
    let json: GeoJson = text.parse().map_err(|error| MapFileError::syntax(file, error))?;
    check_crs(file, &json)?;
    Ok(match json {
        GeoJson::Geometry(geometry) => {
            let mut feature = Feature::at("geometry 1", None);
            draw(&mut feature.shapes, geometry.value);
            vec![feature]
        }
        GeoJson::Feature(drawn) => vec![feature(1, drawn)],
        GeoJson::FeatureCollection(collection) => {
            let of_all = collection.foreign_members.unwrap_or_default();
            let mut features: Vec<Feature> =
                (1..).zip(collection.features).map(|(number, drawn)| feature(number, drawn)).collect();
            let about_searches = of_all
                .iter()
                .find_map(|(key, value)| Some((key, Facts::line_about_searches(&plain(value))?)));
            if let Some((key, line)) = about_searches {
                for feature in &mut features {
                    feature.facts.suspect_line(&format!("in the collection with {key}"), &line);
                }
            }
            features
        }
    })
}

/// RFC 7946 allows only degrees of WGS84; the format before it, which many tools still write, may name another
/// coordinate reference system on every level.
fn check_crs(file: &Path, json: &GeoJson) -> Result<(), MapFileError> {
    let mut all_members: Vec<&JsonObject> = Vec::new();
    match json {
        GeoJson::Geometry(geometry) => members_of_geometry(geometry, &mut all_members),
        GeoJson::Feature(feature) => members_of_feature(feature, &mut all_members),
        GeoJson::FeatureCollection(collection) => {
            all_members.extend(&collection.foreign_members);
            for feature in &collection.features {
                members_of_feature(feature, &mut all_members);
            }
        }
    }
    let systems = all_members.iter().filter_map(|members| members.get("crs")).filter(|crs| !crs.is_null());
    for crs in systems {
        let properties = crs.get("properties");
        let name =
            properties.and_then(|properties| properties.get("name").or_else(|| properties.get("code")));
        let name = name.map_or_else(|| plain(crs), plain);
        let code = name.rsplit([':', '/']).next().unwrap_or_default();
        if !WGS84.contains(&code) {
            let shown: String = name.chars().take(80).collect();
            let allowed = "longitude and latitude of WGS84 (OGC:CRS84 or EPSG:4326): export the file in that";
            return Err(MapFileError::value(file, "crs", format!("{shown:?}"), allowed));
        }
    }
    Ok(())
}

/// Names and numbers of WGS84's longitude and latitude, with a height and without.
const WGS84: [&str; 4] = ["CRS84", "CRS84h", "4326", "4979"];

fn members_of_feature<'a>(feature: &'a Drawn, all_members: &mut Vec<&'a JsonObject>) {
    all_members.extend(&feature.foreign_members);
    if let Some(geometry) = &feature.geometry {
        members_of_geometry(geometry, all_members);
    }
}

fn members_of_geometry<'a>(geometry: &'a Geometry, all_members: &mut Vec<&'a JsonObject>) {
    all_members.extend(&geometry.foreign_members);
    if let GeometryValue::GeometryCollection { geometries } = &geometry.value {
        for geometry in geometries {
            members_of_geometry(geometry, all_members);
        }
    }
}

fn feature(number: usize, drawn: Drawn) -> Feature {
    let properties = drawn.properties.unwrap_or_default();
    // Tools write `Name` and `Description` too.
    let text = |name: &str| {
        let of_name = |(key, _): &(&String, &JsonValue)| key.eq_ignore_ascii_case(name);
        properties.iter().filter(of_name).map(|(_, value)| plain(value)).find(|text| !text.is_empty())
    };
    let mut feature = Feature::at(&format!("feature {number}"), text("name").or_else(|| text("title")));
    let is_description = |key: &str| key.eq_ignore_ascii_case("description");
    for (key, value) in properties.iter().filter(|(key, _)| !is_description(key)) {
        feature.facts.add_property(key, &plain(value));
    }
    for (_, value) in properties.iter().filter(|(key, _)| is_description(key)) {
        feature.facts.describe(&plain(value));
    }
    for (key, value) in &drawn.foreign_members.unwrap_or_default() {
        feature.facts.suspect_property(key, &plain(value));
    }
    if let Some(geometry) = drawn.geometry {
        draw(&mut feature.shapes, geometry.value);
    }
    feature
}

/// A property as text.
fn plain(value: &JsonValue) -> String {
    match value {
        JsonValue::String(text) => text.clone(),
        JsonValue::Null => String::new(),
        other => other.to_string(),
    }
}

fn draw(shapes: &mut Shapes, geometry: GeometryValue) {
    let positions =
        |line: Vec<geojson::Position>| line.into_iter().map(|it| it.as_slice().to_vec()).collect();
    let rings = |rings: Vec<Vec<_>>| rings.into_iter().map(positions).collect();
    match geometry {
        GeometryValue::Point { coordinates } => shapes.points.push(coordinates.as_slice().to_vec()),
        GeometryValue::MultiPoint { coordinates } => shapes.points.extend(positions(coordinates)),
        GeometryValue::LineString { coordinates } => shapes.lines.push(positions(coordinates)),
        GeometryValue::MultiLineString { coordinates } => {
            shapes.lines.extend(coordinates.into_iter().map(positions));
        }
        GeometryValue::Polygon { coordinates } => shapes.polygons.push(rings(coordinates)),
        GeometryValue::MultiPolygon { coordinates } => {
            shapes.polygons.extend(coordinates.into_iter().map(rings));
        }
        GeometryValue::GeometryCollection { geometries } => {
            for geometry in geometries {
                draw(shapes, geometry.value);
            }
        }
    }
}

/// A feature collection of areas.
pub(super) fn text(areas: &[Area]) -> String {
    let features = areas.iter().map(feature_of).collect();
    GeoJson::FeatureCollection(FeatureCollection { bbox: None, features, foreign_members: None }).to_string()
}

/// An area as a feature.
pub(super) fn feature_of(area: &Area) -> Drawn {
    let mut properties = JsonObject::new();
    properties.insert("name".into(), area.name.clone().into());
    properties.insert(Facts::KIND.into(), area.purpose.word().into());
    if let Some(poa) = area.purpose.poa() {
        properties.insert(Facts::POA.into(), poa.into());
    }
    match &area.purpose {
        Purpose::LastKnownPosition { spread: Spread::Normal(meters), .. } => {
            properties.insert(Facts::SPREAD.into(), (*meters).into());
        }
        Purpose::LastKnownPosition { spread: Spread::Quartiles(quartiles), .. }
        | Purpose::LinearFeature { quartiles, .. } => {
            properties.insert(Facts::QUARTILES.into(), quartiles.meters().to_vec().into());
        }
        Purpose::Search(_) | Purpose::NoGo(..) | Purpose::Prior { .. } | Purpose::Start(_) => {}
    }
    Drawn { properties: Some(properties), ..Drawn::from(Geometry::new(geometry(&area.purpose))) }
}

/// The geometry of an area.
fn geometry(purpose: &Purpose) -> GeometryValue {
    match purpose {
        Purpose::Search(region) | Purpose::Prior { region, .. } => multi_polygon(region),
        Purpose::NoGo(region, lines) if lines.0.is_empty() => multi_polygon(region),
        Purpose::NoGo(region, lines) => GeometryValue::GeometryCollection {
            geometries: vec![Geometry::new(multi_polygon(region)), Geometry::new(multi_line(lines))],
        },
        Purpose::LinearFeature { lines, .. } => multi_line(lines),
        Purpose::LastKnownPosition { point, .. } | Purpose::Start(point) => {
            GeometryValue::Point { coordinates: [point.longitude_degrees, point.latitude_degrees].into() }
        }
    }
}

fn multi_polygon(region: &MultiPolygon<f64>) -> GeometryValue {
    let rings = |polygon: &geo::Polygon<f64>| {
        std::iter::once(polygon.exterior()).chain(polygon.interiors()).map(positions).collect()
    };
    GeometryValue::MultiPolygon { coordinates: region.0.iter().map(rings).collect() }
}

fn multi_line(lines: &MultiLineString<f64>) -> GeometryValue {
    GeometryValue::MultiLineString { coordinates: lines.0.iter().map(positions).collect() }
}

fn positions(line: &LineString<f64>) -> Vec<geojson::Position> {
    line.0.iter().map(|corner| [corner.x, corner.y].into()).collect()
}
