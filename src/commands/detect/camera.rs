//! A camera in a file of its own, with the keys of `[[vehicle.cameras]]`.

use std::path::Path;

use dragnet_files::read_text_at_most;
use dragnet_scenario::toml_text;
use dragnet_vehicle::camera::{Camera, CameraError};
use dragnet_vehicle::settings::CameraTable;

use crate::commands::Failure;

const MAX_BYTES: u64 = 1 << 16;

/// Reads the table that `--camera` names.
pub(super) fn read(path: &Path) -> Result<CameraTable, Failure> {
    let failed = |reason: String| Failure::Input(format!("--camera {}: {reason}", path.display()));
    let text =
        read_text_at_most(path, MAX_BYTES).map_err(|error| failed(format!("cannot read it: {error}")))?;
    let table: CameraTable = toml_text::read(&text).map_err(|error| {
        let line = error.line.map_or(String::new(), |line| format!("line {line}: "));
        failed(format!("{line}{error}"))
    })?;
    table.camera().map_err(|error| failed(error.to_string()))?;
    Ok(table)
}

/// The camera at the size of an image, which may differ from that of the table.
pub(super) fn sized(
    table: &CameraTable,
    width_pixels: u32,
    height_pixels: u32,
) -> Result<Camera, CameraError> {
    CameraTable { width_pixels: Some(width_pixels), height_pixels: Some(height_pixels), ..table.clone() }
        .camera()
}
