//! The map under the map: raster tiles of a PMTiles file (version 3), in spherical Mercator, so that a page shows the
//! ground without the internet.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use dragnet_files::open_plain;
use pmtiles::{
    AsyncBackend, AsyncPmTilesReader, BackendResponse, HashMapCache, PmtResult, TileCoord, TileType,
};
use serde::Serialize;
use serde_json::Value;

use crate::shared::refusal;

/// The most bytes that are read at once: of a tile, or of an index of tiles.
const MOST_BYTES: usize = 8 << 20;
/// The most characters of an attribution.
const MOST_CHARACTERS: usize = 300;

/// Raster tiles of a file.
pub(crate) struct BaseMap {
    tiles: AsyncPmTilesReader<Archive, HashMapCache>,
    about: About,
}

/// What pages know of a base map.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct About {
    /// Levels of zoom that the file has.
    min_zoom: u8,
    max_zoom: u8,
    /// West, south, east and north, degrees.
    bounds: [f64; 4],
    /// Whose map it is, as the file says.
    attribution: String,
}

/// A file that is read where a tile lies. It is not mapped into memory: if its disk is pulled out, a tile fails and not
/// the program.
struct Archive(Arc<File>);

impl AsyncBackend for Archive {
    async fn read(&self, offset: u64, length: usize) -> PmtResult<BackendResponse> {
        if length > MOST_BYTES {
            let reason = format!("a part of {length} bytes; allowed are at most {MOST_BYTES}");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason).into());
        }
        let file = Arc::clone(&self.0);
        let read = tokio::task::spawn_blocking(move || read_at(&file, offset, length));
        let bytes = read.await.map_err(io::Error::other)??;
        Ok(BackendResponse::new(Bytes::from(bytes)))
    }
}

/// Up to `length` bytes from a place on.
fn read_at(file: &File, offset: u64, length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; length];
    let mut filled = 0;
    while filled < length {
        match file.read_at(&mut bytes[filled..], offset.saturating_add(filled as u64)) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    bytes.truncate(filled);
    Ok(bytes)
}

impl BaseMap {
    /// Opens a file.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(crate) async fn open(file: &Path) -> Result<Self, String> {
        let archive = Archive(Arc::new(open_plain(file).map_err(|error| error.to_string())?));
        let tiles = AsyncPmTilesReader::try_from_cached_source(archive, HashMapCache::default()).await;
        let tiles = tiles
            .map_err(|error| format!("{error}; allowed are raster tiles in a PMTiles file (version 3)"))?;
        let header = tiles.get_header();
        if !matches!(header.tile_type, TileType::Png | TileType::Jpeg | TileType::Webp | TileType::Avif) {
            let found = format!("{:?}", header.tile_type).to_lowercase();
            return Err(format!("its tiles are of the type {found}; allowed are png, jpeg, webp and avif"));
        }
        let about = About {
            min_zoom: header.min_zoom,
            max_zoom: header.max_zoom,
            bounds: [header.min_longitude, header.min_latitude, header.max_longitude, header.max_latitude],
            attribution: attribution(&tiles.get_metadata().await.unwrap_or_default()),
        };
        Ok(Self { tiles, about })
    }
}

/// Whose map it is, by the metadata of the file: text without tags.
fn attribution(metadata: &str) -> String {
    let metadata: Value = serde_json::from_str(metadata).unwrap_or_default();
    let mut is_in_tag = false;
    let is_text = |letter: &char| {
        is_in_tag = *letter == '<' || (is_in_tag && *letter != '>');
        !is_in_tag && *letter != '>'
    };
    let text = metadata["attribution"].as_str().unwrap_or_default();
    text.chars().filter(is_text).take(MOST_CHARACTERS).collect()
}

/// The requests for a base map; without one, pages are told that there is none.
pub(crate) fn routes(map: Option<BaseMap>) -> Router {
    Router::new()
        .route("/basemap", get(about))
        .route("/basemap/{zoom}/{column}/{row}", get(tile))
        .with_state(Arc::new(map))
}

async fn about(State(map): State<Arc<Option<BaseMap>>>) -> Json<Option<About>> {
    Json(map.as_ref().as_ref().map(|map| map.about.clone()))
}

async fn tile(
    State(map): State<Arc<Option<BaseMap>>>,
    axum::extract::Path((zoom, column, row)): axum::extract::Path<(u8, u32, u32)>,
) -> Response {
    let none = || refusal(StatusCode::NOT_FOUND, "no such tile");
    let Some(BaseMap { tiles, .. }) = map.as_ref() else { return none() };
    let Ok(place) = TileCoord::new(zoom, column, row) else { return none() };
    let media_type = tiles.get_header().tile_type.content_type();
    match tiles.get_tile_decompressed(place).await {
        Ok(Some(body)) => {
            ([(header::CONTENT_TYPE, media_type), (header::CACHE_CONTROL, "private, max-age=300")], body)
                .into_response()
        }
        Ok(None) => none(),
        Err(error) => {
            tracing::warn!("tile {zoom}/{column}/{row} of the base map cannot be read: {error}");
            refusal(StatusCode::INTERNAL_SERVER_ERROR, "the tile cannot be read")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attribution_is_text() {
        let check = |metadata: &str, expected: &str| assert_eq!(attribution(metadata), expected);
        check(
            r#"{"attribution": "<a href=\"https://osm.org\">&copy; OpenStreetMap</a> contributors"}"#,
            "&copy; OpenStreetMap contributors",
        );
        check(r#"{"attribution": 3}"#, "");
        check("no JSON", "");
        assert_eq!(
            attribution(&format!(r#"{{"attribution": "{}"}}"#, "a".repeat(1000))).len(),
            MOST_CHARACTERS
        );
    }

    #[tokio::test]
    async fn a_file_that_is_no_raster_archive_says_what_is_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.pmtiles");
        let refused = async |bytes: &[u8]| {
            std::fs::write(&file, bytes).unwrap();
            BaseMap::open(&file).await.err().unwrap()
        };
        for bytes in [b"" as &[u8], b"PNG", b"PMTiles\x03", &[b"PMTiles\x03" as &[u8], &[0xff; 200]].concat()]
        {
            assert!(refused(bytes).await.contains("PMTiles file (version 3)"), "{bytes:?}");
        }
        assert!(BaseMap::open(folder.path()).await.err().unwrap().contains("a folder"));
        let nowhere = folder.path().join("nowhere.pmtiles");
        assert!(BaseMap::open(&nowhere).await.err().unwrap().contains("No such file"));
    }
}
