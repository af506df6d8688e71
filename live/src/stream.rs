//! The stream of frames to one viewer.
//!
//! A frame is made when the one before has been sent, from the changes since then: a slow viewer gets fewer frames, and
//! nothing waits for it.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::extract::ws::{Message, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use dragnet_coordinator::playback::Playback;
use dragnet_scenario::time::MissionTime;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tokio::time::{Instant, sleep, timeout};

use crate::frame::{Frame, Hello, Shown};
use crate::replay::Replay;
use crate::shared::{Running, Shared, Show, refusal};
use crate::socket::{Gone, Viewer};

/// Time between two frames.
const PERIOD: Duration = Duration::from_millis(100);
/// Time after which a viewer without news receives a [`Beat`]: a page without messages is out of date.
const BEAT: Duration = Duration::from_secs(1);
/// The WebSocket protocol of viewers,
const PROTOCOL: &str = "dragnet";
/// and the prefix of the token that they may offer beside it.
const TOKEN: &str = "token.";
/// The maximum size of a viewer's message, bytes.
const MOST_BYTES: usize = 4096;

/// Says that nothing has changed.
#[derive(Debug, PartialEq, Serialize)]
struct Beat {
    /// `beat`.
    kind: &'static str,
    /// Time since the coordinator's last record, seconds; 0 in a recording.
    quiet_seconds: f64,
}

impl Beat {
    fn after(quiet: Duration) -> Self {
        Self { kind: "beat", quiet_seconds: quiet.as_secs_f64() }
    }
}

pub(crate) async fn open(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let Some(place) = shared.place(token(&headers)) else {
        return refusal(StatusCode::SERVICE_UNAVAILABLE, "too many are watching; try again later");
    };
    let upgrade = upgrade.max_message_size(MOST_BYTES).protocols([PROTOCOL]);
    upgrade.on_upgrade(async move |socket| {
        let mut socket = Viewer::new(socket);
        // A viewer that leaves ends its stream, which is not a failure.
        let _gone = match &shared.show {
            Show::Running(running) => show_running(&mut socket, running).await,
            Show::Recorded(playback) => show_recorded(&mut socket, playback).await,
        };
        drop(place);
    })
}

/// The token that a viewer offers beside the protocol: a page cannot set another header of its stream.
fn token(headers: &HeaderMap) -> Option<&str> {
    let offered = headers.get(header::SEC_WEBSOCKET_PROTOCOL)?.to_str().ok()?;
    offered.split(',').find_map(|name| name.trim().strip_prefix(TOKEN))
}

async fn show_running(socket: &mut Viewer, running: &Running) -> Result<(), Gone> {
    let mut shown = Shown::default();
    let mut news = running.news.subscribe();
    let hello = Hello::new(&running.view(), None);
    send(socket, &hello).await?;
    let mut was_over = false;
    loop {
        let now = *news.borrow_and_update();
        tracing::trace!("a viewer sees {} records", now.records);
        let frame = Frame::next(&running.view(), &mut shown);
        send(socket, &frame).await?;
        if now.is_over && !was_over {
            was_over = true;
            send(socket, &json!({ "kind": "over" })).await?;
        }
        let framed = Instant::now();
        while framed.elapsed() < PERIOD {
            listen(socket, PERIOD.saturating_sub(framed.elapsed())).await?;
        }
        loop {
            tokio::select! {
                changed = news.changed() => match changed {
                    Ok(()) => break,
                    Err(_) => return Err(Gone),
                },
                received = receive(socket) => { received?; }
                () = sleep(BEAT) => send(socket, &Beat::after(framed.elapsed())).await?,
            }
        }
    }
}

/// A request of a viewer of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Wish {
    /// Move to this time, seconds.
    seek: Option<f64>,
    /// Play at this speed, mission seconds per second; 0 stops.
    speed: Option<f64>,
}

/// The maximum speed.
const MOST_SPEED: f64 = 1000.0;

/// The playback position of a viewer, and since when.
struct Place {
    seconds: f64,
    speed: f64,
    since: Instant,
    end: f64,
}

impl Place {
    fn now(&self) -> f64 {
        (self.seconds + self.since.elapsed().as_secs_f64() * self.speed).min(self.end)
    }

    /// Applies a request; returns whether the position was moved.
    fn grant(&mut self, wish: Wish) -> bool {
        self.seconds = self.now();
        self.since = Instant::now();
        if self.seconds >= self.end {
            // Otherwise it would run on from wherever the viewer goes next.
            self.speed = 0.0;
        }
        if let Some(speed) = wish.speed.filter(|speed| speed.is_finite()) {
            self.speed = speed.clamp(0.0, MOST_SPEED);
        }
        let seek = wish.seek.filter(|seconds| seconds.is_finite());
        if let Some(seconds) = seek {
            self.seconds = seconds.clamp(0.0, self.end);
        }
        seek.is_some()
    }
}

async fn show_recorded(socket: &mut Viewer, playback: &Arc<Playback>) -> Result<(), Gone> {
    let mut replay = Replay::new(Arc::clone(playback));
    let end = replay.end().as_seconds();
    let hello = Hello { finds: replay.find_seconds(), ..Hello::new(replay.view(), Some(end)) };
    send(socket, &hello).await?;
    let mut shown = Shown::default();
    let mut place = Place { seconds: 0.0, speed: 0.0, since: Instant::now(), end };
    loop {
        replay.seek(MissionTime::START + Duration::from_secs_f64(place.now()));
        let frame = Frame::next(replay.view(), &mut shown);
        send(socket, &frame).await?;
        let wish = loop {
            let is_still = place.speed == 0.0 || place.now() >= end;
            match listen(socket, if is_still { BEAT } else { PERIOD }).await? {
                None if is_still => send(socket, &Beat::after(Duration::ZERO)).await?,
                wish => break wish,
            }
        };
        if wish.is_some_and(|wish| place.grant(wish)) {
            shown = Shown::default();
        }
    }
}

/// The viewer's request within a time limit, if there is one.
async fn listen(socket: &mut Viewer, most: Duration) -> Result<Option<Wish>, Gone> {
    match timeout(most, receive(socket)).await {
        Ok(received) => received,
        Err(_) => Ok(None),
    }
}

/// The viewer's next message; `None` if it is not a request.
async fn receive(socket: &mut Viewer) -> Result<Option<Wish>, Gone> {
    match socket.recv().await? {
        Message::Close(_) => Err(Gone),
        Message::Text(text) => Ok(serde_json::from_str(&text).ok()),
        _ => Ok(None),
    }
}

async fn send(socket: &mut Viewer, message: &impl Serialize) -> Result<(), Gone> {
    let text = serde_json::to_string(message).map_err(|_| Gone)?;
    socket.send(Message::Text(text.into())).await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_that_has_played_to_its_end_does_not_run_on() {
        let mut place = Place { seconds: 90.0, speed: 1000.0, since: Instant::now(), end: 90.0 };
        assert!(place.grant(Wish { seek: Some(30.0), speed: None }));
        let is = |number: f64, expected: f64| (number - expected).abs() < 1e-9;
        assert!(is(place.speed, 0.0) && is(place.seconds, 30.0), "{} {}", place.speed, place.seconds);
        place.grant(Wish { seek: None, speed: Some(5.0) });
        assert!(is(place.speed, 5.0), "{}", place.speed);
        assert!(place.grant(Wish { seek: Some(40.0), speed: None }));
        assert!(is(place.speed, 5.0), "before its end it plays on from there: {}", place.speed);
    }
}
