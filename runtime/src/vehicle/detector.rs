//! The interface of a detector for the images of a vehicle's cameras.
//!
//! Its implementation, which runs a network, is not part of this crate: the caller that starts a robot passes it in.

use std::collections::VecDeque;
use std::future::pending;
use std::path::PathBuf;
use std::sync::Arc;

use dragnet_ros2::input::{DetectedBox, Image};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tokio::task::{JoinHandle, spawn_blocking};

use super::pictures::{BoxCrop, crops};

/// The table `[detector]`: a YOLO network, as the crate `dragnet-detector` understands it.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The network, relative to the settings: an ONNX file, whose name ends in `.onnx`, or a TorchScript module.
    #[schemars(extend("examples" = ["best.onnx", "best.torchscript"]))]
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
    /// Columns and rows of the network's input, pixels; by default as the network says.
    #[serde(default)]
    pub input: Option<[u32; 2]>,
    /// Threads of the network on the CPU, 1 to 1024.
    #[serde(default = "threads")]
    pub threads: u16,
    /// Whether to use the CPU even if libtorch, which runs TorchScript modules, finds a GPU.
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

/// A detector of objects in images.
pub trait Detector: Send {
    /// The boxes of objects in an image, pixels of the image, with their classes.
    ///
    /// # Errors
    /// Why detection failed on this image. The next one may succeed.
    fn detect(&mut self, image: &Image) -> Result<Vec<DetectedBox>, String>;
}

/// Constructs a detector from settings, whose paths are relative to the working directory, or returns the reason why it
/// cannot.
pub type Make<'a> = &'a dyn Fn(&Settings) -> Result<Box<dyn Detector>, String>;

/// An image for the detector.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DetectionRequest {
    pub(crate) camera: Arc<str>,
    /// When it was taken, mission time.
    pub(crate) time_ns: u64,
    pub(crate) image: Image,
}

/// The detections in an image.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) camera: Arc<str>,
    /// When the image was taken, mission time.
    pub(crate) time_ns: u64,
    pub(crate) found: Result<Vec<DetectedBox>, String>,
    /// What is in the largest of them.
    pub(crate) crops: Vec<BoxCrop>,
}

impl DetectionRequest {
    pub(crate) fn through(&self, detector: &mut dyn Detector) -> Seen {
        let Self { camera, time_ns, image } = self;
        let found = detector.detect(image);
        let crops = found.as_ref().map(|boxes| crops(image, boxes, None)).unwrap_or_default();
        Seen { camera: Arc::clone(camera), time_ns: *time_ns, found, crops }
    }
}

/// A detector on a separate thread, and the images that wait for it: only the newest of each camera, since a detector
/// may be slower than a camera.
pub(super) struct DetectorWorker {
    /// `None` while it works.
    detector: Option<Box<dyn Detector>>,
    looking: Option<JoinHandle<(Box<dyn Detector>, Seen)>>,
    waiting: VecDeque<DetectionRequest>,
}

impl DetectorWorker {
    pub(super) const fn new(detector: Option<Box<dyn Detector>>) -> Self {
        Self { detector, looking: None, waiting: VecDeque::new() }
    }

    /// Queues an image. Without a detector it is ignored.
    pub(super) fn show(&mut self, request: DetectionRequest) {
        self.waiting.retain(|other| other.camera != request.camera);
        self.waiting.push_back(request);
        self.request();
    }

    /// The next detections. Cancel safe.
    pub(super) async fn see(&mut self) -> Seen {
        let Some(looking) = &mut self.looking else { return pending().await };
        let ended = looking.await;
        self.looking = None;
        match ended {
            Ok((detector, seen)) => {
                self.detector = Some(detector);
                self.request();
                seen
            }
            Err(error) => {
                let found = Err(format!("the detector is no more: {error}"));
                Seen { camera: "all".into(), time_ns: 0, found, crops: Vec::new() }
            }
        }
    }

    fn request(&mut self) {
        if self.waiting.is_empty() {
            return;
        }
        let Some(mut detector) = self.detector.take() else { return };
        let Some(request) = self.waiting.pop_front() else { return };
        self.looking = Some(spawn_blocking(move || {
            let seen = request.through(&mut *detector);
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

    fn request(camera: &str, number: i64) -> DetectionRequest {
        DetectionRequest { camera: camera.into(), time_ns: number.unsigned_abs(), image: image(number) }
    }

    /// A detector that waits for permission.
    struct Slow(mpsc::Receiver<()>);

    impl Detector for Slow {
        fn detect(&mut self, image: &Image) -> Result<Vec<DetectedBox>, String> {
            self.0.recv().map_err(|error| error.to_string())?;
            assert!(image.stamp_unix_ns >= 0, "not a real image");
            Ok(Vec::new())
        }
    }

    #[tokio::test]
    async fn a_slow_detector_processes_the_newest_image_of_each_camera_in_turn() {
        let (go, may) = mpsc::channel();
        let mut eyes = DetectorWorker::new(Some(Box::new(Slow(may))));
        for shown in [
            request("left", 1),
            request("right", 2),
            request("left", 3),
            request("right", 4),
            request("left", 5),
        ] {
            eyes.show(shown);
        }
        let mut seen = Vec::new();
        for _ in 0..3 {
            go.send(()).unwrap();
            let Seen { camera, time_ns, found, .. } = eyes.see().await;
            assert_eq!(found, Ok(Vec::new()));
            seen.push((camera.to_string(), time_ns));
        }
        let expected = [("left", 1), ("right", 4), ("left", 5)];
        assert_eq!(seen, expected.map(|(camera, time_ns)| (camera.to_owned(), time_ns)));
        assert!(eyes.looking.is_none() && eyes.waiting.is_empty());
    }

    #[tokio::test]
    async fn a_failed_detector_is_reported_and_the_robot_goes_on() {
        let (go, may) = mpsc::channel();
        let mut eyes = DetectorWorker::new(Some(Box::new(Slow(may))));
        go.send(()).unwrap();
        eyes.show(request("left", -1));
        let Seen { found, .. } = eyes.see().await;
        assert!(found.is_err_and(|reason| reason.contains("no more")));
        eyes.show(request("left", 1));
        assert!(eyes.looking.is_none());
    }
}
