//! The page on which a mission is planned: its server, which keeps the plan, and the requests of its viewers.
//!
//! The server holds one plan, which all tabs show; each change names the revision that it changes, so that no tab
//! overwrites what another has changed. Forecasts and simulations are made by a [`Planner`], which the caller passes:
//! this crate neither simulates nor starts programs.

mod draft;
mod forecasts;
mod import;
mod saving;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use dragnet_planning::{MissionPlan, Problem};
use dragnet_scenario::Scenario;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::assets::PLANNING;
use crate::guard::Token;
use crate::page::{Page, PageError, Settings, token};
use crate::shared::refusal;

use draft::{Draft, Stale};
use forecasts::Forecasts;
pub use forecasts::Watched;

/// The maximum size of a plan, bytes: as many corners as areas may have.
const MOST_PLAN_BYTES: usize = 4 << 20;
/// The maximum size of a request with a file: the longest file of areas in base64.
const MOST_IMPORT_BYTES: usize = 23 << 20;

/// Makes forecasts and simulations of plans.
pub trait Planner: Send + Sync + 'static {
    /// Simulates `missions` of each team size of `robots`; the results are those of `dragnet forecast --json`, one for
    /// each team. Progress goes to `watched`, which may cancel it.
    ///
    /// # Errors
    /// If no forecast is possible.
    fn forecast(
        &self,
        scenario: &Scenario,
        robots: &[u32],
        missions: u64,
        watched: Arc<Watched>,
    ) -> Result<Value, String>;

    /// Starts a simulation of a saved scenario; returns the address of its live page.
    ///
    /// # Errors
    /// If it does not start.
    fn simulate(&self, scenario: &Path) -> Result<String, String>;
}

/// What all requests share.
struct Desk {
    draft: Mutex<Draft>,
    forecasts: Forecasts,
    planner: Box<dyn Planner>,
    /// Where plans are saved.
    folder: PathBuf,
    token: Token,
}

/// Serves the page of a plan, which is saved into a folder.
///
/// # Errors
/// If the address or the base map cannot be used, or there is no token.
pub fn serve(
    settings: &Settings,
    plan: MissionPlan,
    folder: PathBuf,
    planner: Box<dyn Planner>,
) -> Result<Page, PageError> {
    let token = token(settings)?;
    let draft = Mutex::new(Draft::new(plan));
    let desk = Arc::new(Desk { draft, forecasts: Forecasts::default(), planner, folder, token });
    let router = Router::new()
        .route("/plan/state", get(state))
        .route("/plan/news", get(news))
        .route("/plan/change", post(change))
        .route("/plan/forecast", post(forecast))
        .route("/plan/cancel", post(cancel))
        .route("/plan/save", post(save))
        .route("/plan/simulate", post(simulate))
        .layer(DefaultBodyLimit::max(MOST_PLAN_BYTES))
        .route("/plan/import", post(import).layer(DefaultBodyLimit::max(MOST_IMPORT_BYTES)))
        .route("/auth", get(auth))
        .with_state(Arc::clone(&desk));
    Page::serve(settings, Some(&desk.token), &PLANNING, router)
}

impl Desk {
    fn draft(&self) -> MutexGuard<'_, Draft> {
        // A draft is replaced as a whole.
        self.draft.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn allow(&self, headers: &HeaderMap) -> Result<(), Refused> {
        let authorization = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok());
        if self.token.is_in(authorization) {
            Ok(())
        } else {
            Err(Refused::new(StatusCode::UNAUTHORIZED, "changing the plan requires the token"))
        }
    }

    /// The plan, what is wrong with it, and what has come of it.
    fn state(&self) -> Value {
        let mut state = self.draft().state();
        state["folder"] = json!(self.folder.display().to_string());
        state["forecast"] = self.forecasts.state();
        state
    }

    /// The same after a request, with what was done.
    fn state_with(&self, message: &str) -> Value {
        let mut state = self.state();
        state["message"] = json!(message);
        state
    }
}

/// A request that is not fulfilled, and why.
struct Refused {
    status: StatusCode,
    why: String,
    /// Files that would be overwritten.
    existing: Vec<String>,
}

impl Refused {
    fn new(status: StatusCode, why: impl Display) -> Self {
        Self { status, why: why.to_string(), existing: Vec::new() }
    }

    fn invalid(why: impl Display) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, why)
    }

    fn of_problems(problems: &[Problem]) -> Self {
        let first = problems.first().map(|problem| problem.message.as_str()).unwrap_or_default();
        Self::invalid(format!("the plan cannot be used yet: {first}"))
    }
}

impl From<Stale> for Refused {
    fn from(stale: Stale) -> Self {
        Self::new(StatusCode::CONFLICT, stale)
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        if self.existing.is_empty() {
            return refusal(self.status, &self.why);
        }
        (self.status, Json(json!({ "error": self.why, "existing": self.existing }))).into_response()
    }
}

/// Does the work of a request on a thread that may take its time.
async fn at_leisure(
    desk: Arc<Desk>,
    headers: &HeaderMap,
    work: impl FnOnce(&Arc<Desk>) -> Result<Value, Refused> + Send + 'static,
) -> Result<Json<Value>, Refused> {
    desk.allow(headers)?;
    let done = tokio::task::spawn_blocking(move || work(&desk)).await;
    done.unwrap_or_else(|error| Err(Refused::new(StatusCode::INTERNAL_SERVER_ERROR, error))).map(Json)
}

fn parsed<T: DeserializeOwned>(body: &str) -> Result<T, Refused> {
    serde_json::from_str(body).map_err(|error| Refused::new(StatusCode::BAD_REQUEST, error))
}

async fn state(State(desk): State<Arc<Desk>>) -> Json<Value> {
    Json(desk.state())
}

/// What changes without a request of this tab: the plan by another tab, and the forecast.
async fn news(State(desk): State<Arc<Desk>>) -> Json<Value> {
    let revision = desk.draft().revision();
    Json(json!({ "revision": revision, "forecast": desk.forecasts.state() }))
}

/// Whether the request has the token: a page asks this before it offers changes.
async fn auth(State(desk): State<Arc<Desk>>, headers: HeaderMap) -> Result<StatusCode, Refused> {
    desk.allow(&headers).map(|()| StatusCode::NO_CONTENT)
}

/// A changed plan.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Change {
    /// The revision that was changed.
    revision: u64,
    /// The plan, read by itself so that its errors name its keys.
    plan: Value,
}

async fn change(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    body: String,
) -> Result<Json<Value>, Refused> {
    at_leisure(desk, &headers, move |desk| {
        let Change { revision, plan } = parsed(&body)?;
        let sent = MissionPlan::from_json(plan).map_err(Refused::invalid)?;
        let changed = desk.draft().plan_at(revision)?.changed(sent);
        // Without the lock: a review of a large map takes a while.
        let changed = Draft::reviewed(changed);
        desk.draft().replace(revision, changed)?;
        Ok(desk.state())
    })
    .await
}

async fn import(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    body: String,
) -> Result<Json<Value>, Refused> {
    at_leisure(desk, &headers, move |desk| {
        let import::Import { revision, plan, message } =
            import::import(parsed(&body)?, |revision| desk.draft().plan_at(revision).cloned())?;
        desk.draft().replace(revision, Draft::reviewed(plan))?;
        Ok(desk.state_with(&message))
    })
    .await
}

/// A forecast that is asked for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Forecast {
    /// The largest team.
    robots: u32,
    /// Simulated missions of each team.
    missions: u64,
}

async fn forecast(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    body: String,
) -> Result<Json<Value>, Refused> {
    at_leisure(desk, &headers, move |desk| {
        let Forecast { robots, missions } = parsed(&body)?;
        let (revision, scenario) =
            desk.draft().scenario().map_err(|problems| Refused::of_problems(&problems))?;
        let teams = forecasts::teams(robots, missions).map_err(Refused::invalid)?;
        let asked = forecasts::Asked { revision, scenario, teams, missions };
        Forecasts::begin(desk, asked);
        Ok(desk.state())
    })
    .await
}

async fn cancel(State(desk): State<Arc<Desk>>, headers: HeaderMap) -> Result<Json<Value>, Refused> {
    at_leisure(desk, &headers, move |desk| {
        desk.forecasts.cancel();
        Ok(desk.state())
    })
    .await
}

/// A plan that is to be saved.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Save {
    revision: u64,
    /// Whether files of its name may be overwritten.
    overwrite: bool,
}

async fn save(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    body: String,
) -> Result<Json<Value>, Refused> {
    at_leisure(desk, &headers, move |desk| {
        let Save { revision, overwrite } = parsed(&body)?;
        let message = desk.draft().save(revision, &desk.folder, overwrite)?;
        Ok(desk.state_with(&message))
    })
    .await
}

async fn simulate(State(desk): State<Arc<Desk>>, headers: HeaderMap) -> Result<Json<Value>, Refused> {
    at_leisure(desk, &headers, move |desk| {
        let scenario = desk.draft().saved_scenario(&desk.folder)?;
        let address = desk.planner.simulate(&scenario);
        let address = address.map_err(|why| Refused::new(StatusCode::INTERNAL_SERVER_ERROR, why))?;
        Ok(json!({ "address": address }))
    })
    .await
}
