//! The metadata of a module's file: ultralytics' export writes a JSON object into the TorchScript archive.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use serde::Deserialize;
use zip::ZipArchive;

use crate::picture::Size;

/// Its path, below a folder with the module's name.
const ENTRY: &str = "/extra/config.txt";
/// Far more than the names of ten thousand classes.
const MOST_BYTES: u64 = 1 << 20;

/// The metadata, all optional.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub(super) struct Metadata {
    /// The task of the network; only `detect` is supported.
    pub(super) task: Option<String>,
    /// Rows and columns of its input.
    imgsz: Option<[u32; 2]>,
    /// By class.
    pub(super) names: BTreeMap<u32, String>,
}

impl Metadata {
    /// Reads a module's file. Without metadata, or with other ones, all fields are empty.
    pub(super) fn of(module: &[u8]) -> Self {
        text(module).and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
    }

    pub(super) fn input(&self) -> Option<Size> {
        self.imgsz.map(|[height_pixels, width_pixels]| Size { width_pixels, height_pixels })
    }
}

fn text(module: &[u8]) -> Option<String> {
    let mut archive = ZipArchive::new(Cursor::new(module)).ok()?;
    let name = archive.file_names().find(|name| name.ends_with(ENTRY))?.to_owned();
    let mut text = String::new();
    archive.by_name(&name).ok()?.take(MOST_BYTES).read_to_string(&mut text).ok()?;
    Some(text)
}
