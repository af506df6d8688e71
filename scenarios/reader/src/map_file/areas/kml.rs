//! Areas as KML (OGC 12-007r2), as written by Google Earth, `CalTopo` and QGIS. References to other files are not
//! followed, and document types, and with them entities, are rejected.

use std::path::Path;

use encoding_rs::Encoding;
use quick_xml::Reader as Scan;
use quick_xml::events::{BytesStart, Event};
use roxmltree::{Document, Node, ParsingOptions};

use super::feature::{Facts, Feature, Position, Shapes};
use crate::map_file::MapFileError;

/// The most elements, texts and comments of one file.
const MAX_NODES: u32 = 1_000_000;
/// The most attributes of an element, and of namespaces in scope: each is compared with each.
const MAX_ATTRIBUTES: usize = 100;

pub(super) fn features(file: &Path, text: &str) -> Result<Vec<Feature>, MapFileError> {
    let document = parsed(file, text)?;
    let root = document.root_element();
    if root.tag_name().name() != "kml" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(MapFileError::value(file, "the root element", found, "<kml>"));
    }
    let line_ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
    let reader = Reader { file, line_ends, text };
    let drawn = |node: &Node<'_, '_>| is(*node, "Placemark") || is(*node, "NetworkLink");
    let mut features = Vec::new();
    let mut end = 0;
    // Folders that are open: where each ends, and a text of it, or of one around it, that seems meant for a search.
    let mut folders: Vec<(usize, Option<String>)> = Vec::new();
    for node in root.descendants() {
        while folders.last().is_some_and(|&(end, _)| node.range().start >= end) {
            folders.pop();
        }
        if is(node, "Folder") || is(node, "Document") {
            let around = folders.last().and_then(|(_, text)| text.clone());
            folders.push((node.range().end, around.or_else(|| reader.folder_text(node))));
        }
        if !drawn(&node) {
            continue;
        }
        if node.range().start < end {
            let place = format!("the placemark in {}", reader.line(node));
            return Err(MapFileError::value(file, place, "within another one", "one beside others"));
        }
        end = node.range().end;
        let mut feature = reader.feature(node)?;
        if let Some(line) = folders.last().and_then(|(_, line)| line.as_deref()) {
            feature.facts.suspect_line("in the folder", line);
        }
        features.push(feature);
    }
    Ok(features)
}

/// An XML text, within limits.
pub(super) fn parsed<'a>(file: &Path, text: &'a str) -> Result<Document<'a>, MapFileError> {
    check_attributes(file, text)?;
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| syntax(file, &error))
}

/// The text of an XML file: in the encoding that its XML declaration names, as older programs write it, or in UTF-8 or
/// UTF-16.
pub(super) fn decoded(file: &Path, bytes: Vec<u8>) -> Result<String, MapFileError> {
    let Some(label) = declared_encoding(&bytes) else {
        return dragnet_files::text_of(bytes).map_err(|source| MapFileError::syntax(file, source));
    };
    let Some(encoding) = Encoding::for_label(label) else {
        let found = format!("{:?}", String::from_utf8_lossy(label));
        return Err(MapFileError::value(file, "the encoding", found, "one of the web, such as \"UTF-8\""));
    };
    // Its byte-order mark has the last word.
    let (text, encoding, has_errors) = encoding.decode(&bytes);
    if has_errors {
        return Err(MapFileError::syntax(
            file,
            format!("no {} text, as which it is declared", encoding.name()),
        ));
    }
    Ok(text.into_owned())
}

/// The encoding that an XML declaration names, if there is one and it names one.
fn declared_encoding(bytes: &[u8]) -> Option<&[u8]> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).strip_prefix(b"<?xml")?;
    let end = bytes.windows(2).position(|two| two == b"?>")?;
    let key = b"encoding";
    let begin = bytes[..end].windows(key.len()).position(|word| word == key)? + key.len();
    let value = bytes[begin..end].trim_ascii_start().strip_prefix(b"=")?.trim_ascii_start();
    let (&quote, value) = value.split_first()?;
    value.split(|&byte| byte == quote).next()
}

/// Parsing takes quadratic time in these numbers, and linear time in all else. Other errors are reported by the parser.
fn check_attributes(file: &Path, text: &str) -> Result<(), MapFileError> {
    let mut scan = Scan::from_str(text);
    scan.config_mut().check_end_names = false;
    let is_namespace = |name: &str| name == "xmlns" || name.starts_with("xmlns:");
    let count = |element: &BytesStart<'_>| {
        let mut counts = (0, 0);
        for attribute in element.attributes().with_checks(false).flatten() {
            counts.0 += 1;
            counts.1 += usize::from(is_namespace(attribute.key.as_ref()));
        }
        counts
    };
    // Names of namespaces that each open element has in scope.
    let mut scopes = vec![0];
    loop {
        let (element, is_open) = match scan.read_event() {
            Ok(Event::Start(element)) => (element, true),
            Ok(Event::Empty(element)) => (element, false),
            Ok(Event::End(_)) => {
                scopes.pop();
                continue;
            }
            Ok(Event::Eof) | Err(_) => return Ok(()),
            Ok(_) => continue,
        };
        let (attributes, namespaces) = count(&element);
        let scope = scopes.last().unwrap_or(&0) + namespaces;
        if attributes.max(scope) > MAX_ATTRIBUTES {
            let read = usize::try_from(scan.buffer_position()).unwrap_or(usize::MAX);
            let line = 1 + text.bytes().take(read).filter(|it| *it == b'\n').count();
            let found = format!("an element with {} attributes and namespaces", attributes.max(scope));
            return Err(MapFileError::value(
                file,
                format!("line {line}"),
                found,
                format!("at most {MAX_ATTRIBUTES}"),
            ));
        }
        if is_open {
            scopes.push(scope);
        }
    }
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
    text: &'a str,
}

impl Reader<'_> {
    fn feature(&self, placemark: Node<'_, '_>) -> Result<Feature, MapFileError> {
        let mut feature = Feature::at(&self.line(placemark), text_of(placemark, "name"));
        let extended = placemark.children().filter(|node| is(*node, "ExtendedData"));
        for node in extended.flat_map(|extended| extended.descendants()) {
            let value = match node.tag_name().name() {
                "Data" => text_of(node, "value"),
                "SimpleData" => Some(text_in(node)),
                _ => None,
            };
            if let Some((key, value)) = node.attribute("name").zip(value) {
                feature.facts.add_property(key, &value);
            }
        }
        if let Some(description) = placemark.children().find(|node| is(*node, "description")) {
            feature.facts.describe(&self.html(description));
        }
        for name in ["Snippet", "snippet"] {
            feature
                .facts
                .suspect_text("described by its snippet as", &text_of(placemark, name).unwrap_or_default());
        }
        feature.shapes = self.shapes(placemark)?;
        Ok(feature)
    }

    /// The line of a folder's name or description that seems meant for a search, if any.
    fn folder_text(&self, folder: Node<'_, '_>) -> Option<String> {
        let description = folder.children().find(|node| is(*node, "description"));
        let texts = [text_of(folder, "name"), description.map(|node| self.html(node))];
        texts.into_iter().flatten().find_map(|text| Facts::line_about_searches(&text))
    }

    /// The content of an element as HTML: its text, and its elements as written.
    fn html(&self, element: Node<'_, '_>) -> String {
        let part = |child: Node<'_, '_>| match child.text() {
            Some(text) if child.is_text() => text.to_owned(),
            _ if child.is_element() => self.text[child.range()].replace("<![CDATA[", "").replace("]]>", ""),
            _ => String::new(),
        };
        element.children().map(part).collect()
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

    /// The rings of a polygon, the outer boundary first, independently of their order in the file.
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

pub(super) fn is(node: Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// All text of the first child of a name.
pub(super) fn text_of(node: Node<'_, '_>, name: &str) -> Option<String> {
    node.children().find(|child| is(*child, name)).map(text_in)
}

/// The text of an element, without its comments.
fn text_in(element: Node<'_, '_>) -> String {
    element.children().filter(Node::is_text).filter_map(|part| part.text()).collect()
}
