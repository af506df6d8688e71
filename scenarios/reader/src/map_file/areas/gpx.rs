//! Tracks, routes and waypoints of GPS receivers as areas (GPX 1.0 and 1.1, `.gpx`). A track that was walked around an area, or a
//! route planned around it, is a polygon; each segment of a track is one. One of kind `linear_feature` is a line. Descriptions and comments say of which kind, as in KML.

use std::path::Path;

use geo::{Distance, Haversine, Point};
use roxmltree::Node;

use super::feature::{Facts, Feature, Position, Shapes};
use super::kind;
use super::kml::{is, parsed, text_of};
use crate::map_file::MapFileError;

/// The most meters between the first and the last point of a closed track: who walks around an area does not end on the
/// point where they began, and receivers err by some meters.
const MAX_GAP_METERS: f64 = 25.0;

pub(super) fn features(file: &Path, text: &str) -> Result<Vec<Feature>, MapFileError> {
    let document = parsed(file, text)?;
    let root = document.root_element();
    if root.tag_name().name() != "gpx" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(MapFileError::value(file, "the root element", found, "<gpx>"));
    }
    // It has no areas: its tracks go around none, and its waypoints are finds.
    let is_export = root.attribute("creator") == Some("dragnet");
    let mut features = Vec::new();
    for (element, word) in [("trk", "track"), ("rte", "route"), ("wpt", "waypoint")] {
        let nodes = root.children().filter(|node| is(*node, element));
        for (number, node) in (1..).zip(nodes) {
            let mut feature = Feature::at(&format!("{word} {number}"), text_of(node, "name"));
            if is_export {
                feature.facts.add_property(Facts::KIND, kind::TRACK);
                features.push(feature);
                continue;
            }
            for name in ["desc", "cmt"] {
                feature.facts.describe(&text_of(node, name).unwrap_or_default());
            }
            let lines = |shapes: &mut Shapes, points: Vec<Position>| {
                shapes.lines.extend((!points.is_empty()).then_some(points));
            };
            match element {
                "trk" if kind::is_linear(&feature) => {
                    for segment in node.children().filter(|node| is(*node, "trkseg")) {
                        lines(&mut feature.shapes, points(segment, "trkpt"));
                    }
                }
                "rte" if kind::is_linear(&feature) => lines(&mut feature.shapes, points(node, "rtept")),
                "trk" => {
                    for segment in node.children().filter(|node| is(*node, "trkseg")) {
                        feature.shapes.polygons.extend(polygon(
                            file,
                            &feature.place,
                            &points(segment, "trkpt"),
                        )?);
                    }
                }
                "rte" => {
                    feature.shapes.polygons.extend(polygon(file, &feature.place, &points(node, "rtept"))?);
                }
                _ => feature.shapes.points.push(position(node)),
            }
            features.push(feature);
        }
    }
    Ok(features)
}

fn points(of: Node<'_, '_>, name: &str) -> Vec<Position> {
    of.children().filter(|node| is(*node, name)).map(position).collect()
}

/// Its longitude and latitude; one that is missing or no number is no place on the earth, which is checked later.
fn position(point: Node<'_, '_>) -> Position {
    let number = |name| point.attribute(name).and_then(|text| text.trim().parse().ok()).unwrap_or(f64::NAN);
    vec![number("lon"), number("lat")]
}

/// The points as a polygon of one closed ring; `None` of no points, as receivers that are switched on and off write them.
fn polygon(
    file: &Path,
    place: &str,
    points: &[Position],
) -> Result<Option<Vec<Vec<Position>>>, MapFileError> {
    let at = |point: &Position| Point::new(point[0], point[1]);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Ok(None) };
    let gap_meters = Haversine.distance(at(first), at(last));
    if gap_meters > MAX_GAP_METERS {
        let found = format!("open: its ends are {gap_meters:.0} m apart");
        let allowed =
            format!("a closed one, around an area, whose ends are at most {MAX_GAP_METERS} m apart");
        return Err(MapFileError::value(file, place, found, allowed));
    }
    if points.len() < 3 {
        let allowed = "at least 3, around an area";
        return Err(MapFileError::value(file, place, "without an area: of fewer than 3 points", allowed));
    }
    let is_closed = first == last;
    Ok(Some(vec![points.iter().chain((!is_closed).then_some(first)).cloned().collect()]))
}

#[cfg(test)]
mod tests {
    use super::super::{Areas, Purpose};
    use super::*;
    use crate::map_file::MapFile;
    use crate::mentions::assert_mentions;

    /// A file as handheld receivers write it: with a namespace, metadata, elevations, times and extensions.
    const GPX: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<gpx xmlns="http://www.topografix.com/GPX/1/1" xmlns:gpxx="http://www.garmin.com/xmlschemas/GpxExtensions/v3"
 creator="eTrex 32x" version="1.1" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
 xsi:schemaLocation="http://www.topografix.com/GPX/1/1 http://www.topografix.com/GPX/1/1/gpx.xsd">
  <metadata><link href="http://www.garmin.com"><text>Garmin International</text></link><time>2026-05-02T09:11:07Z</time></metadata>
  <wpt lat="49.2400" lon="-2.2400"><ele>61.2</ele><time>2026-05-02T09:12:00Z</time><name>CAR</name><desc>kind: start</desc><sym>Flag, Blue</sym></wpt>
  <wpt lat="49.2390" lon="-2.2390"><name>GATE</name></wpt>
  <rte><name>Pond</name><desc>kind: no_go</desc>
    <rtept lat="49.239" lon="-2.238"/><rtept lat="49.239" lon="-2.236"/><rtept lat="49.238" lon="-2.237"/><rtept lat="49.239" lon="-2.238"/>
  </rte>
  <trk><name>Perimeter</name><extensions><gpxx:TrackExtension><gpxx:DisplayColor>Cyan</gpxx:DisplayColor></gpxx:TrackExtension></extensions>
    <trkseg>
      <trkpt lat="49.2410000" lon="-2.2410000"><ele>60.1</ele><time>2026-05-02T09:20:00Z</time></trkpt>
      <trkpt lat="49.2410000" lon="-2.2310000"><ele>60.1</ele><time>2026-05-02T09:30:00Z</time></trkpt>
      <trkpt lat="49.2360000" lon="-2.2310000"><ele>60.1</ele><time>2026-05-02T09:40:00Z</time></trkpt>
      <trkpt lat="49.2360000" lon="-2.2410000"><ele>60.1</ele><time>2026-05-02T09:50:00Z</time></trkpt>
      <trkpt lat="49.2409000" lon="-2.2410000"><ele>60.1</ele><time>2026-05-02T10:00:00Z</time></trkpt>
    </trkseg>
  </trk>
</gpx>
"#;

    fn read(text: &str) -> Result<Areas, String> {
        Areas::from_bytes(Path::new("a.gpx"), text.as_bytes().to_vec()).map_err(|error| error.to_string())
    }

    #[test]
    fn closed_tracks_and_routes_are_areas() {
        let Areas { areas, left_out, .. } = read(GPX).unwrap();
        let words: Vec<_> = areas.iter().map(|area| (area.name.as_str(), area.purpose.word())).collect();
        assert_eq!(words, [("Perimeter", "search"), ("Pond", "no_go"), ("CAR", "start")]);
        assert_eq!(left_out, ["GATE"]);
        // It ended 11 m from where it began: a straight line closes it.
        let ring = areas[0].purpose.polygons()[0].exterior();
        assert!(ring.is_closed() && ring.0.len() == 6, "{ring:?}");
        let Purpose::Start(place) = areas[2].purpose else { panic!("{areas:?}") };
        assert!(
            (place.latitude_degrees - 49.24).abs() < 1e-12 && (place.longitude_degrees + 2.24).abs() < 1e-12
        );
    }

    #[test]
    fn a_track_has_the_kind_and_probability_of_its_description() {
        let text = GPX.replace("<name>Perimeter</name>", "<name>Wood</name><cmt>poa: 60 %</cmt>");
        let wood = &read(&text).unwrap().areas[0];
        assert_eq!((wood.name.as_str(), wood.purpose.poa()), ("Wood", Some(0.6)));
    }

    #[test]
    fn an_empty_track_is_left_out() {
        let text = GPX.replace("<trk><name>P", "<trk><name>A</name><trkseg/></trk><trk><name>P");
        let Areas { areas, left_out, .. } = read(&text).unwrap();
        assert_eq!((areas.len(), &left_out[..]), (3, &["A".to_owned(), "GATE".to_owned()][..]));
    }

    #[test]
    fn an_export_has_results_and_no_area() {
        let text = GPX.replace("eTrex 32x", "dragnet").replace("49.2409000", "49.2400000");
        let Areas { areas, left_out, .. } = read(&text).unwrap();
        assert_eq!((areas.len(), &left_out[..]), (0, &["4 results of an earlier search".to_owned()][..]));
        let of_map = |text: &str| {
            let areas = Areas::from_bytes(Path::new("a.gpx"), text.as_bytes().to_vec()).unwrap();
            MapFile::of_areas(Path::new("a.gpx"), areas, 10.0).unwrap_err().to_string()
        };
        let told = "without a search area: .. export of a search .. tracks and finds; .. GeoJSON or the KML .. a recording .. map has drawn areas";
        assert_mentions(&of_map(&text), told);
        let places = "<gpx><wpt lat='1' lon='2'><name>A</name></wpt></gpx>";
        assert_mentions(&of_map(places), "without a search area; allowed is at least one polygon");
    }

    #[test]
    fn what_is_no_area_is_rejected() {
        let check = |from: &str, to: &str, message: &str| {
            assert_mentions(&read(&GPX.replace(from, to)).unwrap_err(), message);
        };
        check(
            "49.2409000",
            "49.2400000",
            "a.gpx: track 1 \"Perimeter\" is open: its ends are 111 m apart .. at most 25 m",
        );
        check(
            "<rtept lat=\"49.239\" lon=\"-2.238\"/>",
            "",
            "route 1 \"Pond\" is open: its ends are 133 m apart",
        );
        check("lat=\"49.2360000\" lon=\"-2.2310000\"", "lon=\"-2.2310000\"", "track 1 \"Perimeter\" .. NaN");
        check("lat=\"49.2360000\"", "lat=\"x\"", "track 1 \"Perimeter\" .. NaN");
        check(
            "lat=\"49.2410000\" lon=\"-2.2310000\"",
            "lat=\"49.2360000\" lon=\"-2.2410000\"",
            "track 1 \"Perimeter\"",
        );
        check(
            "<desc>kind: no_go</desc>",
            "<desc>keep out: no-go</desc>",
            "route 1 \"Pond\" .. not understood",
        );
        check("<gpx xmlns", "<gqx xmlns", "a.gpx: no XML");
        assert_mentions(&read("<kml/>").unwrap_err(), "root element is <kml>; allowed is <gpx>");
        let dot = "<gpx><rte><rtept lat='1' lon='2'/></rte></gpx>";
        assert_mentions(&read(dot).unwrap_err(), "route 1 .. fewer than 3 points .. at least 3");
        let bomb = "<!DOCTYPE gpx [<!ENTITY a SYSTEM \"file:///etc/passwd\">]><gpx/>";
        assert_mentions(&read(bomb).unwrap_err(), "DOCTYPE");
    }
}
