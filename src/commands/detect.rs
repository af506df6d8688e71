//! `dragnet detect`: runs a detector on images.

#[cfg(feature = "eyes")]
mod camera;
#[cfg(feature = "eyes")]
mod drawing;
#[cfg(feature = "eyes")]
mod photo;
#[cfg(feature = "eyes")]
mod report;
#[cfg(feature = "eyes")]
mod session;

use std::path::PathBuf;
use std::str::FromStr;

use super::Failure;

/// Run a detector on images.
///
/// Runs a YOLO network (an ONNX file or a TorchScript module, from `yolo export`) on images exactly as a robot does, and
/// prints its detections: class, confidence, box edges in pixels and, for a known camera, the bearing of the box's
/// center. The field guide lists the supported networks. A TorchScript module is a program: run only modules from trusted
/// sources.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet detect --module best.onnx yard.jpg --save found.png
  dragnet detect --module best.torchscript images/*.png --classes person,0 --camera wide.toml --csv boxes.csv")]
pub(crate) struct Arguments {
    /// Image files (JPEG, PNG, PPM)
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// The network: an ONNX file, whose name ends in `.onnx`, or a TorchScript module
    #[arg(long, value_name = "FILE")]
    module: PathBuf,
    /// Detect only these classes, separated by commas, each a name or a number from 0 [default: all classes]
    #[arg(long, value_name = "CLASS,..", value_delimiter = ',')]
    classes: Vec<String>,
    /// Minimum confidence of a detection, 0 to 1
    #[arg(long, value_name = "P", default_value_t = 0.25, allow_negative_numbers = true)]
    confidence: f32,
    /// Intersection over union above which two boxes count as one object, 0 to 1
    #[arg(long, value_name = "PART", default_value_t = 0.7, allow_negative_numbers = true)]
    iou: f32,
    /// Count overlapping boxes of different classes as one object too
    #[arg(long)]
    class_agnostic: bool,
    /// Resolution at which an image is used: `half` first halves its columns and rows, as the paper does with images of
    /// 5320 x 3032 pixels; `full` is for images that are hardly larger than the network's input
    #[arg(long, value_enum, default_value_t = Resolution::Half)]
    resolution: Resolution,
    /// Input size of the network, pixels: columns and rows, such as 640x384, or N for a square [default: the size in
    /// the network's file]
    #[arg(long, value_name = "N | CxR")]
    input: Option<Input>,
    /// File with a camera's table (TOML), to compute bearings
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Write the image with its boxes, each class in its own color, to this file (PNG), which must not exist; for one
    /// image only
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Write a table with a row for each box to this file (CSV), which must not exist
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
    /// Number of the network's threads on the CPU, 1 to 1024; the last bits of confidences and edges depend on it
    #[arg(long, value_name = "T", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: u16,
    /// Use the CPU even if libtorch finds a GPU, as it may for a TorchScript module
    #[arg(long)]
    cpu: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Resolution {
    Half,
    Full,
}

/// The input size of a network, pixels.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "eyes"), expect(dead_code, reason = "nothing is detected"))]
struct Input {
    columns: u32,
    rows: u32,
}

impl FromStr for Input {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (columns, rows) = text.split_once('x').unwrap_or((text, text));
        match (columns.parse(), rows.parse()) {
            (Ok(columns), Ok(rows)) => Ok(Self { columns, rows }),
            _ => {
                Err("allowed is a number of pixels, or two with an x between them, such as 640x384"
                    .to_owned())
            }
        }
    }
}

#[cfg(feature = "eyes")]
pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    session::run(arguments)
}

#[cfg(not(feature = "eyes"))]
pub(super) fn execute(_: &Arguments) -> Result<(), Failure> {
    Err(Failure::Input(super::eyes::ABSENT.to_owned()))
}
