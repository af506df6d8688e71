//! An account as `GeoJSON` (RFC 7946), features of these kinds beside the areas of the mission:
//!
//! | `kind` | geometry | further properties |
//! |---|---|---|
//! | `found` | Point | `probability`, `operator`, `declared_at`, `declared_seconds`, `row`, `column`, `picture`, `accuracy_meters` |
//! | `dismissed` | Point | `operator`, `dismissed_at`, `dismissed_seconds`, `row`, `column`, `picture`, `accuracy_meters` |
//! | `clue` | Point | `note`, `ratio`, `radius_meters`, `marked_at`, `marked_seconds`, `row`, `column` |
//! | `searched` | `MultiPolygon` | `note`, `pod`, `cells`, `marked_at`, `marked_seconds` |
//! | `track` | `LineString` | `robot`, `coordTimes` |
//! | `cleared` | `MultiPolygon` | `pod_from`, `pod_to`, `cells` |
//!
//! The point of a find is its position, which is known within `accuracy_meters` with a probability of 95 %; without that property it is the
//! center of its cell. `picture` is the path of a robot's picture of a find, or null. `operator` is what the operator has decided about a find: `confirmed`, `dismissed` or null. A dismissed find that was found
//! again is `found`. `clue` and `searched` are what the operator has marked, as far as it was not withdrawn. An area that was searched has `poa`, `pod`, `pos` and `cells`. In a search for subjects of known number it has
//! `probability_now` too, that of each of them, and the collection `subject`: how many there are (`number`) and how many are expected in declared cells (`found`), in
//! another searched cell (`remaining`), and outside (`rest_of_world`). When the file is read as a map, these features are
//! ignored.

use dragnet_coordinator::finds::Find;
use dragnet_proto::message::Detection;
use dragnet_scenario::map_file::{Area, GeoPoint};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::mark::{Clue, Searched};
use dragnet_search::observation::RobotId;
use dragnet_search::subjects::Standing;
use geo::MultiPolygon;
use geojson::{Feature, FeatureCollection, GeoJson, Geometry, GeometryValue, JsonObject, JsonValue};
use serde_json::json;

use crate::account::{Account, Coverage, Visit};
use crate::bands::{Band, bands, not_searched};
use crate::time::wall_time;

/// The text of a `GeoJSON` file.
#[must_use]
pub fn text(account: &Account) -> String {
    let areas = account.areas.iter().map(|(area, coverage)| drawn(area, coverage.as_ref()));
    let cleared =
        bands(&account.terrain, &account.frame, &account.pod).into_iter().map(|band| cover(&band, "cleared"));
    let not_searched = not_searched(&account.terrain, &account.frame, &account.pod);
    let not_searched = not_searched.map(|band| cover(&band, "not_searched"));
    let tracks = account.tracks.iter().map(|(robot, visits)| track(account, *robot, visits));
    let found = (1..).zip(&account.found).map(|(number, object)| found(account, number, object));
    let dismissed = (1..).zip(&account.dismissed).map(|(number, find)| dismissed(account, number, find));
    let clues = account.clues().map(|clue| self::clue(account, clue));
    let searches = account.searches().map(|search| searched(account, search));
    let marks = clues.chain(searches);
    let features = areas
        .chain(not_searched)
        .chain(cleared)
        .chain(tracks)
        .chain(found)
        .chain(dismissed)
        .chain(marks)
        .collect();
    let mut total = json!({
        "name": account.name,
        "until": wall_time(account.start_unix_ns, account.until),
        "poa": account.total.poa,
        "pod": account.total.pod,
        "pos": account.total.pos(),
        "cells": account.total.cells,
    });
    if let Some(Standing { number, found, remaining, out_of_reach, rest_of_world }) = account.subject {
        total["subject"] = json!({
            "number": number,
            "found": found,
            "remaining": remaining,
            "out_of_reach": out_of_reach,
            "rest_of_world": rest_of_world,
        });
    }
    let foreign_members = total.as_object().cloned();
    let collection = FeatureCollection { bbox: None, features, foreign_members };
    format!("{}\n", GeoJson::FeatureCollection(collection))
}

fn drawn(area: &Area, coverage: Option<&Coverage>) -> Feature {
    let mut feature = area.feature();
    if let Some(coverage) = coverage {
        // That of a region stays as drawn, for who reads the file as a map.
        feature.set_property("poa", area.purpose.poa().unwrap_or(coverage.poa));
        feature.set_property("pod", coverage.pod);
        feature.set_property("pos", coverage.pos());
        feature.set_property("cells", coverage.cells);
        if let Some(now) = coverage.now {
            feature.set_property("probability_now", now);
        }
    }
    feature
}

fn cover(band: &Band, kind: &str) -> Feature {
    let properties = json!({
        "kind": kind,
        "name": band.title(),
        "pod_from": band.from,
        "pod_to": band.to,
        "cells": band.cells,
    });
    feature(properties, GeometryValue::MultiPolygon { coordinates: rings(&band.region) })
}

fn track(account: &Account, robot: RobotId, visits: &[Visit]) -> Feature {
    let time = |visit: &Visit| wall_time(account.start_unix_ns, visit.time);
    let properties = json!({
        "kind": "track",
        "name": format!("Robot {robot}"),
        "robot": robot.number(),
        "coordTimes": visits.iter().map(time).collect::<Vec<_>>(),
    });
    let positions: Vec<geojson::Position> =
        visits.iter().map(|visit| position(account.point(visit.cell))).collect();
    feature(
        properties,
        match <[_; 1]>::try_from(positions) {
            Ok([coordinates]) => GeometryValue::Point { coordinates },
            Err(coordinates) => GeometryValue::LineString { coordinates },
        },
    )
}

fn found(account: &Account, number: usize, object: &Detection) -> Feature {
    let time = MissionTime(object.time_ns);
    let cell = account.terrain.grid().position(object.cell);
    let properties = json!({
        "kind": "found",
        "name": format!("Object {number}"),
        "probability": object.probability,
        "operator": account.operator(object.cell),
        "picture": account.picture_file(object.cell),
        "declared_at": wall_time(account.start_unix_ns, time),
        "declared_seconds": time.as_seconds(),
        "row": cell.row,
        "column": cell.column,
    });
    find(account, object.cell, properties)
}

fn dismissed(account: &Account, number: usize, find: &Find) -> Feature {
    let cell = account.terrain.grid().position(find.cell);
    let properties = json!({
        "kind": "dismissed",
        "name": format!("Dismissed {number}"),
        "operator": account.operator(find.cell),
        "picture": account.picture_file(find.cell),
        "dismissed_at": wall_time(account.start_unix_ns, find.since),
        "dismissed_seconds": find.since.as_seconds(),
        "row": cell.row,
        "column": cell.column,
    });
    self::find(account, find.cell, properties)
}

/// A find where it is known to be.
fn find(account: &Account, cell: Cell, properties: JsonValue) -> Feature {
    let mut feature =
        feature(properties, GeometryValue::Point { coordinates: position(account.place(cell)) });
    if let Some(position) = account.positions.get(&cell) {
        feature.set_property("accuracy_meters", position.accuracy_meters());
    }
    feature
}

fn clue(account: &Account, (number, time, clue, note): (usize, MissionTime, Clue, String)) -> Feature {
    let cell = account.terrain.grid().position(clue.cell);
    let properties = json!({
        "kind": "clue",
        "name": format!("Clue {number}"),
        "note": note,
        "ratio": clue.ratio(),
        "radius_meters": account.radius_meters(clue),
        "marked_at": wall_time(account.start_unix_ns, time),
        "marked_seconds": time.as_seconds(),
        "row": cell.row,
        "column": cell.column,
    });
    feature(properties, GeometryValue::Point { coordinates: position(account.point(clue.cell)) })
}

fn searched(
    account: &Account,
    (number, time, search, note): (usize, MissionTime, Searched, String),
) -> Feature {
    let properties = json!({
        "kind": "searched",
        "name": format!("Searched {number}"),
        "note": note,
        "pod": search.probability_of_detection(),
        "cells": search.cells.len(),
        "marked_at": wall_time(account.start_unix_ns, time),
        "marked_seconds": time.as_seconds(),
    });
    let outline = account.outline(&search.cells);
    feature(properties, GeometryValue::MultiPolygon { coordinates: rings(&outline) })
}

fn feature(properties: JsonValue, geometry: GeometryValue) -> Feature {
    let properties: Option<JsonObject> = match properties {
        JsonValue::Object(properties) => Some(properties),
        _ => None,
    };
    Feature { properties, ..Feature::from(Geometry::new(geometry)) }
}

fn rings(region: &MultiPolygon<f64>) -> Vec<Vec<Vec<geojson::Position>>> {
    let ring = |ring: &geo::LineString<f64>| ring.0.iter().map(|&corner| position(corner.into())).collect();
    let polygon = |polygon: &geo::Polygon<f64>| {
        std::iter::once(polygon.exterior()).chain(polygon.interiors()).map(ring).collect()
    };
    region.iter().map(polygon).collect()
}

fn position(point: GeoPoint) -> geojson::Position {
    [point.longitude_degrees, point.latitude_degrees].into()
}
