//! What the file of a module says of it: ultralytics' export leaves a JSON object in the archive that TorchScript is.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use serde::Deserialize;
use zip::ZipArchive;

use crate::picture::Size;

/// Where it lies, below a folder that is named as the module.
const ENTRY: &str = "/extra/config.txt";
/// Far more than the names of ten thousand classes.
const MOST_BYTES: u64 = 1 << 20;

/// What is said; nothing of it needs to be.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub(super) struct Metadata {
    /// What the network was made for; `detect` is what is understood.
    pub(super) task: Option<String>,
    /// Rows and columns of its input.
    imgsz: Option<[u32; 2]>,
    /// By class.
    pub(super) names: BTreeMap<u32, String>,
}

impl Metadata {
    /// Of a module's file. Of one that says nothing, or in other words than these, nothing is known.
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
