//! A network loaded from its file, and its settings checked against it.

use std::collections::BTreeSet;
use std::path::PathBuf;

use dragnet_detector::network::{Format, Network, NetworkError};
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::settings::{Classes, Processor, Resolution, Settings, Suppression};
use dragnet_detector::{Detection, Found};
use dragnet_ros2::input::{DetectedBox, Hypothesis, Image};
use dragnet_runtime::vehicle::detector::{self, Detector};
use dragnet_vehicle::camera::DetectionBox;

/// Four times the size of the largest networks of the family.
const MOST_BYTES: u64 = 1 << 30;
/// Number of class names that an error message lists.
const MOST_NAMES: u32 = 20;

/// A network and its detection settings.
pub(in crate::commands) struct YoloDetector {
    pub(in crate::commands) network: Network,
    pub(in crate::commands) settings: Settings,
}

/// Why a detector could not be made.
pub(in crate::commands) enum Problem {
    /// The file cannot be read.
    File(PathBuf, std::io::Error),
    /// The file is not a detector.
    Module(PathBuf, NetworkError),
    /// The network has no such class.
    Class { asked: String, allowed: String },
    /// More threads than any processor has.
    Threads(u16),
}

impl Problem {
    /// The message, with keys or options named with this prefix.
    pub(in crate::commands) fn with_keys(&self, prefix: &str) -> String {
        match self {
            Self::File(path, error) => format!("{}: cannot read it: {error}", path.display()),
            Self::Module(path, error) => {
                let hint = match error {
                    NetworkError::NoInput => format!(" by {prefix}input"),
                    _ => String::new(),
                };
                format!("{}: {error}{hint}", path.display())
            }
            Self::Class { asked, allowed } => format!("{prefix}classes {asked}: allowed are {allowed}"),
            Self::Threads(threads) => format!("{prefix}threads {threads}: allowed are 1 to 1024"),
        }
    }
}

impl YoloDetector {
    pub(in crate::commands) fn open(asked: &detector::Settings) -> Result<Self, Problem> {
        if !(1..=1024).contains(&asked.threads) {
            return Err(Problem::Threads(asked.threads));
        }
        let processor = Processor { threads: asked.threads, may_use_gpu: !asked.cpu };
        let path = || asked.module.clone();
        let bytes = dragnet_files::read_at_most(&asked.module, MOST_BYTES)
            .map_err(|error| Problem::File(path(), error))?;
        let input = asked.input.map(|[width_pixels, height_pixels]| Size { width_pixels, height_pixels });
        let network = Network::load(Format::of(&asked.module), &bytes, input, processor)
            .map_err(|error| Problem::Module(path(), error))?;
        let classes: BTreeSet<u32> =
            asked.classes.iter().map(|class| self::class(class, &network)).collect::<Result<_, _>>()?;
        let settings = Settings {
            confidence: asked.confidence,
            iou: asked.iou,
            classes: if classes.is_empty() { Classes::All } else { Classes::Only(classes) },
            suppression: if asked.class_agnostic { Suppression::Agnostic } else { Suppression::ByClass },
            resolution: match asked.resolution {
                detector::Resolution::Half => Resolution::Half,
                detector::Resolution::Full => Resolution::Full,
            },
        };
        let eyes = Self { network, settings };
        // Unusable networks are detected before the first image arrives.
        eyes.find(2, 2, &[114; 12]).map_err(|error| Problem::Module(path(), error))?;
        Ok(eyes)
    }

    fn named(&self, detection: &Detection) -> DetectedBox {
        let DetectionBox { left, top, right, bottom } = detection.bounds;
        let class = detection.class;
        let class = self.network.name(class).map_or_else(|| class.to_string(), str::to_owned);
        let hypothesis = Some(Hypothesis { class, score: detection.confidence.into() });
        DetectedBox { left, top, right, bottom, hypothesis }
    }

    /// The detections of an image: red, green and blue of each pixel, row by row.
    pub(in crate::commands) fn find(
        &self,
        width_pixels: u32,
        height_pixels: u32,
        rgb: &[u8],
    ) -> Result<Found, NetworkError> {
        let picture = Picture::new(Size { width_pixels, height_pixels }, PixelFormat::Rgb8, rgb);
        self.network.detect(&picture.map_err(|error| NetworkError::Prepare(error.into()))?, &self.settings)
    }
}

impl Detector for YoloDetector {
    fn detect(&mut self, image: &Image) -> Result<Vec<DetectedBox>, String> {
        let found = self.find(image.width_pixels, image.height_pixels, &image.rgb);
        let detections = found.map_err(|error| error.to_string())?.detections;
        Ok(detections.iter().map(|detection| self.named(detection)).collect())
    }
}

/// The class with this name in the network's file or, if there is none, with this number.
fn class(text: &str, network: &Network) -> Result<u32, Problem> {
    let number = || text.parse().ok().filter(|class| *class < network.classes());
    network.class_named(text).or_else(number).ok_or_else(|| {
        let names: Vec<&str> =
            (0..network.classes().min(MOST_NAMES)).filter_map(|class| network.name(class)).collect();
        let and = if names.is_empty() { "" } else { ", or " };
        let more = if names.len() < network.classes() as usize && !names.is_empty() { ", .." } else { "" };
        let allowed = format!("0 to {}{and}{}{more}", network.classes() - 1, names.join(", "));
        Problem::Class { asked: text.to_owned(), allowed }
    })
}
