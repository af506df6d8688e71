//! Cameras, by their tables and by what the vehicle's network says of them.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_lattice::plane::Pose;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::CameraTable;
use super::check::{SettingsError, positive, value};
use crate::camera::{Camera, CameraError, CameraRanges, CameraSettings, Lens, MountedCamera, MountedError};

/// The maximum number of cameras.
const MAX_CAMERAS: usize = 16;

/// What a vehicle's network says of a camera, so that its table must not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// Its calibration.
    Optics,
    /// Its pose on the vehicle.
    Mounting,
    /// Both.
    OpticsAndMounting,
}

/// A camera that the vehicle's network describes, at least in part.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredCamera {
    ranges: CameraRanges,
    column_std_pixels: f64,
    /// By its table; `None` if its calibration is published.
    lens: Option<Lens>,
    /// The pose of its optical frame in the vehicle's frame, by its table; `None` if it is published.
    vehicle_from_camera: Option<Isometry3<f64>>,
}

impl MeasuredCamera {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.ranges.name
    }

    /// Standard deviation of the middle of a box, pixels.
    #[must_use]
    pub const fn column_std_pixels(&self) -> f64 {
        self.column_std_pixels
    }

    /// Its lens, if its table describes it.
    #[must_use]
    pub const fn lens(&self) -> Option<&Lens> {
        self.lens.as_ref()
    }

    /// The pose of its optical frame in the vehicle's frame, if its table describes it.
    #[must_use]
    pub const fn vehicle_from_camera(&self) -> Option<&Isometry3<f64>> {
        self.vehicle_from_camera.as_ref()
    }

    /// The camera with this lens, and this pose of its optical frame in the vehicle's frame.
    ///
    /// # Errors
    /// If they cannot be those of a camera.
    pub fn mounted(&self, lens: Lens, mounting: &Isometry3<f64>) -> Result<MountedCamera, MountedError> {
        MountedCamera::new(self.ranges.clone(), lens, mounting)
    }
}

/// All cameras of a vehicle.
pub(super) struct Cameras {
    pub(super) described: Vec<(Camera, f64)>,
    pub(super) measured: Vec<MeasuredCamera>,
}

pub(super) fn check(
    tables: &[CameraTable],
    measured: &BTreeMap<String, Measured>,
) -> Result<Cameras, SettingsError> {
    if !(1..=MAX_CAMERAS).contains(&tables.len()) {
        return Err(value("cameras", &format!("{} cameras", tables.len()), format!("1 to {MAX_CAMERAS}")));
    }
    let (mut names, mut cameras) = (BTreeSet::new(), Cameras { described: Vec::new(), measured: Vec::new() });
    for table in tables {
        if !names.insert(&table.name) {
            return Err(value(
                "cameras.name",
                &format!("{:?} twice", table.name),
                "a name of its own for each",
            ));
        }
        // Of a camera without a size yet its calibration will say that.
        let most = table.width_pixels.map_or(f64::INFINITY, |columns| f64::from(columns) / 4.0);
        let std_pixels = positive("cameras.column_std_pixels", table.column_std_pixels, most)?;
        match measured.get(&table.name) {
            None => cameras.described.push((table.camera()?, std_pixels)),
            Some(&by) => cameras.measured.push(table.measured(by, std_pixels)?),
        }
    }
    Ok(cameras)
}

impl CameraTable {
    /// The camera of the table.
    ///
    /// # Errors
    /// If a value is invalid or missing: with its name and the allowed values.
    pub fn camera(&self) -> Result<Camera, CameraError> {
        let missing = |key| CameraError::Missing { name: self.name.clone(), key };
        let [x_meters, y_meters, z_meters, yaw_degrees, pitch_degrees] =
            self.mounting().map(|(_, number)| number.unwrap_or(0.0));
        Camera::new(CameraSettings {
            name: self.name.clone(),
            width_pixels: self.width_pixels.ok_or_else(|| missing("width_pixels"))?,
            height_pixels: self.height_pixels.ok_or_else(|| missing("height_pixels"))?,
            field_of_view_radians: self
                .field_of_view_degrees
                .ok_or_else(|| missing("field_of_view_degrees"))?
                .to_radians(),
            mounting: Pose::new(x_meters, y_meters, yaw_degrees.to_radians()),
            z_meters,
            pitch_radians: pitch_degrees.to_radians(),
            min_range_meters: self.min_range_meters,
            max_range_meters: self.max_range_meters,
        })
    }

    /// Whether the table says how the camera is mounted.
    #[must_use]
    pub fn has_mounting(&self) -> bool {
        self.mounting().iter().any(|(_, number)| number.is_some())
    }

    fn mounting(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("x_meters", self.x_meters),
            ("y_meters", self.y_meters),
            ("z_meters", self.z_meters),
            ("yaw_degrees", self.yaw_degrees),
            ("pitch_degrees", self.pitch_degrees),
        ]
    }

    /// The camera of which the network says the rest.
    fn measured(&self, by: Measured, column_std_pixels: f64) -> Result<MeasuredCamera, SettingsError> {
        let named = |key: &'static str| SettingsError::Value {
            key: format!("cameras.{key}"),
            found: format!("set, of the camera {:?}", self.name),
            allowed: "either this key, or what the vehicle's network says".to_owned(),
        };
        let has_optics = matches!(by, Measured::Optics | Measured::OpticsAndMounting);
        let has_mounting = matches!(by, Measured::Mounting | Measured::OpticsAndMounting);
        let optics = [
            ("width_pixels", self.width_pixels.is_some()),
            ("height_pixels", self.height_pixels.is_some()),
            ("field_of_view_degrees", self.field_of_view_degrees.is_some()),
        ];
        if let Some(&(key, _)) = optics.iter().find(|&&(_, is_set)| is_set && has_optics) {
            return Err(named(key));
        }
        if let Some(&(key, _)) = self.mounting().iter().find(|(_, set)| set.is_some() && has_mounting) {
            return Err(named(key));
        }
        // What the network says is replaced by something valid, so that the rest is checked.
        let whole = Self {
            width_pixels: self.width_pixels.or(has_optics.then_some(1)),
            height_pixels: self.height_pixels.or(has_optics.then_some(1)),
            field_of_view_degrees: self.field_of_view_degrees.or(has_optics.then_some(90.0)),
            ..self.clone()
        };
        let camera = whole.camera()?;
        let CameraSettings { width_pixels, height_pixels, field_of_view_radians, mounting, .. } =
            *camera.settings();
        let lens = (!has_optics).then(|| Lens::pinhole(width_pixels, height_pixels, field_of_view_radians));
        let pitch_radians = camera.settings().pitch_radians;
        let vehicle_from_camera =
            (!has_mounting).then(|| optical_pose(&mounting, camera.settings().z_meters, pitch_radians));
        let ranges = CameraRanges {
            name: self.name.clone(),
            min_range_meters: self.min_range_meters,
            max_range_meters: self.max_range_meters,
        };
        Ok(MeasuredCamera { ranges, column_std_pixels, lens, vehicle_from_camera })
    }
}

/// The pose of the optical frame of a camera that is mounted by REP 103: x forward, y left, z up.
fn optical_pose(mounting: &Pose, z_meters: f64, pitch_radians: f64) -> Isometry3<f64> {
    let optical = Matrix3::from_columns(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    let rotation = Rotation3::from_euler_angles(0.0, pitch_radians, mounting.heading_radians)
        * Rotation3::from_matrix_unchecked(optical);
    Isometry3::from_parts(
        Translation3::new(mounting.x_meters, mounting.y_meters, z_meters),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}
