//! Areas as KML (OGC 12-007r2), as Google Earth, `CalTopo` and QGIS write it. Nothing that a file names is fetched, and
//! a document type, with which entities come, is refused.

use std::path::Path;

use roxmltree::{Document, Node, ParsingOptions};

use super::feature::{Feature, Position, Shapes};
use crate::map_file::MapFileError;

/// The most elements, texts and comments of one file.
const MAX_NODES: u32 = 1_000_000;

pub(super) fn features(file: &Path, text: &str) -> Result<Vec<Feature>, MapFileError> {
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| syntax(file, &error))?;
    let root = document.root_element();
    if root.tag_name().name() != "kml" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(MapFileError::value(file, "the root element", found, "<kml>"));
    }
    let line_ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
    let reader = Reader { file, line_ends };
    root.descendants().filter(|node| is(*node, "Placemark")).map(|node| reader.feature(node)).collect()
}

fn syntax(file: &Path, error: &roxmltree::Error) -> MapFileError {
    match error {
        roxmltree::Error::DtdDetected => {
            let allowed = "no document type, and so no entities but those of XML itself";
            MapFileError::value(file, "the beginning", "a <!DOCTYPE>", allowed)
        }
        roxmltree::Error::NodesLimitReached => {
            MapFileError::value(file, "number of elements", format!("above {MAX_NODES}"), "fewer")
        }
        other => MapFileError::syntax(file, format!("no XML: {other}")),
    }
}

struct Reader<'a> {
    file: &'a Path,
    /// Where lines of the text end, bytes.
    line_ends: Vec<usize>,
}

impl Reader<'_> {
    fn feature(&self, placemark: Node<'_, '_>) -> Result<Feature, MapFileError> {
        let mut feature = Feature::at(&self.line(placemark), text_of(placemark, "name"));
        let extended = placemark.children().filter(|node| is(*node, "ExtendedData"));
        for node in extended.flat_map(|extended| extended.descendants()) {
            let value = match node.tag_name().name() {
                "Data" => text_of(node, "value"),
                "SimpleData" => node.text().map(str::to_owned),
                _ => None,
            };
            if let Some((key, value)) = node.attribute("name").zip(value) {
                feature.facts.say(key, &value);
            }
        }
        feature.facts.describe(&text_of(placemark, "description").unwrap_or_default());
        feature.shapes = self.shapes(placemark)?;
        Ok(feature)
    }

    fn shapes(&self, placemark: Node<'_, '_>) -> Result<Shapes, MapFileError> {
        let mut shapes = Shapes::default();
        for node in placemark.descendants() {
            match node.tag_name().name() {
                "Polygon" => shapes.polygons.push(self.rings(node)?),
                "LineString" => shapes.lines.push(self.coordinates(node)?),
                "Point" => shapes.points.extend(self.coordinates(node)?),
                _ => {}
            }
        }
        Ok(shapes)
    }

    /// The outer boundary first, whatever the order in the file.
    fn rings(&self, polygon: Node<'_, '_>) -> Result<Vec<Vec<Position>>, MapFileError> {
        let boundaries = |name| polygon.children().filter(move |node| is(*node, name));
        boundaries("outerBoundaryIs")
            .chain(boundaries("innerBoundaryIs"))
            .flat_map(|boundary| boundary.children().filter(|node| is(*node, "LinearRing")))
            .map(|ring| self.coordinates(ring))
            .collect()
    }

    /// Tuples `longitude,latitude[,altitude]` between spaces.
    fn coordinates(&self, shape: Node<'_, '_>) -> Result<Vec<Position>, MapFileError> {
        let text = text_of(shape, "coordinates").unwrap_or_default();
        let position = |tuple: &str| tuple.split(',').map(|word| word.parse().ok()).collect::<Option<_>>();
        let read = |tuple: &str| {
            position(tuple).ok_or_else(|| {
                let shown: String = tuple.chars().take(40).collect();
                let place = format!("{}, coordinates", self.line(shape));
                let allowed = "longitude,latitude between spaces";
                MapFileError::value(self.file, place, format!("{shown:?}"), allowed)
            })
        };
        text.split_whitespace().map(read).collect()
    }

    fn line(&self, node: Node<'_, '_>) -> String {
        let start = node.range().start;
        format!("line {}", self.line_ends.partition_point(|&end| end < start) + 1)
    }
}

fn is(node: Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// All text of the first child of a name.
fn text_of(node: Node<'_, '_>, name: &str) -> Option<String> {
    let child = node.children().find(|child| is(*child, name))?;
    Some(child.children().filter_map(|part| part.text()).collect())
}
