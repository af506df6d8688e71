//! The detections as text, as a table and as JSON.

use std::path::Path;

use csv::WriterBuilder;
use dragnet_detector::network::Network;
use dragnet_detector::settings::Settings;
use dragnet_detector::{Detection, Found};
use dragnet_vehicle::camera::Camera;
use dragnet_vehicle::settings::CameraTable;
use serde::Serialize;

use super::camera;
use crate::commands::Failure;
use crate::terminal::counted;
use crate::terminal::table::Table;

/// The detections of an image.
pub(super) struct Seen<'a> {
    pub(super) path: &'a Path,
    pub(super) width_pixels: u32,
    pub(super) height_pixels: u32,
    pub(super) found: Found,
    /// Duration from pixels to boxes.
    pub(super) seconds: f64,
}

#[derive(Serialize)]
pub(super) struct Report<'a> {
    module: String,
    /// Input of the network, pixels.
    input_columns: u32,
    input_rows: u32,
    classes: u32,
    images: Vec<Image>,
    #[serde(skip)]
    network: &'a Network,
    #[serde(skip)]
    factor: u32,
    #[serde(skip)]
    table: Option<CameraTable>,
}

#[derive(Serialize)]
struct Image {
    file: String,
    width_pixels: u32,
    height_pixels: u32,
    seconds: f64,
    /// Anchors with invalid output.
    refused_anchors: usize,
    boxes: Vec<Row>,
}

#[derive(Clone, Serialize)]
struct Row {
    class: u32,
    name: Option<String>,
    confidence: f32,
    left_pixels: f64,
    top_pixels: f64,
    right_pixels: f64,
    bottom_pixels: f64,
    /// Of the box's center in the vehicle's frame, counter-clockwise from forward.
    bearing_radians: Option<f64>,
}

impl<'a> Report<'a> {
    pub(super) fn new(
        module: &Path,
        network: &'a Network,
        settings: &Settings,
        table: Option<CameraTable>,
    ) -> Self {
        Self {
            module: module.display().to_string(),
            input_columns: network.input().width_pixels,
            input_rows: network.input().height_pixels,
            classes: network.classes(),
            images: Vec::new(),
            network,
            factor: settings.resolution.factor(),
            table,
        }
    }

    pub(super) fn push(&mut self, seen: &Seen<'_>) -> Result<(), Failure> {
        let (width_pixels, height_pixels) = (seen.width_pixels, seen.height_pixels);
        let camera =
            self.table.as_ref().map(|table| camera::sized(table, width_pixels, height_pixels)).transpose();
        let camera = camera.map_err(Failure::input)?;
        let row = |detection: &Detection| Row {
            class: detection.class,
            name: self.network.name(detection.class).map(str::to_owned),
            confidence: detection.confidence,
            left_pixels: detection.bounds.left,
            top_pixels: detection.bounds.top,
            right_pixels: detection.bounds.right,
            bottom_pixels: detection.bounds.bottom,
            bearing_radians: camera.as_ref().map(|camera| bearing_radians(camera, detection)),
        };
        self.images.push(Image {
            file: seen.path.display().to_string(),
            width_pixels,
            height_pixels,
            seconds: seen.seconds,
            refused_anchors: seen.found.refused_anchors,
            boxes: seen.found.detections.iter().map(row).collect(),
        });
        Ok(())
    }

    /// A row for each box.
    pub(super) fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.write_record([
            "image",
            "class",
            "name",
            "confidence",
            "left_pixels",
            "top_pixels",
            "right_pixels",
            "bottom_pixels",
            "bearing_radians",
        ])?;
        for (image, row) in self.rows() {
            writer.serialize((&image.file, row))?;
        }
        writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
    }

    pub(super) fn text(&self) -> String {
        let mut table = Table::new([
            "image",
            "class",
            "confidence",
            "left",
            "top",
            "right",
            "bottom",
            "bearing (degrees)",
        ]);
        for (image, row) in self.rows() {
            let pixels = |edge: f64| format!("{edge:.1}");
            table.push([
                image.file.clone(),
                row.name.clone().unwrap_or_else(|| row.class.to_string()),
                format!("{:.3}", row.confidence),
                pixels(row.left_pixels),
                pixels(row.top_pixels),
                pixels(row.right_pixels),
                pixels(row.bottom_pixels),
                row.bearing_radians
                    .map_or_else(|| "-".to_owned(), |bearing| format!("{:.2}", bearing.to_degrees())),
            ]);
        }
        let reported: Vec<String> = self.images.iter().map(|image| self.reported(image)).collect();
        format!("{}\n{}", table.draw(2), reported.concat())
    }

    /// A line for each image.
    fn reported(&self, image: &Image) -> String {
        let Image { file, width_pixels, height_pixels, seconds, refused_anchors, boxes } = image;
        let reduced = match self.factor {
            1 => String::new(),
            factor => format!(", taken down to {} x {}", width_pixels / factor, height_pixels / factor),
        };
        let refused = match refused_anchors {
            0 => String::new(),
            count => format!("; {} ignored because of invalid output", counted(*count, "anchor")),
        };
        let boxes = match boxes.len() {
            1 => "1 box".to_owned(),
            count => format!("{count} boxes"),
        };
        let input = format!("{} x {}", self.input_columns, self.input_rows);
        let size = format!("{width_pixels} x {height_pixels} pixels{reduced}, shown as {input}");
        format!("{file}: {boxes} in {:.0} ms ({size}){refused}\n", seconds * 1000.0)
    }

    fn rows(&self) -> impl Iterator<Item = (&Image, &Row)> {
        self.images.iter().flat_map(|image| image.boxes.iter().map(move |row| (image, row)))
    }
}

fn bearing_radians(camera: &Camera, detection: &Detection) -> f64 {
    camera.bearing_radians(f64::midpoint(detection.bounds.left, detection.bounds.right))
}
