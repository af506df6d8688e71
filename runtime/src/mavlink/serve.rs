//! A vehicle behind its autopilot, driven by the wall clock.

use std::sync::Arc;
use std::time::{Duration, Instant};

use dragnet_mavlink::autopilot::{Level, Notice};
use dragnet_mavlink::frames::{Decoder, Encoder, Frame};
use dragnet_proto::state_machine::Event;
use dragnet_scenario::Scenario;
use tokio::net::UdpSocket;
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};

use super::detections;
use super::link::{Arrived, Link, MAX_DATAGRAM};
use super::vehicle::{Effect, Now, Vehicle};
use crate::clock::Clock;
use crate::config::MavlinkBody;
use crate::vehicle::{AgentOutputs, TICK};
use crate::wall_clock::Report;
use crate::{RuntimeError, unix_time};

/// Time without a message after which bytes that are none are worth a word.
const NO_MESSAGE: Duration = Duration::from_secs(5);

/// A vehicle with its connections.
struct Service {
    link: Link,
    vehicle: Vehicle,
    decoder: Decoder,
    encoder: Encoder,
    /// When the last message came.
    heard: Instant,
    reports: mpsc::Sender<Report>,
}

/// Opens the autopilot's and the detectors' sockets, and serves an agent until it is gone; then the vehicle has to
/// stay where it is.
///
/// # Errors
/// If an address is not free.
pub(crate) async fn serve(
    body: MavlinkBody,
    scenario: &Scenario,
    clock: Clock,
    mut outputs: AgentOutputs,
    reports: mpsc::Sender<Report>,
) -> Result<(), RuntimeError> {
    let MavlinkBody { mavlink: settings, pilot } = body;
    let failed = |key: &str, error: std::io::Error| RuntimeError::Mavlink(format!("{key}: {error}"));
    let link = Link::open(&settings.connection).await;
    let link = link.map_err(|error| failed(&format!("mavlink.connection {}", settings.connection), error))?;
    let detectors = UdpSocket::bind(settings.detections).await;
    let detectors = detectors
        .map_err(|error| failed(&format!("mavlink.detections.listen {}", settings.detections), error))?;
    let Some(vehicle) = Vehicle::new(pilot, &settings, scenario) else {
        return Err(RuntimeError::Mavlink("mavlink.position: the map has no origin on the earth".to_owned()));
    };
    let encoder = Encoder::new(settings.config.system, settings.config.component);
    let (decoder, heard) = (Decoder::default(), Instant::now());
    let mut service = Service { link, vehicle, decoder, encoder, heard, reports };
    let mut tick = interval(TICK);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut datagram = vec![0; MAX_DATAGRAM];
    loop {
        let effects = tokio::select! {
            arrived = service.link.receive() => service.receive(now(clock), arrived),
            received = detectors.recv_from(&mut datagram) => match received {
                Ok((length, _)) => {
                    let sighting = detections::read(&datagram[..length], &settings.filter);
                    service.vehicle.see(now(clock), sighting)
                }
                // An error is of a datagram that was sent to nobody.
                Err(_) => Vec::new(),
            },
            event = outputs.events.recv() => {
                let Some(event) = event else { break };
                service.vehicle.heed(now(clock), event)
            }
            _ = tick.tick() => service.vehicle.tick(now(clock)),
            // An agent that is gone ends by its events.
            Ok(()) = outputs.known.changed() => {
                let known = Arc::clone(&outputs.known.borrow_and_update());
                service.vehicle.believe(now(clock), &known.belief)
            }
        };
        service.act(effects).await;
    }
    let last = service.vehicle.halt(now(clock));
    service.act(last).await;
    service.link.flush().await;
    Ok(())
}

fn now(clock: Clock) -> Now {
    Now { mission_ns: clock.now().0, unix_ns: unix_time::now_ns() }
}

impl Service {
    fn receive(&mut self, now: Now, arrived: Arrived) -> Vec<Effect> {
        let bytes = match arrived {
            Arrived::Bytes(bytes) => bytes,
            Arrived::Trouble(trouble) => return self.vehicle.receive(now, Frame::Unreadable(trouble)),
        };
        let frames = self.decoder.push(&bytes);
        if !frames.is_empty() {
            self.heard = Instant::now();
        } else if self.heard.elapsed() > NO_MESSAGE {
            let reason =
                format!("{} bytes arrive that are no message of MAVLink's dialect common", bytes.len());
            return self.vehicle.receive(now, Frame::Unreadable(reason));
        }
        frames.into_iter().flat_map(|frame| self.vehicle.receive(now, frame)).collect()
    }

    async fn act(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Sensed { cell, readings } => {
                    // An agent that is gone receives nothing: the vehicle is about to be stopped.
                    let _ = self.reports.send((None, Event::Sensed { cell, readings })).await;
                }
                Effect::Report(event) => {
                    let _ = self.reports.send((None, event)).await;
                }
                Effect::Send(message) => self.link.send(self.encoder.encode(&message)),
                Effect::Tell(Notice { level: Level::Ok, subject, message }) => {
                    tracing::info!("{subject}: {message}");
                }
                Effect::Tell(Notice { subject, message, .. }) => tracing::warn!("{subject}: {message}"),
            }
        }
    }
}
