//! A camera's calibration.

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::robot;

/// The most columns or rows of an image.
const MAX_PIXELS: u32 = 1 << 20;

/// The calibration of a camera: from directions in its optical frame (x to the right, y down, z out of the camera) to
/// pixels of its raw image. Coordinates count from the center of the upper left pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraInfo {
    /// When, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// The optical frame; at most 256 bytes.
    pub frame: String,
    /// Columns of its images, at least 1.
    pub width_pixels: u32,
    /// Rows of its images, at least 1.
    pub height_pixels: u32,
    /// Focal length in columns and in rows, pixels, above 0.
    pub focal_pixels: [f64; 2],
    /// Column and row of the optical axis, pixels.
    pub center_pixels: [f64; 2],
    /// The distortion of its lens.
    pub distortion: Distortion,
}

/// The distortion of a lens, by the models of ROS (REP 104 and `sensor_msgs/distortion_models.hpp`) and OpenCV.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// A pinhole.
    None,
    /// `plumb_bob`: `k1, k2, p1, p2, k3`.
    PlumbBob([f64; 5]),
    /// `rational_polynomial`: `k1, k2, p1, p2, k3, k4, k5, k6`.
    RationalPolynomial([f64; 8]),
    /// `equidistant`, of fisheye lenses: `k1, k2, k3, k4`.
    Equidistant([f64; 4]),
}

impl CameraInfo {
    pub(super) fn check(info: &robot::CameraInfo) -> Result<Self, InputError> {
        let check = Check { message: robot::CameraInfo::NAME };
        let (stamp_unix_ns, frame) = check.header(&info.header)?;
        let [[fx, skew, cx], [_, fy, cy], _] = info.k;
        if info.k == [[0.0; 3]; 3] {
            return check.refused("k", "all 0: the camera is not calibrated", "a calibration");
        }
        if skew != 0.0 {
            return check.refused("k[1]", skew, "0: rows and columns at right angles");
        }
        let roi = info.roi;
        let [columns, rows] = [
            Axis {
                name: "width",
                full: info.width,
                offset: roi.x_offset,
                part: roi.width,
                binning: info.binning_x,
            },
            Axis {
                name: "height",
                full: info.height,
                offset: roi.y_offset,
                part: roi.height,
                binning: info.binning_y,
            },
        ];
        Ok(Self {
            stamp_unix_ns,
            frame,
            width_pixels: columns.pixels(check)?,
            height_pixels: rows.pixels(check)?,
            focal_pixels: [columns.focal(check, "k[0]", fx)?, rows.focal(check, "k[4]", fy)?],
            center_pixels: [columns.center(check, "k[2]", cx)?, rows.center(check, "k[5]", cy)?],
            distortion: check.distortion(&info.distortion_model, &info.d)?,
        })
    }
}

/// Columns or rows: a part of the full image, of which some are combined to one.
#[derive(Clone, Copy)]
struct Axis {
    name: &'static str,
    full: u32,
    offset: u32,
    /// 0 for all.
    part: u32,
    /// 0 for 1.
    binning: u32,
}

impl Axis {
    fn pixels(self, check: Check) -> Result<u32, InputError> {
        let size = if self.part == 0 { self.full } else { self.part };
        match size / self.binning.max(1) {
            0 => check.refused(self.name, size, "at least 1 pixel"),
            pixels if pixels > MAX_PIXELS => check.refused(self.name, size, format!("at most {MAX_PIXELS}")),
            pixels => Ok(pixels),
        }
    }

    fn focal(self, check: Check, field: &str, pixels: f64) -> Result<f64, InputError> {
        // Written so that NaN fails as well.
        if pixels > 0.0 && pixels.is_finite() {
            Ok(pixels / f64::from(self.binning.max(1)))
        } else {
            check.refused(field, pixels, "above 0 pixels")
        }
    }

    fn center(self, check: Check, field: &str, pixels: f64) -> Result<f64, InputError> {
        Ok((check.finite(field, pixels)? - f64::from(self.offset)) / f64::from(self.binning.max(1)))
    }
}

impl Check {
    fn distortion(self, model: &str, coefficients: &[f64]) -> Result<Distortion, InputError> {
        for (index, &coefficient) in coefficients.iter().enumerate() {
            self.finite(&format!("d[{index}]"), coefficient)?;
        }
        let is_straight = coefficients.iter().all(|&coefficient| coefficient == 0.0);
        Ok(match model {
            "" | "none" | "plumb_bob" | "rational_polynomial" if is_straight => Distortion::None,
            // OpenCV's calibration without k3.
            "plumb_bob" if let &[k1, k2, p1, p2] = coefficients => {
                Distortion::PlumbBob([k1, k2, p1, p2, 0.0])
            }
            "plumb_bob" => Distortion::PlumbBob(self.coefficients(model, coefficients)?),
            "rational_polynomial" => Distortion::RationalPolynomial(self.coefficients(model, coefficients)?),
            "equidistant" | "fisheye" => Distortion::Equidistant(self.coefficients(model, coefficients)?),
            _ => {
                let allowed = "plumb_bob, rational_polynomial or equidistant";
                return self.refused("distortion_model", format!("{model:?}"), allowed);
            }
        })
    }

    /// The coefficients of a model; more are of its extensions, which do not count if they are 0.
    fn coefficients<const COUNT: usize>(
        self,
        model: &str,
        found: &[f64],
    ) -> Result<[f64; COUNT], InputError> {
        let extended = found.iter().skip(COUNT).any(|&coefficient| coefficient != 0.0);
        match found.first_chunk() {
            Some(coefficients) if !extended => Ok(*coefficients),
            _ => self.refused("d", format!("{found:?}"), format!("the {COUNT} coefficients of {model}")),
        }
    }
}
