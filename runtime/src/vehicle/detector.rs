//! A detector of this program's own, which looks at the images of a vehicle's cameras.
//!
//! What it is made of, libtorch above all, is none of this crate's business: whoever starts a robot hands it in.

use std::collections::VecDeque;
use std::future::pending;
use std::path::PathBuf;
use std::sync::Arc;

use dragnet_ros2::input::Image;
use dragnet_vehicle::camera::DetectionBox;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tokio::task::{JoinHandle, spawn_blocking};

/// The table `[detector]`: a YOLO network, as the crate `dragnet-detector` understands it.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The network, a TorchScript module, relative to the settings.
    #[schemars(extend("examples" = ["best.torchscript"]))]
    pub module: PathBuf,
    /// Classes that count, by name or by number from 0; all if empty.
    #[serde(default)]
    pub classes: Vec<String>,
    /// Smallest probability of a detection, 0 to 1.
    #[serde(default = "confidence")]
    pub confidence: f32,
    /// Intersection over union above which two boxes are one object, 0 to 1.
    #[serde(default = "iou")]
    pub iou: f32,
    /// Whether boxes of different classes are one object, too.
    #[serde(default)]
    pub class_agnostic: bool,
    /// Resolution at which images are used.
    #[serde(default)]
    pub resolution: Resolution,
    /// Columns and rows of the network's input, pixels; by default as the module says.
    #[serde(default)]
    pub input: Option<[u32; 2]>,
    /// Threads of libtorch on the CPU, 1 to 1024.
    #[serde(default = "threads")]
    pub threads: u16,
    /// Whether to use the CPU even if libtorch finds a GPU.
    #[serde(default)]
    pub cpu: bool,
}

/// Resolution at which images are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resolution {
    /// Half as many columns and rows, as in the paper.
    #[default]
    Half,
    /// Full resolution, for images hardly larger than the network's input.
    Full,
}

const fn confidence() -> f32 {
    0.25
}

const fn iou() -> f32 {
    0.7
}

const fn threads() -> u16 {
    1
}

/// Whoever looks at images.
pub trait Detector: Send {
    /// Where in an image objects are, pixels of the image.
    ///
    /// # Errors
    /// Why nothing can be said of this image. The next may be another matter.
    fn detect(&mut self, image: &Image) -> Result<Vec<DetectionBox>, String>;
}

/// Makes the detector of some settings, whose paths are as seen from the working directory, or says why there is none.
pub type Make<'a> = &'a dyn Fn(&Settings) -> Result<Box<dyn Detector>, String>;

/// An image to look at.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Look {
    pub(crate) camera: Arc<str>,
    /// When it was taken, mission time.
    pub(crate) time_ns: u64,
    pub(crate) image: Image,
}

/// What was seen in an image.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) camera: Arc<str>,
    /// When the image was taken, mission time.
    pub(crate) time_ns: u64,
    pub(crate) found: Result<Vec<DetectionBox>, String>,
}

impl Look {
    pub(crate) fn through(&self, detector: &mut dyn Detector) -> Seen {
        let Self { camera, time_ns, image } = self;
        Seen { camera: Arc::clone(camera), time_ns: *time_ns, found: detector.detect(image) }
    }
}

/// A detector on a thread of its own, and the images that wait for it: of each camera the newest, since one that looks
/// at every image falls behind a camera that is faster.
pub(super) struct DetectorWorker {
    /// Not there while it looks.
    detector: Option<Box<dyn Detector>>,
    looking: Option<JoinHandle<(Box<dyn Detector>, Seen)>>,
    waiting: VecDeque<Look>,
}

impl DetectorWorker {
    pub(super) const fn new(detector: Option<Box<dyn Detector>>) -> Self {
        Self { detector, looking: None, waiting: VecDeque::new() }
    }

    /// Has it look at an image in its turn. Without a detector nothing comes of it.
    pub(super) fn show(&mut self, look: Look) {
        self.waiting.retain(|other| other.camera != look.camera);
        self.waiting.push_back(look);
        self.look();
    }

    /// What it sees next. Nothing is lost if this is given up while it waits.
    pub(super) async fn see(&mut self) -> Seen {
        let Some(looking) = &mut self.looking else { return pending().await };
        let ended = looking.await;
        self.looking = None;
        match ended {
            Ok((detector, seen)) => {
                self.detector = Some(detector);
                self.look();
                seen
            }
            Err(error) => {
                let found = Err(format!("the detector is no more: {error}"));
                Seen { camera: "all".into(), time_ns: 0, found }
            }
        }
    }

    fn look(&mut self) {
        if self.waiting.is_empty() {
            return;
        }
        let Some(mut detector) = self.detector.take() else { return };
        let Some(look) = self.waiting.pop_front() else { return };
        self.looking = Some(spawn_blocking(move || {
            let seen = look.through(&mut *detector);
            (detector, seen)
        }));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    fn image(number: i64) -> Image {
        Image {
            stamp_unix_ns: number,
            frame: String::new(),
            width_pixels: 1,
            height_pixels: 1,
            rgb: vec![0; 3],
        }
    }

    fn look(camera: &str, number: i64) -> Look {
        Look { camera: camera.into(), time_ns: number.unsigned_abs(), image: image(number) }
    }

    /// Looks only once it may.
    struct Slow(mpsc::Receiver<()>);

    impl Detector for Slow {
        fn detect(&mut self, image: &Image) -> Result<Vec<DetectionBox>, String> {
            self.0.recv().map_err(|error| error.to_string())?;
            assert!(image.stamp_unix_ns >= 0, "not a real image");
            Ok(Vec::new())
        }
    }

    #[tokio::test]
    async fn a_slow_detector_looks_at_the_newest_image_of_each_camera_in_turn() {
        let (go, may) = mpsc::channel();
        let mut eyes = DetectorWorker::new(Some(Box::new(Slow(may))));
        for shown in [look("left", 1), look("right", 2), look("left", 3), look("right", 4), look("left", 5)] {
            eyes.show(shown);
        }
        let mut seen = Vec::new();
        for _ in 0..3 {
            go.send(()).unwrap();
            let Seen { camera, time_ns, found } = eyes.see().await;
            assert_eq!(found, Ok(Vec::new()));
            seen.push((camera.to_string(), time_ns));
        }
        let expected = [("left", 1), ("right", 4), ("left", 5)];
        assert_eq!(seen, expected.map(|(camera, time_ns)| (camera.to_owned(), time_ns)));
        assert!(eyes.looking.is_none() && eyes.waiting.is_empty());
    }

    #[tokio::test]
    async fn a_detector_that_breaks_down_is_told_and_the_robot_goes_on_without() {
        let (go, may) = mpsc::channel();
        let mut eyes = DetectorWorker::new(Some(Box::new(Slow(may))));
        go.send(()).unwrap();
        eyes.show(look("left", -1));
        let Seen { found, .. } = eyes.see().await;
        assert!(found.is_err_and(|reason| reason.contains("no more")));
        eyes.show(look("left", 1));
        assert!(eyes.looking.is_none());
    }
}
