//! The server of the page: serves its files, streams frames to each viewer, and accepts commands from viewers with the
//! token.

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use dragnet_coordinator::node::Listener;
use dragnet_coordinator::playback::Playback;
use dragnet_files::read_text_at_most;
use dragnet_proto::state_machine::Event;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tokio::runtime::Runtime;
use tokio::sync::{Semaphore, mpsc, watch};
use tokio::time::timeout;

use crate::asked;
use crate::assets::{ASSETS, Asset, MISSION};
use crate::basemap::{self, BaseMap};
use crate::door;
use crate::guard::{Token, TokenError, is_own_page};
use crate::picture;
use crate::shared::{Commanded, Running, Shared, Show, refusal};
use crate::stream;
use crate::view::{About, View};

/// Number of threads that serve the page.
const THREADS: usize = 2;
/// Maximum number of viewers,
const MOST_VIEWERS: usize = 32;
/// and of further ones with the token.
const MOST_OPERATORS: usize = 8;
/// Time limit for a request, for example one whose body does not arrive.
const MOST_TIME: Duration = Duration::from_secs(10);
/// The maximum size of a command, bytes: a polygon of [`crate::polygon::MOST_CORNERS`].
const MOST_BYTES: usize = 64 * 1024;
/// Maximum number of commands that wait for the coordinator.
const MOST_WAITING: usize = 64;

/// The page may load only its own files, and may not be framed.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The live page.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Address and port of the page; port 0 is any free one. With 127.0.0.1 only this computer can open it.
    pub listen: SocketAddr,
    /// A file with the token for commands, at least 16 characters, relative to the working directory; without it a new
    /// token is drawn and printed.
    pub token_file: Option<PathBuf>,
    /// A map to show under the search: raster tiles in a PMTiles file, relative to the working directory. Pages load
    /// nothing from the internet.
    pub basemap: Option<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { listen: SocketAddr::from(([127, 0, 0, 1], 0)), token_file: None, basemap: None }
    }
}

/// Why a page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The address cannot be used.
    #[error("cannot serve a page at {listen}: {source}")]
    Listen {
        /// The address.
        listen: SocketAddr,
        /// The cause.
        source: io::Error,
    },
    /// The token's file is invalid.
    #[error("{}: {reason}", file.display())]
    TokenFile {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The base map cannot be used.
    #[error("base map {}: {reason}", file.display())]
    BaseMap {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// An invalid token.
    #[error(transparent)]
    Token(#[from] TokenError),
}

/// A page, which is served until this value is dropped.
pub struct Page {
    runtime: Runtime,
    address: String,
}

/// Marks the mission as over when the coordinator drops it.
struct Teller(Arc<Shared>);

impl Drop for Teller {
    fn drop(&mut self) {
        if let Show::Running(running) = &self.0.show {
            running.news.send_modify(|news| news.is_over = true);
        }
    }
}

impl Page {
    /// Serves a mission before its start; returns the page, a listener for the coordinator's records, and the receiver
    /// of the operator's commands.
    ///
    /// # Errors
    /// If the address or the base map cannot be used, or there is no token.
    pub fn of_mission(
        settings: &Settings,
        about: About,
    ) -> Result<(Self, Listener, mpsc::Receiver<Commanded>), PageError> {
        let (commands, commanded) = mpsc::channel(MOST_WAITING);
        let view = Mutex::new(View::new(Arc::new(about)));
        let running = Running { view, news: watch::Sender::default(), commands };
        let shared = share(settings, Show::Running(Box::new(running)))?;
        let page = Self::serve(settings, Some(&shared.token), &MISSION, router(Arc::clone(&shared)))?;
        let teller = Teller(shared);
        let listener: Listener = Box::new(move |now, record| {
            if let Show::Running(running) = &teller.0.show {
                running.view().take(now, record);
                running.news.send_modify(|news| news.records += 1);
            }
        });
        Ok((page, listener, commanded))
    }

    /// Serves a recording.
    ///
    /// # Errors
    /// If the address or the base map cannot be used.
    pub fn of_recording(settings: &Settings, playback: Playback) -> Result<Self, PageError> {
        let shared = share(settings, Show::Recorded(Arc::new(playback)))?;
        Self::serve(settings, None, &MISSION, router(shared))
    }

    /// Serves a page, its files, its base map and what a router answers. The address contains the token, if there is something to change on the page and
    /// the token is not from a file.
    pub(crate) fn serve(
        settings: &Settings,
        token: Option<&Token>,
        page: &'static Asset,
        router: Router,
    ) -> Result<Self, PageError> {
        let failed = |source| PageError::Listen { listen: settings.listen, source };
        let (runtime, listener, address) = door::listen(settings.listen, THREADS).map_err(failed)?;
        let rights = match token {
            Some(token) if settings.token_file.is_none() => format!("/#token={}", token.text()),
            _ => "/".to_owned(),
        };
        let map = match &settings.basemap {
            Some(file) => Some(
                runtime
                    .block_on(BaseMap::open(file))
                    .map_err(|reason| PageError::BaseMap { file: file.clone(), reason })?,
            ),
            None => None,
        };
        let router = guarded(page, router.merge(basemap::routes(map)));
        runtime.spawn(door::serve(listener, router));
        Ok(Self { runtime, address: format!("http://{address}{rights}") })
    }

    /// The page's address, with a new random token; a configured token is not included.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Serves the page until the future that `stop` returns is ready. The future runs on the Tokio runtime of the page.
    pub fn serve_until<F: Future<Output = ()>>(self, stop: impl FnOnce() -> F) {
        self.runtime.block_on(async { stop().await });
        self.runtime.shutdown_background();
    }
}

/// The maximum size of a token's file, bytes.
const MAX_TOKEN_BYTES: u64 = 1 << 12;

pub(crate) fn token(settings: &Settings) -> Result<Token, PageError> {
    let Some(file) = &settings.token_file else { return Ok(Token::random()?) };
    let failed = |reason: String| PageError::TokenFile { file: file.clone(), reason };
    let text = read_text_at_most(file, MAX_TOKEN_BYTES).map_err(|error| failed(error.to_string()))?;
    Token::chosen(&text).map_err(|error| failed(error.to_string()))
}

fn share(settings: &Settings, show: Show) -> Result<Arc<Shared>, PageError> {
    let token = token(settings)?;
    let [viewers, operators] = [MOST_VIEWERS, MOST_OPERATORS].map(|most| Arc::new(Semaphore::new(most)));
    Ok(Arc::new(Shared { show, viewers, operators, token }))
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/stream", get(stream::open))
        .route(picture::PATH, get(picture::file))
        .route("/auth", get(auth))
        .route("/command", post(command))
        .layer(DefaultBodyLimit::max(MOST_BYTES))
        .with_state(shared)
}

/// The router with a page and its files; only pages of this server are answered.
fn guarded(page: &'static Asset, mut router: Router) -> Router {
    for asset in ASSETS.iter().chain([page]) {
        let reply = move || async move { ([(header::CONTENT_TYPE, asset.media_type)], asset.body) };
        router = router.route(asset.path, get(reply));
    }
    router.layer(middleware::from_fn(guard))
}

/// Rejects requests that are not from a page of this server, and sets the page's security headers.
async fn guard(request: Request, next: Next) -> Response {
    let is_own = {
        let value = |name: HeaderName| request.headers().get(name).and_then(|value| value.to_str().ok());
        is_own_page(value(header::HOST), value(header::ORIGIN))
    };
    let mut response = if is_own {
        let answer = timeout(MOST_TIME, next.run(request)).await;
        answer.unwrap_or_else(|_| refusal(StatusCode::REQUEST_TIMEOUT, "the request did not come in time"))
    } else {
        refusal(StatusCode::FORBIDDEN, "only a page of this server, by its number or localhost, is answered")
    };
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

/// Whether the request has the token: a page asks this before it offers controls.
async fn auth(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    match allowed(&shared, &headers) {
        Ok(_) => StatusCode::NO_CONTENT.into_response(),
        Err(refusal) => *refusal,
    }
}

async fn command(State(shared): State<Arc<Shared>>, headers: HeaderMap, body: String) -> Response {
    let running = match allowed(&shared, &headers) {
        Ok(running) => running,
        Err(refusal) => return *refusal,
    };
    let ask = match asked::read(&body) {
        Ok(ask) => ask,
        Err(why) => return refusal(StatusCode::BAD_REQUEST, &why),
    };
    let (command, answer) = match ask.command(&running.view()) {
        Ok(answered) => answered,
        Err(error) => return refusal(StatusCode::UNPROCESSABLE_ENTITY, &error.to_string()),
    };
    match running.commands.try_send((None, Event::Commanded(command))) {
        Ok(()) => Json(json!({ "message": answer })).into_response(),
        Err(mpsc::error::TrySendError::Closed(_)) => refusal(StatusCode::CONFLICT, "the mission is over"),
        Err(mpsc::error::TrySendError::Full(_)) => {
            refusal(StatusCode::TOO_MANY_REQUESTS, "the coordinator has more to do than it can; try again")
        }
    }
}

/// The running mission, if the request may change it.
fn allowed<'a>(shared: &'a Shared, headers: &HeaderMap) -> Result<&'a Running, Box<Response>> {
    let refused = |status, why| Err(Box::new(refusal(status, why)));
    let Show::Running(running) = &shared.show else {
        return refused(StatusCode::CONFLICT, "a recording cannot be changed");
    };
    let authorization = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
    if !shared.token.is_in(authorization) {
        return refused(StatusCode::UNAUTHORIZED, "changing the mission requires the token");
    }
    Ok(running)
}
