//! The state that all requests to a page share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use dragnet_coordinator::playback::Playback;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::Event;
use dragnet_scenario::time::MissionTime;
use serde_json::json;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, watch};

use crate::guard::Token;
use crate::view::View;

/// A command of the operator, as the coordinator's driver receives it: without a time of its own, and the event.
pub(crate) type Commanded = (Option<MissionTime>, Event<Message>);

/// The state that all requests share.
pub(crate) struct Shared {
    pub(crate) show: Show,
    /// Permits for viewers.
    pub(crate) viewers: Arc<Semaphore>,
    /// Further ones for those with the token.
    pub(crate) operators: Arc<Semaphore>,
    pub(crate) token: Token,
}

/// The mission of a page.
pub(crate) enum Show {
    /// A mission that is running, or has just ended.
    Running(Box<Running>),
    /// A recording; each viewer has its own time in it.
    Recorded(Arc<Playback>),
}

/// A mission that is running.
pub(crate) struct Running {
    pub(crate) view: Mutex<View>,
    /// Counts records, so that viewers know when to update, and stores whether there will be more.
    pub(crate) news: watch::Sender<News>,
    pub(crate) commands: mpsc::Sender<Commanded>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct News {
    pub(crate) records: u64,
    pub(crate) is_over: bool,
}

impl Shared {
    /// A permit for a viewer, if there is one; `token` is that of its request.
    pub(crate) fn place(&self, token: Option<&str>) -> Option<OwnedSemaphorePermit> {
        let take = |places: &Arc<Semaphore>| Arc::clone(places).try_acquire_owned().ok();
        let has_token = || token.is_some_and(|token| self.token.is(token));
        take(&self.viewers).or_else(|| if has_token() { take(&self.operators) } else { None })
    }
}

impl Running {
    pub(crate) fn view(&self) -> MutexGuard<'_, View> {
        // A view whose update panicked can still be read.
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(crate) fn refusal(status: StatusCode, why: &str) -> Response {
    (status, Json(json!({ "error": why }))).into_response()
}
