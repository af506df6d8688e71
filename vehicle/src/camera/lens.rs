//! A measured lens: from pixels to directions, with its distortion removed.
//!
//! The models are those of OpenCV's `calib3d` ("Camera Calibration and 3D Reconstruction", and "Fisheye camera model"), which
//! ROS uses: they give the distorted pixel of a direction. Their inverse has no closed form: it is found by Newton's
//! method, where OpenCV iterates a fixed point, which does not converge for strong distortion.

use nalgebra::{Matrix2, UnitVector3, Vector2, Vector3};

/// Distance from the pixel that is asked for at which an iteration ends, focal lengths: a millionth of a pixel.
const TOLERANCE: f64 = 1e-9;
/// The most steps of an iteration.
const MAX_STEPS: usize = 50;

/// A lens. Directions are in the optical frame: x to the right, y down, z out of the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Columns of the image, at least 1.
    pub width_pixels: u32,
    /// Rows of the image, at least 1.
    pub height_pixels: u32,
    /// Focal length in columns and in rows, pixels, above 0.
    pub focal_pixels: [f64; 2],
    /// Column and row of the optical axis, pixels from the center of the upper left pixel.
    pub center_pixels: [f64; 2],
    /// The distortion.
    pub distortion: Distortion,
}

/// How a lens distorts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distortion {
    /// `x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)`, and so for y,
    /// with `x` and `y` of the direction at `z = 1`. Zeros: a pinhole.
    Radial {
        /// `k1` to `k6`.
        radial: [f64; 6],
        /// `p1` and `p2`.
        tangential: [f64; 2],
    },
    /// Fisheye: at the angle `a` from the axis the radius is `a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8)`.
    Equidistant([f64; 4]),
}

impl Distortion {
    /// That of a pinhole.
    pub const NONE: Self = Self::Radial { radial: [0.0; 6], tangential: [0.0; 2] };
}

impl Lens {
    /// A pinhole with this angle between the left and the right edge, radians, above 0 and below pi.
    #[must_use]
    pub fn pinhole(width_pixels: u32, height_pixels: u32, field_of_view_radians: f64) -> Self {
        let [columns, rows] = [width_pixels, height_pixels].map(|pixels| f64::from(pixels) / 2.0);
        Self {
            width_pixels,
            height_pixels,
            focal_pixels: [columns / (field_of_view_radians / 2.0).tan(); 2],
            center_pixels: [columns - 0.5, rows - 0.5],
            distortion: Distortion::NONE,
        }
    }

    /// The direction of a pixel, which counts from the left and the upper edge of the image, as those of
    /// [`super::DetectionBox`]. `None` if the model has none: it ends before the image does.
    #[must_use]
    pub fn direction(&self, column: f64, row: f64) -> Option<UnitVector3<f64>> {
        // A pixel's center is half a pixel from its edges.
        let place = [column - 0.5, row - 0.5];
        let distorted = [0, 1].map(|axis| (place[axis] - self.center_pixels[axis]) / self.focal_pixels[axis]);
        let distorted = Vector2::from(distorted);
        let direction = match &self.distortion {
            Distortion::Radial { radial, tangential } => {
                undistorted(radial, tangential, distorted)?.push(1.0)
            }
            Distortion::Equidistant(coefficients) => {
                let radius = distorted.norm();
                let (sine, cosine) = angle_radians(coefficients, radius)?.sin_cos();
                let aside = if radius > 0.0 { distorted * (sine / radius) } else { Vector2::zeros() };
                Vector3::new(aside.x, aside.y, cosine)
            }
        };
        UnitVector3::try_new(direction, f64::MIN_POSITIVE)
    }
}

/// The point at `z = 1` whose image is this one.
fn undistorted(radial: &[f64; 6], tangential: &[f64; 2], image: Vector2<f64>) -> Option<Vector2<f64>> {
    let mut point = image;
    for _ in 0..MAX_STEPS {
        let (found, jacobian) = distorted(radial, tangential, point);
        let miss = found - image;
        if miss.norm() < TOLERANCE {
            // Beyond that the model has folded the image over: it grows inward, or is mirrored.
            return (jacobian.determinant() > 0.0 && jacobian.trace() > 0.0).then_some(point);
        }
        let mut step = jacobian.try_inverse()? * miss;
        // Far steps overshoot where the model bends.
        while (distorted(radial, tangential, point - step).0 - image).norm() >= miss.norm() {
            step /= 2.0;
            let length = step.norm();
            if length.is_nan() || length < TOLERANCE / 10.0 {
                return None;
            }
        }
        point -= step;
    }
    None
}

/// The image of a point at `z = 1`, and the derivative by the point.
fn distorted(
    &[k1, k2, k3, k4, k5, k6]: &[f64; 6],
    &[p1, p2]: &[f64; 2],
    point: Vector2<f64>,
) -> (Vector2<f64>, Matrix2<f64>) {
    let (x, y) = (point.x, point.y);
    let square = x * x + y * y;
    let above = 1.0 + square * (k1 + square * (k2 + square * k3));
    let below = 1.0 + square * (k4 + square * (k5 + square * k6));
    let factor = above / below;
    let [above_slope, below_slope] = [[k1, k2, k3], [k4, k5, k6]]
        .map(|[one, two, three]| one + square * (2.0 * two + square * 3.0 * three));
    // By the squared radius.
    let slope = (above_slope - factor * below_slope) / below;
    let image = Vector2::new(
        x * factor + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * factor + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    );
    let cross = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    let jacobian = Matrix2::new(
        factor + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x,
        cross,
        cross,
        factor + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x,
    );
    (image, jacobian)
}

/// The angle from the axis at which a fisheye's image has this radius, focal lengths.
fn angle_radians(&[k1, k2, k3, k4]: &[f64; 4], radius: f64) -> Option<f64> {
    let mut angle = radius;
    for _ in 0..MAX_STEPS {
        let square = angle * angle;
        let found = angle * (1.0 + square * (k1 + square * (k2 + square * (k3 + square * k4))));
        let slope = 1.0 + square * (3.0 * k1 + square * (5.0 * k2 + square * (7.0 * k3 + square * 9.0 * k4)));
        let miss = found - radius;
        if miss.abs() < TOLERANCE {
            return (slope > 0.0 && angle <= std::f64::consts::PI).then_some(angle);
        }
        if slope.is_nan() || slope <= 0.0 {
            return None;
        }
        angle = (angle - miss / slope).clamp(0.0, std::f64::consts::PI);
    }
    None
}

#[cfg(test)]
mod tests;
