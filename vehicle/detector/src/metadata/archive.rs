//! The JSON object in the archive of a TorchScript module.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};

use serde::Deserialize;
use zip::ZipArchive;

use super::{Metadata, size};

/// Its path, below a folder with the module's name.
const ENTRY: &str = "/extra/config.txt";
/// Far more than the names of ten thousand classes.
const MOST_BYTES: u64 = 1 << 20;

#[derive(Default, Deserialize)]
#[serde(default)]
struct Config {
    task: Option<String>,
    /// Rows and columns.
    imgsz: Option<[u32; 2]>,
    names: BTreeMap<u32, String>,
}

/// The metadata of a TorchScript module. Without any, or with other ones, all fields are empty.
pub(crate) fn of_module(module: &[u8]) -> Metadata {
    let config: Config = text(module).and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default();
    let Config { task, imgsz, names } = config;
    Metadata { task, input: imgsz.map(size), fixed_input: None, names }
}

fn text(module: &[u8]) -> Option<String> {
    let mut archive = ZipArchive::new(Cursor::new(module)).ok()?;
    let name = archive.file_names().find(|name| name.ends_with(ENTRY))?.to_owned();
    let mut text = String::new();
    archive.by_name(&name).ok()?.take(MOST_BYTES).read_to_string(&mut text).ok()?;
    Some(text)
}
