use std::path::Path;

use dragnet_search::cell::Position;
use dragnet_search::terrain::Terrain;
use geo::Area as _;
use proptest::prelude::*;

use super::*;
use crate::map_file::{Georeference, MapFile};
use crate::mentions::assert_mentions;

/// Output of Google Earth, `CalTopo` and QGIS.
const KML: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">
<Document><Folder><name>Search &amp; rescue</name>
  <Placemark><name>Valley</name>
    <Polygon><tessellate>1</tessellate>
      <innerBoundaryIs><LinearRing><coordinates>
        0.004,0.004,0 0.005,0.004,0 0.005,0.005,0 0.004,0.004,0</coordinates></LinearRing></innerBoundaryIs>
      <outerBoundaryIs><LinearRing><coordinates>
        0,0,0 0.01,0,0 0.01,0.01,0 0,0.01,0 0,0,0
      </coordinates></LinearRing></outerBoundaryIs>
    </Polygon>
  </Placemark>
  <Placemark><name>Quarry</name><description><![CDATA[Steep!<br>kind: no go]]></description>
    <Polygon><outerBoundaryIs><LinearRing><coordinates>
      0.002,0.002 0.003,0.002 0.003,0.003 0.002,0.002</coordinates></LinearRing></outerBoundaryIs></Polygon>
  </Placemark>
  <Placemark><name>Ridge</name>
    <ExtendedData><SchemaData schemaUrl="a"><SimpleData name="POA">25 %</SimpleData></SchemaData></ExtendedData>
    <MultiGeometry><Polygon><outerBoundaryIs><LinearRing><coordinates>
      0.006,0.006 0.008,0.006 0.008,0.008 0.006,0.006</coordinates></LinearRing></outerBoundaryIs></Polygon>
    </MultiGeometry>
  </Placemark>
  <Placemark><name>Car</name>
    <ExtendedData><Data name="kind"><value>last_known_position</value></Data>
      <Data name="poa"><value>0.5</value></Data><Data name="spread_meters"><value>150</value></Data></ExtendedData>
    <Point><coordinates>0.001,0.002,30</coordinates></Point>
  </Placemark>
  <Placemark><name>Command post</name><Point><coordinates>0,0</coordinates></Point></Placemark>
</Folder></Document></kml>"#;

fn kml(text: &str) -> Result<Areas, String> {
    Areas::from_kml(Path::new("a.kml"), text).map_err(|error| error.to_string())
}

fn geojson(text: &str) -> Result<Areas, String> {
    Areas::from_geojson(Path::new("a.geojson"), text).map_err(|error| error.to_string())
}

/// A collection of features, each of properties and a geometry.
fn collection(features: &[(&str, &str)]) -> String {
    let feature = |(properties, geometry): &(&str, &str)| {
        format!(r#"{{"type":"Feature","properties":{{{properties}}},"geometry":{geometry}}}"#)
    };
    let features: Vec<String> = features.iter().map(feature).collect();
    format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","))
}

const TRIANGLE: &str = r#"{"type":"Polygon","coordinates":[[[0,0],[0.01,0],[0,0.01],[0,0]]]}"#;
const POINT: &str = r#"{"type":"Point","coordinates":[0.001,0.002]}"#;
const SQUARE: &str = r#"{"type":"Polygon","coordinates":[[[0,0],[0.01,0],[0.01,0.01],[0,0]]]}"#;
const LINE: &str = r#"{"type":"LineString","coordinates":[[0,0],[0.01,0.01]]}"#;

#[test]
fn the_kind_of_each_placemark_is_read_from_a_kml() {
    let read = kml(KML).unwrap();
    let names: Vec<(&str, &str)> =
        read.areas.iter().map(|area| (area.name.as_str(), area.purpose.word())).collect();
    let expected =
        [("Valley", "search"), ("Quarry", "no_go"), ("Ridge", "prior"), ("Car", "last_known_position")];
    assert_eq!(names, expected);
    assert_eq!(read.left_out, ["Command post"]);
    assert_eq!(read.areas[0].purpose.polygons()[0].interiors().len(), 1, "whichever boundary comes first");
    assert_eq!(read.areas[2].purpose.poa(), Some(0.25));
    let point = GeoPoint { longitude_degrees: 0.001, latitude_degrees: 0.002 };
    assert_eq!(
        read.areas[3].purpose,
        Purpose::LastKnownPosition { point, spread: Spread::Normal(150.0), poa: 0.5 }
    );
}

#[test]
fn areas_that_are_written_are_read_back() {
    let read = kml(KML).unwrap();
    let again = geojson(&read.to_geojson()).unwrap();
    assert_eq!(again.areas, read.areas);
    let fence = geojson(&collection(&[(r#""kind":"no_go","name":"fence""#, LINE)])).unwrap();
    assert_eq!(geojson(&fence.to_geojson()).unwrap(), fence);
}

/// As outlines of cities and parks are published.
#[test]
fn faults_that_change_next_to_nothing_are_mended_and_told_if_anything_is_lost() {
    let square = |more: &str| format!("[[0,0],[0.01,0],[0.01,0.01]{more},[0,0.01],[0,0]]");
    let hole = "[[0,0],[0.004,0],[0.004,0.004],[0,0]]";
    for (rings, fault, share) in [
        // A spike, a corner that is drawn twice, and a loop of a meter.
        (square(",[0.02,0.02],[0.01,0.01]"), Some("ring 1 crosses or touches itself"), 1.0),
        (square(",[0.005,0.01],[0.006,0.01],[0.005,0.01]"), None, 1.0),
        (
            square(",[0.005,0.01],[0.00501,0.01001],[0.00501,0.01],[0.005,0.01001]"),
            Some("crosses or touches"),
            1.0,
        ),
        // Two triangles that meet in a corner, a bridge to a hole, a hole without ground, and one that is a bay.
        ("[[0,0],[0.01,0],[0.01,0.01],[0.005,0],[0,0.01],[0,0]]".to_owned(), None, 0.5),
        (
            square(",[0.005,0.01],[0.005,0.007],[0.006,0.005],[0.004,0.005],[0.005,0.007],[0.005,0.01]"),
            None,
            0.98,
        ),
        (
            format!("{},[[0.001,0.002],[0.003,0.002],[0.003,0.002],[0.001,0.002]]", square("")),
            Some("ring 2 has fewer than 3 corners"),
            1.0,
        ),
        (
            format!("{},[[0.001,0.002],[0.003,0.002],[0.002,0.002],[0.001,0.002]]", square("")),
            Some("ring 2 has no ground"),
            1.0,
        ),
        (format!("{},{hole}", square("")), None, 0.92),
    ] {
        let geometry = format!(r#"{{"type":"Polygon","coordinates":[{rings}]}}"#);
        let read = geojson(&collection(&[(r#""name":"Park""#, &geometry)])).unwrap();
        match (&read.mended[..], fault) {
            ([mended], Some(fault)) => {
                assert_mentions(mended, &format!("feature 1 .. \"Park\", polygon 1: .. {fault}"));
            }
            (told, fault) => assert!(told.is_empty() && fault.is_none(), "{rings}: {told:?}"),
        }
        let area = MultiPolygon::new(read.areas[0].purpose.polygons().to_vec()).unsigned_area();
        assert!((area - share * 1e-4).abs() < 1e-7, "{rings}: {area}");
        let again = geojson(&read.to_geojson()).unwrap();
        assert_eq!((&again.areas, again.mended.len()), (&read.areas, 0), "{rings}");
    }
    let line = "[[[0.1,0.1],[0.2,0.1],[0.2,0.1],[0.1,0.1]]]";
    let beside = format!(r#"{{"type":"MultiPolygon","coordinates":[{line},[{}]]}}"#, square(""));
    let read = geojson(&collection(&[("", &beside)])).unwrap();
    assert_eq!((read.areas[0].purpose.polygons().len(), read.mended.len()), (1, 1));
    // Ground of no width.
    let line = r#"{"type":"Polygon","coordinates":[[[8,49],[8.01,49.02],[8.003,49.006],[8,49]]]}"#;
    let error = geojson(&collection(&[(r#""name":"Path""#, line)])).unwrap_err();
    assert_mentions(
        &error,
        "feature 1 .. \"Path\", polygon 1 is not an area: ring 1 has no ground .. on one line",
    );
    // Two lobes that cancel each other out, and a polygon that is drawn twice.
    for rings in [
        "[[0,0],[0.01,0.01],[0.01,0],[0,0.01],[0,0]]",
        "[[0,0],[0.01,0],[0,0.01],[0,0],[0.01,0],[0,0.01],[0,0]]",
    ] {
        let geometry = format!(r#"{{"type":"Polygon","coordinates":[{rings}]}}"#);
        assert_mentions(
            &geojson(&collection(&[("", &geometry)])).unwrap_err(),
            "not an area: ring 1 crosses",
        );
    }
}

#[test]
fn without_a_kind_a_polygon_is_searched_and_one_with_a_poa_is_a_prior() {
    let text = collection(&[
        ("", TRIANGLE),
        (r#""poa":0.5,"title":"A""#, TRIANGLE),
        (r#""poa":"30%","spread_meters":100"#, POINT),
        (r#""name":"track""#, LINE),
        (r#""class":"Folder","title":"Folder""#, "null"),
        (r#""kind":"cleared","name":"an export of ours""#, TRIANGLE),
        (r#""kind":"dismissed","name":"Dismissed 1""#, POINT),
        (r#""description":"kind = prior\npoa: 1 %""#, TRIANGLE),
    ]);
    let read = geojson(&text).unwrap();
    let given: Vec<_> =
        read.areas.iter().map(|it| (it.name.as_str(), it.purpose.word(), it.purpose.poa())).collect();
    let expected = [
        ("feature 1", "search", None),
        ("A", "prior", Some(0.5)),
        ("feature 3", "last_known_position", Some(0.3)),
        ("feature 8", "prior", Some(0.01)),
    ];
    assert_eq!(given, expected);
    assert_eq!(read.left_out, ["track", "Folder", "2 results of an earlier search"]);
}

#[test]
fn an_area_of_the_wrong_kind_is_rejected() {
    let check = |properties: &str, geometry: &str, message: &str| {
        let error = geojson(&collection(&[(properties, geometry)])).unwrap_err();
        assert!(error.starts_with("a.geojson: feature 1"), "{error}");
        assert_mentions(&error, message);
    };
    check(
        r#""kind":"forest","name":"A""#,
        TRIANGLE,
        "\"A\" .. kind .. \"forest\" .. search, no_go, prior, last_known_position",
    );
    check(r#""kind":"search""#, POINT, "search .. 1 point .. a polygon");
    check(r#""kind":"no_go""#, "null", "no_go .. nothing .. a polygon or a line");
    check(r#""kind":"last_known_position""#, TRIANGLE, "1 polygon .. one point");
    check(r#""kind":"prior""#, TRIANGLE, "poa .. missing .. 0 to 1");
    check(r#""poa":25"#, TRIANGLE, "poa .. 25 .. a share");
    check(r#""kind":"no_go","poa":"30%""#, LINE, "poa .. \"30%\" .. none with no_go");
    check(r#""kind":"search","poa":0.5"#, TRIANGLE, "poa .. \"0.5\" .. none with search");
    let account = collection(&[(r#""kind":"search","poa":0.5,"pod":0.9"#, TRIANGLE)]);
    assert_eq!(geojson(&account).unwrap().areas[0].purpose.word(), "search", "an export of ours");
    check(r#""poa":"nan""#, TRIANGLE, "poa .. nan .. allowed");
    check(r#""poa":"-3%""#, TRIANGLE, "poa .. -3% .. allowed");
    check(r#""poa":0.5"#, POINT, "spread_meters .. missing .. 0 to 100000");
    check(r#""poa":0.5,"spread_meters":0"#, POINT, "spread_meters .. 0 .. allowed");
    check(r#""poa":0.5,"spread_meters":"inf""#, POINT, "spread_meters .. inf .. allowed");
}

#[test]
fn contradictory_properties_are_rejected() {
    let check = |properties: &str, message: &str| {
        let error = geojson(&collection(&[(properties, TRIANGLE)])).unwrap_err();
        assert_mentions(&error, message);
    };
    let conflict = "feature 1 .. kind .. \"search\" .. \"no_go\" .. one value";
    check(r#""kind":"search","description":"kind: no_go""#, conflict);
    check(r#""Kind":"search","kind":"no_go""#, conflict);
    check(r#""poa":"30%","description":"poa: 0.4""#, "feature 1 .. poa .. \"30%\" .. \"0.4\" .. one");
    let twice = "\"kind\" .. twice .. each key once .. line 1";
    check(r#""kind":"no_go","kind":"search""#, twice);
    check(r#""a":[{"kind":1,"kind":1}]"#, twice);
    let data = "<ExtendedData><Data name='kind'><value>prior</value></Data></ExtendedData>";
    let described = format!("{data}<description>kind: no_go</description>{KML_TRIANGLE}");
    assert_mentions(&kml(&placemark(&described)).unwrap_err(), "kind .. \"prior\" .. \"no_go\"");
    let same = r#""kind":"no_go","description":"kind: No go""#;
    assert_eq!(geojson(&collection(&[(same, TRIANGLE)])).unwrap().areas[0].purpose.word(), "no_go");
    let same = r#""poa":0.3,"description":"poa: 30 %""#;
    assert_eq!(geojson(&collection(&[(same, TRIANGLE)])).unwrap().areas[0].purpose.poa(), Some(0.3));
}

#[test]
fn shapes_that_a_kind_does_not_use_are_ignored_and_reported() {
    let left_out = |properties: &str, shapes: &[&str]| {
        let shapes = shapes.join(",");
        let geometry = format!(r#"{{"type":"GeometryCollection","geometries":[{shapes}]}}"#);
        let read = geojson(&collection(&[(&format!(r#""name":"A"{properties}"#), &geometry)])).unwrap();
        assert_eq!(read.areas.len(), 1, "{properties}");
        read.left_out
    };
    assert_eq!(left_out("", &[TRIANGLE, LINE, POINT, POINT]), ["1 line and 2 points of A"]);
    assert_eq!(left_out(r#","poa":0.5"#, &[LINE, TRIANGLE]), ["1 line of A"]);
    assert_eq!(left_out(r#","kind":"no_go""#, &[TRIANGLE, LINE, POINT]), ["1 point of A"]);
    let position = r#","kind":"last_known_position","poa":0.5,"spread_meters":100"#;
    assert_eq!(left_out(position, &[TRIANGLE, POINT]), ["1 polygon of A"]);
    assert!(left_out(r#","kind":"no_go""#, &[TRIANGLE, LINE]).is_empty());
}

/// A KML file with one placemark of this content.
fn placemark(content: &str) -> String {
    format!("<kml><Document><Placemark>{content}</Placemark></Document></kml>")
}

const KML_LINE: &str = "<LineString><coordinates>0,0 0.01,0.01</coordinates></LineString>";
const KML_POINT: &str = "<Point><coordinates>0.001,0.002</coordinates></Point>";
const KML_TRIANGLE: &str = "<Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 0.01,0 0,0.01 0,0</coordinates>\
                            </LinearRing></outerBoundaryIs></Polygon>";

#[test]
fn html_and_plain_text_descriptions_are_equivalent() {
    let check = |description: &str, shape: &str, word: &str| {
        for whole in [
            format!("<description><![CDATA[{description}]]></description>"),
            format!("<description>{description}</description>"),
            format!("<description>{}</description>", description.replace('<', "&lt;")),
        ] {
            let areas = kml(&placemark(&format!("<name>A</name>{whole}{shape}"))).unwrap();
            assert_eq!(
                areas.areas.iter().map(|area| area.purpose.word()).collect::<Vec<_>>(),
                [word],
                "{whole}"
            );
        }
    };
    check("<div>kind: no_go</div>", KML_LINE, "no_go");
    check("<p>poa: 60%</p><p>spread_meters: 100</p>", KML_POINT, "last_known_position");
    check("<table><tr><td>poa</td><td>60%</td></tr></table>", KML_TRIANGLE, "prior");
    check("<b>Cliff</b><br/><i>kind</i>: no-go", KML_TRIANGLE, "no_go");
    let property = r#""description":"<p>kind: no_go</p>""#;
    assert_eq!(geojson(&collection(&[(property, LINE)])).unwrap().areas[0].purpose.word(), "no_go");
}

#[test]
fn commented_out_elements_have_no_effect() {
    let word = |content: &str| {
        let areas = kml(&placemark(content)).unwrap().areas;
        areas[0].purpose.word()
    };
    assert_eq!(word(&format!("<description><!-- kind: no_go --></description>{KML_TRIANGLE}")), "search");
    assert_eq!(
        word(&format!("<description><![CDATA[<!-- kind: no_go -->]]>a wood</description>{KML_TRIANGLE}")),
        "search"
    );
    let data = "<ExtendedData><Data name='kind'><!-- search --><value><!-- search -->no_go</value></Data>\
                <SimpleData name='poa'><!-- 1 --></SimpleData></ExtendedData>";
    assert_eq!(word(&format!("{data}{KML_TRIANGLE}")), "no_go");
    let commented = KML_TRIANGLE.replace("0.01,0 ", "<!-- a corner -->0.01,0<!-- 0,0 --> ");
    assert_eq!(kml(&placemark(&commented)).unwrap(), kml(&placemark(KML_TRIANGLE)).unwrap());
}

/// A cliff that is not understood must not be ignored.
#[test]
fn a_feature_that_seems_meant_but_is_not_understood_is_rejected_by_name() {
    let refused = |content: &str, message: &str| {
        let error = kml(&placemark(&format!("<name>Cliff</name>{content}"))).unwrap_err();
        assert!(error.starts_with("a.kml: line 1 \"Cliff\""), "{error}");
        assert_mentions(&error, message);
    };
    let described = |text: &str, shape: &str| format!("<description>{text}</description>{shape}");
    refused(&described("kind no_go", KML_LINE), "\"kind no_go\" .. not understood .. a property");
    refused(&described("kind:", KML_LINE), "\"kind:\" .. not understood");
    refused(&described("This is a no-go area!", KML_TRIANGLE), "\"This is a no-go area!\"");
    refused(&described("POA is 60 %", KML_TRIANGLE), "\"POA is 60 %\"");
    refused(&described("spread_meters: 100", KML_POINT), "poa .. missing");
    refused(&described("poa: 60%", KML_LINE), "1 line .. a polygon or one point");
    let data = |key: &str, value: &str, shape: &str| {
        format!("<ExtendedData><Data name='{key}'><value>{value}</value></Data></ExtendedData>{shape}")
    };
    refused(&data("type", "No go", KML_LINE), "\"type: No go\" .. not understood");
    refused(&data("POA (%)", "60", KML_TRIANGLE), "\"POA (%): 60\" .. not understood");
    let error = kml(&placemark(&format!("<name>No-go: cliff</name>{KML_TRIANGLE}"))).unwrap_err();
    assert_mentions(&error, "name .. \"No-go: cliff\" .. not understood");
    // A feature with a kind may have any other properties, and no unnecessary ones are required.
    for content in [
        format!("<name>No go</name>{}", data("kind", "search", KML_TRIANGLE)),
        format!("<name>A</name>{}", described("beside the no-go area\nkind: search", KML_TRIANGLE)),
        format!("<name>A</name>{}", described("What kind of wood: mixed\nIt spread.", KML_TRIANGLE)),
        format!("<name>A</name>{}", data("kind", "", KML_TRIANGLE)),
        format!("<name>A</name>{}", data("kind_of_wood", "mixed", KML_TRIANGLE)),
    ] {
        assert_eq!(kml(&placemark(&content)).unwrap().areas[0].purpose.word(), "search", "{content}");
    }
    let link = "<kml><NetworkLink><name>More</name></NetworkLink></kml>";
    assert_eq!(kml(link).unwrap().left_out, ["More"]);
}

#[test]
fn coordinates_of_another_system_are_rejected() {
    let check = |crs: &str, is_read: bool| {
        let member = format!(r#""crs":{{"type":"name","properties":{{"name":"{crs}"}}}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{TRIANGLE}}}"#);
        for text in [
            format!(r#"{{"type":"FeatureCollection",{member},"features":[{feature}]}}"#),
            format!(r#"{{"type":"Feature",{member},"properties":{{}},"geometry":{TRIANGLE}}}"#),
            TRIANGLE.replacen('{', &format!("{{{member},"), 1),
        ] {
            match geojson(&text) {
                Ok(read) => assert!(is_read && read.areas.len() == 1, "{text}"),
                Err(error) => {
                    assert!(!is_read, "{error}");
                    assert_mentions(
                        &error,
                        &format!("a.geojson .. crs .. \"{crs}\" .. longitude and latitude"),
                    );
                }
            }
        }
    };
    check("urn:ogc:def:crs:OGC:1.3:CRS84", true);
    check("urn:ogc:def:crs:EPSG::4326", true);
    check("EPSG:4326", true);
    check("urn:ogc:def:crs:EPSG::2056", false);
    check("EPSG:3857", false);
    check("http://www.opengis.net/def/crs/EPSG/0/32632", false);
}

/// Comparing each attribute with each would take minutes.
#[test]
fn elements_with_attributes_without_end_are_rejected_at_once() {
    let attributes = |count: usize, name: &str| {
        (0..count).map(|it| format!(" {name}{it}='1'")).collect::<Vec<_>>().concat()
    };
    let check = |text: &str| {
        let error = kml(text).unwrap_err();
        assert_mentions(&error, "line 2 .. an element .. at most 100");
    };
    check(&format!("<kml>\n<Document{}></Document></kml>", attributes(160_000, "a")));
    check(&format!("<kml>\n<Document{}/></kml>", attributes(101, "a")));
    assert!(kml(&format!("<kml>\n<Document{}/></kml>", attributes(100, "a"))).is_ok());
    // Namespaces are in scope in all nested elements.
    let nested = (0..60_000).map(|it| format!("<a xmlns:n{it}='b'>")).collect::<Vec<_>>().concat();
    check(&format!("<kml>\n{nested}"));
    let beside = (0..1000).map(|it| format!("<a xmlns:n{it}='b'></a>")).collect::<Vec<_>>().concat();
    assert!(kml(&format!("<kml>\n{beside}</kml>")).is_ok());
    let nested = "<Placemark>".repeat(100_000) + &"</Placemark>".repeat(100_000);
    let error = kml(&format!("<kml>{nested}</kml>")).unwrap_err();
    assert_mentions(&error, "placemark .. line 1 .. within another");
}

#[test]
fn an_invalid_kml_is_rejected_with_its_line() {
    let check = |text: &str, message: &str| {
        let error = kml(text).unwrap_err();
        assert!(error.starts_with("a.kml: "), "{error}");
        assert_mentions(&error, message);
    };
    check("", "no XML");
    check("<kml><Document></kml>", "no XML .. 'Document' .. 'kml' .. 1:16");
    check("<html/>", "root element .. <html> .. <kml>");
    let bomb = "<!DOCTYPE kml [<!ENTITY a SYSTEM \"file:///etc/passwd\">]><kml><name>&a;</name></kml>";
    check(bomb, "<!DOCTYPE> .. no document type");
    check("<kml><name>&a;</name></kml>", "no XML .. 'a' .. 1:12");
    let quarry = |from: &str, to: &str| KML.replace(from, to);
    check(
        &quarry("0.003,0.002", "0.003 0.002"),
        "\"Quarry\" .. polygon 1 .. ring 1 .. position 2 .. [0.003]",
    );
    check(&quarry("0.003,0.002", "0,003,0,x"), "line 14 .. coordinates .. \"0,003,0,x\" .. longitude");
    check(&quarry("0.003,0.002", "0.003,NaN"), "position 2 .. [0.003, NaN] .. [longitude, latitude]");
    check(&quarry("0.003,0.002", "0.003,91"), "line 13 .. \"Quarry\" .. polygon 1 .. ring 1 .. position 2");
    check(&quarry("0.003,0.002 0.003,0.003", ""), "ring 1 .. 2 .. at least 4");
    check(&quarry("0.008,0.008", "0.006,0.006"), "line 17 .. \"Ridge\" .. polygon 1");
}

/// What a person writes for a no-go area without knowing the convention must not become a search area.
#[test]
fn a_no_go_area_is_never_searched_for_want_of_a_word() {
    for properties in [r#""Description":"kind: no_go""#, r#""DESCRIPTION":"<p>kind: no_go</p>""#] {
        let areas = geojson(&collection(&[(properties, SQUARE)])).unwrap();
        assert!(matches!(areas.areas[0].purpose, Purpose::NoGo(..)), "{properties}");
    }
    let polygon = "<Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 0.1,0 0.1,0.1 0,0</coordinates>\
                   </LinearRing></outerBoundaryIs></Polygon>";
    let placemark = |inside: &str| format!("<Placemark>{inside}{polygon}</Placemark>");
    let mut errors: Vec<(String, Result<Areas, String>)> = Vec::new();
    for properties in [
        r#""Name":"No-go quarry""#,
        r#""notes":"kind: no_go""#,
        r#""comment":"no go area""#,
        r#""no_go":true"#,
        r#""nogo":"yes""#,
        r#""properties":{"kind":"no_go"}"#,
        r#""name":"Quarry","title":"No-go""#,
    ] {
        errors.push((properties.to_owned(), geojson(&collection(&[(properties, SQUARE)]))));
    }
    for foreign in [r#""kind":"no_go""#, r#""folder":"No-go areas""#] {
        let feature = collection(&[(r#""name":"A""#, SQUARE)]);
        let of_feature = feature.replace(r#""properties""#, &format!(r#"{foreign},"properties""#));
        errors.push((of_feature.clone(), geojson(&of_feature)));
    }
    let collected = collection(&[(r#""name":"A""#, SQUARE)]);
    let named = collected.replacen('{', r#"{"name":"no_go","#, 1);
    errors.push((named.clone(), geojson(&named)));
    for text in [
        format!("<kml><Document><name>No-go areas</name>{}</Document></kml>", placemark("")),
        format!("<kml><Folder><name>No-go</name><Folder>{}</Folder></Folder></kml>", placemark("")),
        format!("<kml><Folder><description>kind: no_go</description>{}</Folder></kml>", placemark("")),
        format!("<kml>{}</kml>", placemark("<Snippet>kind: no_go</Snippet>")),
    ] {
        errors.push((text.clone(), kml(&text)));
    }
    for (text, result) in errors {
        let error = result.expect_err(&text);
        assert_mentions(&error, "not understood .. a property");
    }
    // A column of a table, a folder beside, and a kind that is said.
    assert!(geojson(&collection(&[(r#""no_go":false"#, SQUARE)])).is_ok());
    let beside = format!("<kml><Folder><name>No-go</name></Folder>{}</kml>", placemark(""));
    assert!(kml(&beside).is_ok());
    let said = placemark("<description>kind: search</description>");
    assert!(
        kml(&format!("<kml><Document><name>No-go and search areas</name>{said}</Document></kml>")).is_ok()
    );
}

#[test]
fn files_that_are_too_large_are_rejected() {
    let points = |count: usize| vec!["[0,0]"; count].join(",");
    let line = format!(r#"{{"type":"LineString","coordinates":[{}]}}"#, points(MAX_CORNERS + 1));
    let error = geojson(&line).unwrap_err();
    assert_mentions(&error, "corners .. 20001 .. at most 20000");
    let many = vec![("", POINT); MAX_FEATURES + 1];
    let error = geojson(&collection(&many)).unwrap_err();
    assert_mentions(&error, "features .. 10001 .. at most 10000");
    // Deeply nested elements.
    let deep = "<kml>".repeat(200_000);
    assert!(kml(&deep).is_err());
    assert_eq!(kml(&(deep + &"</kml>".repeat(200_000))), Ok(Areas::default()));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.kml");
    std::fs::File::create(&file).unwrap().set_len(Areas::MAX_BYTES + 1).unwrap();
    let error = Areas::load(&file).unwrap_err().to_string();
    assert_mentions(&error, "a.kml .. longer than .. 16777216 bytes");
}

/// A map of 10 x 10 cells of 100 m at the equator.
fn map() -> (Georeference, Terrain) {
    let terrain = Terrain::from_ascii(&"..........\n".repeat(10), 100.0).unwrap();
    let corner = GeoPoint { longitude_degrees: 0.0, latitude_degrees: 0.0 };
    (Georeference::of_map(corner, &terrain), terrain)
}

/// A rectangle of cells, from west, south, east and north.
fn rectangle(frame: &Georeference, [west, south, east, north]: [f64; 4]) -> String {
    let corners = [(west, south), (east, south), (east, north), (west, north), (west, south)];
    let at = |(east, north): &(f64, f64)| {
        let point = frame.point((east * 100.0, north * 100.0));
        format!("[{},{}]", point.longitude_degrees, point.latitude_degrees)
    };
    let ring: Vec<String> = corners.iter().map(at).collect();
    format!(r#"{{"type":"Polygon","coordinates":[[{}]]}}"#, ring.join(","))
}

fn prior(features: &[(&str, &str)], objects: f64) -> Result<RegionPrior, String> {
    let (frame, terrain) = map();
    let areas = geojson(&collection(features)).unwrap();
    let prior = areas.prior(Path::new("a.geojson"), &frame, &terrain, objects);
    prior.map(Option::unwrap).map_err(|error| error.to_string())
}

fn sum_in(prior: &RegionPrior, is_in: impl Fn(Position) -> bool) -> f64 {
    let grid = map().1.grid();
    let inside = grid.cells().filter(|&cell| is_in(grid.position(cell)));
    inside.map(|cell| prior.probability[cell.index()]).sum()
}

#[test]
fn each_region_holds_its_share_of_the_objects_and_the_rest_is_spread_outside() {
    let frame = map().0;
    let (south, east) = (rectangle(&frame, [0.0, 0.0, 10.0, 2.0]), rectangle(&frame, [8.0, 5.0, 12.0, 10.0]));
    let features = [(r#""name":"south","poa":"50%""#, &*south), (r#""name":"east","poa":0.2"#, &*east)];
    let prior = prior(&features, 3.0).unwrap();
    assert!((sum_in(&prior, |it| it.row < 2) - 1.5).abs() < 1e-9);
    assert!((sum_in(&prior, |it| it.row >= 5 && it.column >= 8) - 0.6).abs() < 1e-9);
    assert!((prior.probability.iter().sum::<f64>() - 3.0).abs() < 1e-9);
    let regions = &prior.claims.regions;
    assert_eq!((regions[0].cells, regions[1].cells), (20, 10));
    assert!((regions[0].searched_share - 1.0).abs() < 1e-6, "{regions:?}");
    assert!((regions[1].searched_share - 0.5).abs() < 1e-3, "half of it lies beyond the map: {regions:?}");
    assert_eq!(prior.claims.rest.cells, 70);
    assert!((prior.claims.rest.poa - 0.3).abs() < 1e-9);
}

/// A share `1 - exp(-k^2 / 2)` of a normal distribution lies within k standard deviations.
#[test]
fn a_last_known_position_spreads_as_a_normal_distribution() {
    let frame = map().0;
    let center = frame.point((520.0, 480.0));
    let point = format!(
        r#"{{"type":"Point","coordinates":[{},{}]}}"#,
        center.longitude_degrees, center.latitude_degrees
    );
    let prior = prior(&[(r#""poa":1,"spread_meters":100"#, &point)], 1.0).unwrap();
    assert!((prior.probability.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    // Between 400 and 600 m: 1.2 standard deviations below the center and 0.8 above, and the other way round.
    let within = 0.673_074;
    let given = sum_in(&prior, |it| (4..6).contains(&it.row) && (4..6).contains(&it.column));
    assert!((given - within * within).abs() < 1e-4, "{given}");
    let east = sum_in(&prior, |it| it.column >= 6);
    assert!((east - 0.211_855).abs() < 1e-4, "{east}");
    assert!(prior.claims.regions[0].searched_share > 0.999);
}

/// A moor of 3.3 by 2.2 km at the equator, and a trail through it from the south to the north.
const TRAIL: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"Moor"},"geometry":{"type":"Polygon","coordinates":
    [[[0,0],[0.03,0],[0.03,0.02],[0,0.02],[0,0]]]}},
{"type":"Feature","properties":{"kind":"linear_feature","name":"Trail","poa":1,"quartiles_meters":[30,100,300,900]},
    "geometry":{"type":"LineString","coordinates":[[0.01,-0.001],[0.01,0.021]]}}]}"#;

/// The share of the prior within these distances of the trail.
fn shares_of_trail(text: &str, cell_meters: f64, distances: [f64; 4]) -> [f64; 4] {
    let (file, areas) = (Path::new("a.geojson"), Areas::from_geojson(Path::new("a.geojson"), text).unwrap());
    let map = MapFile::of_areas(file, areas.clone(), cell_meters).unwrap();
    let (terrain, frame) = (&map.terrain, map.georeference.unwrap());
    let prior = areas.prior(file, &frame, terrain, 1.0).unwrap().unwrap();
    let trail = frame.meters(GeoPoint { longitude_degrees: 0.01, latitude_degrees: 0.0 }).0;
    distances.map(|distance| {
        let inside = |column: u32| {
            let (west, east) = (f64::from(column) * cell_meters, f64::from(column + 1) * cell_meters);
            (east.min(trail + distance) - west.max(trail - distance)).max(0.0) / cell_meters
        };
        let cells = terrain.searched_cells();
        cells.map(|cell| prior.probability[cell.index()] * inside(terrain.grid().position(cell).column)).sum()
    })
}

#[test]
fn a_linear_feature_has_the_entered_shares_within_their_distances_in_cells_of_any_size() {
    let distances = [30.0, 100.0, 300.0, 900.0];
    for cell_meters in [10.0, 20.0, 30.0, 50.0, 100.0] {
        let given = shares_of_trail(TRAIL, cell_meters, distances);
        for ((given, share), distance) in given.iter().zip([0.25, 0.5, 0.75, 0.95]).zip(distances) {
            // What is narrower than a cell is spread over it.
            if distance < 1.5 * cell_meters {
                continue;
            }
            assert!((given - share).abs() < 0.02, "{cell_meters} m: {given} for {share}");
        }
    }
}

#[test]
fn linear_features_and_places_with_quartiles_are_read_and_written_alike() {
    let areas = Areas::from_geojson(Path::new("a.geojson"), TRAIL).unwrap();
    let quartiles = Quartiles::new([30.0, 100.0, 300.0, 900.0]).unwrap();
    let Purpose::LinearFeature { quartiles: given, poa, .. } = &areas.areas[1].purpose else {
        panic!("{areas:?}")
    };
    assert!(*given == quartiles && (poa - 1.0).abs() < 1e-12);
    let again = Areas::from_geojson(Path::new("a.geojson"), &areas.to_geojson()).unwrap();
    assert_eq!(again.areas, areas.areas);
    // A line with quartiles needs no kind, and neither does a point.
    let bare = TRAIL.replace(r#""kind":"linear_feature","#, "");
    assert_eq!(Areas::from_geojson(Path::new("a.geojson"), &bare).unwrap().areas, areas.areas);
    let point = TRAIL
        .replace(r#""kind":"linear_feature","#, "")
        .replace("LineString", "Point")
        .replace("[[0.01,-0.001],[0.01,0.021]]", "[0.01,0.01]");
    let areas = Areas::from_geojson(Path::new("a.geojson"), &point).unwrap();
    let purpose = &areas.areas[1].purpose;
    let spread = Spread::Quartiles(quartiles);
    assert!(
        matches!(purpose, Purpose::LastKnownPosition { spread: given, .. } if *given == spread),
        "{purpose:?}"
    );
    assert_eq!(Areas::from_geojson(Path::new("a.geojson"), &areas.to_geojson()).unwrap().areas, areas.areas);
    // Lines of a description.
    let described = kml(
        "<kml><Placemark><name>Stream</name><description>kind: Linear feature&lt;br&gt;poa: 25%&lt;br&gt;quartiles_meters: 30, \
         100, 300, 900</description><LineString><coordinates>8,47 8.01,47</coordinates></LineString></Placemark></kml>",
    );
    let described = described.unwrap();
    assert!(matches!(described.areas[0].purpose, Purpose::LinearFeature { .. }), "{described:?}");
    let track = "<gpx><trk><name>Path</name><desc>kind: linear_feature\nquartiles_meters: 30, 100, 300, 900\npoa: 0.5</desc>\
                 <trkseg><trkpt lat='47' lon='8'/><trkpt lat='47.01' lon='8'/></trkseg></trk></gpx>";
    let track = Areas::from_bytes(Path::new("a.gpx"), track.as_bytes().to_vec()).unwrap();
    assert!(matches!(track.areas[0].purpose, Purpose::LinearFeature { .. }), "{track:?}");
}

#[test]
fn invalid_distances_are_rejected() {
    let check = |from: &str, to: &str, message: &str| {
        let error = Areas::from_geojson(Path::new("a.geojson"), &TRAIL.replace(from, to)).unwrap_err();
        assert_mentions(&error.to_string(), message);
    };
    let quartiles = r#""quartiles_meters":[30,100,300,900]"#;
    let without = r#","quartiles_meters":[30,100,300,900]"#;
    check(without, "", "\"Trail\", quartiles_meters is missing .. four distances .. each above");
    check("[30,100,300,900]", "[30,100,300]", "quartiles_meters is [30,100,300] .. four distances");
    check("[30,100,300,900]", "\"30, 20, 300, 900\"", "quartiles_meters is 30, 20, 300, 900");
    check(r#""poa":1,"#, "", "poa .. missing");
    let polygon = "[[[0.01,0],[0.02,0],[0.02,0.01],[0.01,0]]]";
    let drawn = TRAIL.replace("LineString", "Polygon").replace("[[0.01,-0.001],[0.01,0.021]]", polygon);
    let error = Areas::from_geojson(Path::new("a.geojson"), &drawn).unwrap_err().to_string();
    assert_mentions(&error, "linear_feature drawn as 1 polygon .. a line");
    let both = TRAIL
        .replace("linear_feature", "last_known_position")
        .replace(quartiles, &format!("{quartiles},\"spread_meters\":100"))
        .replace("LineString", "Point")
        .replace("[[0.01,-0.001],[0.01,0.021]]", "[0.01,0.01]");
    let error = Areas::from_geojson(Path::new("a.geojson"), &both).unwrap_err().to_string();
    assert_mentions(&error, "spread_meters is 100, beside quartiles_meters .. one of the two");
}

#[test]
fn invalid_regions_are_rejected() {
    let frame = map().0;
    let [cell, all, all_but_one_row, beside, far] = [
        [2.0, 2.0, 3.0, 3.0],
        [0.0, 0.0, 10.0, 10.0],
        [0.0, 0.0, 10.0, 9.0],
        [20.0, 0.0, 30.0, 10.0],
        [20.0, 2000.0, 30.0, 2010.0],
    ]
    .map(|edges| rectangle(&frame, edges));
    let check = |features: &[(&str, &str)], objects: f64, message: &str| {
        let error = prior(features, objects).unwrap_err();
        assert_mentions(&error, message);
    };
    let named = r#""name":"A","poa":"60%""#;
    check(&[(named, &all_but_one_row)], 30.0, "the rest .. 12.000 objects .. 10 cells");
    check(&[(named, &all), (named, &cell)], 1.0, "poa .. 1.200000 .. at most 1");
    check(&[(named, &cell)], 2.0, "area \"A\" .. 1.200 .. below 1");
    check(&[(named, &beside)], 1.0, "area \"A\" .. no searched cell .. an area that touches");
    check(&[(named, &far)], 1.0, "area \"A\" .. 200 km .. at most 100 km");
}

proptest! {
    #[test]
    fn any_text_is_read_or_rejected(text in "\\PC{0,60}") {
        let _ = kml(&text);
        let _ = geojson(&text);
    }

    #[test]
    fn any_change_of_a_kml_is_read_or_rejected(at in 0..KML.len(), length in 0..40_usize, text in "\\PC{0,6}") {
        let mut changed = KML.to_owned();
        changed.replace_range(at..(at + length).min(KML.len()), &text);
        if let Ok(areas) = kml(&changed) {
            let (frame, terrain) = map();
            let _ = areas.prior(Path::new("a.kml"), &frame, &terrain, 1.0);
        }
    }
}

#[test]
fn kml_is_read_in_the_encoding_that_it_declares() {
    let text = |encoding: &str| {
        format!(
            "<?xml version='1.0' encoding='{encoding}'?><kml><Placemark><name>search Bärenalp</name><Polygon><outerBoundaryIs>\
             <LinearRing><coordinates>9.5,47.5 9.51,47.5 9.51,47.51 9.5,47.5</coordinates></LinearRing></outerBoundaryIs>\
             </Polygon></Placemark></kml>"
        )
    };
    let latin: Vec<u8> =
        text("ISO-8859-1").chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect();
    for bytes in [latin.clone(), text("utf-8").into_bytes()] {
        let areas = Areas::from_bytes(Path::new("a.kml"), bytes).unwrap().areas;
        assert_eq!(areas[0].name, "search Bärenalp");
    }
    let declared_wrongly = String::from_utf8_lossy(&latin).replace("ISO-8859-1", "utf-8").into_bytes();
    assert!(Areas::from_bytes(Path::new("a.kml"), declared_wrongly).is_ok(), "its marks are those of errors");
    let error = |bytes: Vec<u8>| Areas::from_bytes(Path::new("a.kml"), bytes).unwrap_err().to_string();
    let mut broken = latin;
    broken.splice(30..40, *b"utf-8     ");
    assert!(error(broken).contains("no UTF-8 text"), "bytes of another encoding");
    assert!(error(text("latin-klingon").into_bytes()).contains("latin-klingon"));
}
