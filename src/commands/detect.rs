//! `dragnet detect`: tries a detector on images.

#[cfg(feature = "detector")]
mod camera;
#[cfg(feature = "detector")]
mod drawing;
#[cfg(feature = "detector")]
mod photo;
#[cfg(feature = "detector")]
mod report;
#[cfg(feature = "detector")]
mod session;

use std::path::PathBuf;
use std::str::FromStr;

use super::Failure;

/// Run a detector on images.
///
/// Shows images to a YOLO network, a TorchScript module as `yolo export format=torchscript` makes one, in the way in which
/// a robot does, and prints what it finds: class, confidence, edges in pixels of the image and, for a known camera, where
/// the middle of the box is seen. The field guide says which modules are understood. A module is a program: run only one
/// whose maker you know.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet detect --module best.torchscript yard.jpg --save found.png
  dragnet detect --module best.torchscript images/*.png --classes person,0 --camera wide.toml --csv boxes.csv")]
pub(crate) struct Arguments {
    /// Images (JPEG, PNG, PPM)
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    /// The network (TorchScript)
    #[arg(long, value_name = "FILE")]
    module: PathBuf,
    /// Count these classes only, by name or number from 0 [default: all]
    #[arg(long, value_name = "CLASS,..", value_delimiter = ',')]
    classes: Vec<String>,
    /// Count what is more probable than this, 0 to 1
    #[arg(long, value_name = "P", default_value_t = 0.25, allow_negative_numbers = true)]
    confidence: f32,
    /// Boxes whose common area is more than this part of all that they cover are one object, 0 to 1
    #[arg(long, value_name = "PART", default_value_t = 0.7, allow_negative_numbers = true)]
    iou: f32,
    /// Whatever their classes; otherwise only those of one class
    #[arg(long)]
    class_agnostic: bool,
    /// Before an image is fitted to the network: `half` takes it down to half as many columns and rows, as the paper does
    /// with its 5320 x 3032 pixels; `full` is for images that are hardly larger than what the network takes
    #[arg(long, value_enum, default_value_t = Resolution::Half)]
    resolution: Resolution,
    /// What the network takes: columns and rows, such as 640x384, or N for a square [default: as the module's file says]
    #[arg(long, value_name = "N | CxR")]
    input: Option<Input>,
    /// A camera (TOML), for bearings
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Write the image with its boxes, each class in a color of its own (PNG); for one image, and the file must not exist
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Write a row a box (CSV); the file must not exist
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    json: bool,
    /// Threads of libtorch on the CPU; with another number, the last bits of confidences and edges may differ
    #[arg(long, value_name = "T", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: u16,
    /// Use the CPU even if libtorch finds a GPU
    #[arg(long)]
    cpu: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Resolution {
    Half,
    Full,
}

/// Size of what a network takes, pixels.
#[derive(Clone, Copy)]
#[cfg_attr(not(feature = "detector"), expect(dead_code, reason = "nothing is detected"))]
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

#[cfg(feature = "detector")]
pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    session::run(arguments)
}

#[cfg(not(feature = "detector"))]
pub(super) fn execute(_: &Arguments) -> Result<(), Failure> {
    Err(Failure::Input(super::eyes::ABSENT.to_owned()))
}
