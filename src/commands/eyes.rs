//! A detector from its settings, for `dragnet detect` and for a robot's cameras.

#[cfg(feature = "eyes")]
mod network;

use dragnet_runtime::vehicle::detector::{Detector, Settings};

#[cfg(feature = "eyes")]
pub(super) use network::YoloDetector;

/// The detector of a robot's settings.
#[cfg(feature = "eyes")]
pub(super) fn make(settings: &Settings) -> Result<Box<dyn Detector>, String> {
    match YoloDetector::open(settings) {
        Ok(eyes) => Ok(Box::new(eyes)),
        Err(problem) => Err(problem.with_keys("")),
    }
}

/// There is no detector without a runtime for networks.
#[cfg(not(feature = "eyes"))]
pub(super) fn make(_: &Settings) -> Result<Box<dyn Detector>, String> {
    Err(ABSENT.to_owned())
}

/// The message of a program without a detector.
#[cfg(not(feature = "eyes"))]
pub(super) const ABSENT: &str = "this program was built without a detector: build it from a checkout with `cargo build --release \
                          --features onnx` for ONNX networks, or with `train/libtorch.sh && cargo build --release --features \
                          detector` for TorchScript modules";
