//! Pictures of finds: what a page says of them, and their files.

use std::sync::Arc;

use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use dragnet_coordinator::mission::Record;
use dragnet_proto::picture::Picture;
use dragnet_search::cell::Cell;
use serde::Serialize;

use crate::shared::{Shared, Show, refusal};
use crate::view::View;

/// The path of a picture's file. A page that has shown it need not ask again: another picture has another path.
pub(crate) const PATH: &str = "/picture/{cell}/{time_ns}";

/// A picture of a find.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureFrame {
    /// Path of its file, a JPEG.
    pub file: String,
    /// When it was taken, seconds.
    pub time: f64,
    /// The robot.
    pub robot: u16,
    /// The camera's name.
    pub camera: String,
    /// The detector's class and score, in words; may be empty.
    pub seen: String,
}

impl PictureFrame {
    /// The picture of a find, if there is one.
    #[must_use]
    pub fn of(view: &View, cell: Cell) -> Option<Self> {
        let facts = &view.fold().pictures().get(&cell)?.facts;
        Some(Self {
            file: format!("picture/{}/{}", cell.number(), facts.time_ns),
            time: facts.time_ns as f64 / 1e9,
            robot: facts.robot.number(),
            camera: facts.camera.clone(),
            seen: facts.seen(),
        })
    }
}

pub(crate) async fn file(State(shared): State<Arc<Shared>>, Path(named): Path<(u32, u64)>) -> Response {
    let is_it = |picture: &&Arc<Picture>| (picture.facts.cell.number(), picture.facts.time_ns) == named;
    let picture = match &shared.show {
        Show::Running(running) => running.view().fold().pictures().values().find(is_it).cloned(),
        Show::Recorded(playback) => {
            let pictures = playback.records.iter().filter_map(|(_, record)| match record {
                Record::Picture(picture) => Some(picture),
                _ => None,
            });
            pictures.into_iter().find(is_it).cloned()
        }
    };
    match picture {
        Some(picture) => {
            let kept = "private, max-age=3600, immutable";
            ([(header::CONTENT_TYPE, "image/jpeg"), (header::CACHE_CONTROL, kept)], picture.jpeg.to_vec())
                .into_response()
        }
        None => refusal(StatusCode::NOT_FOUND, "there is no such picture, or a better one has replaced it"),
    }
}
