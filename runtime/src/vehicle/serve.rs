//! A vehicle on its network, driven by the wall clock.

use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::state_machine::Event;
use dragnet_ros2::output::{Diagnostic, Level};
use dragnet_scenario::Scenario;
use tokio::sync::mpsc;
use tokio::time::{MissedTickBehavior, interval};

use super::detector::{Detector, DetectorWorker};
use super::{AgentOutputs, Effect, Now, SHOW, TICK, Vehicle};
use crate::clock::Clock;
use crate::config::Body;
use crate::pictures::Shelf;
use crate::ros::node::Node;
use crate::wall_clock::Report;
use crate::{RuntimeError, unix_time};

/// A vehicle with its connections.
struct Service {
    node: Node,
    vehicle: Vehicle,
    eyes: DetectorWorker,
    clock: Clock,
    shelf: Arc<Shelf>,
    reports: mpsc::Sender<Report>,
}

/// Joins the vehicle's network, which may take until that is there, and serves an agent until it is gone; then the
/// vehicle stops.
///
/// # Errors
/// If Zenoh fails.
pub(crate) async fn serve(
    body: Body,
    scenario: &Scenario,
    clock: Clock,
    detector: Option<Box<dyn Detector>>,
    mut outputs: AgentOutputs,
    reports: mpsc::Sender<Report>,
) -> Result<(), RuntimeError> {
    let vehicle = Vehicle::new(body.pilot, &body.ros, scenario);
    let node = Node::open(body.ros).await?;
    let (eyes, shelf) = (DetectorWorker::new(detector), Arc::clone(&outputs.shelf));
    let mut service = Service { node, vehicle, eyes, clock, shelf, reports };
    let [mut tick, mut show] = [TICK, SHOW].map(interval);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let Service { node, vehicle, eyes, .. } = &mut service;
        let effects = tokio::select! {
            (topic, received) = node.receive_on() => vehicle.receive(now(clock), &topic, received),
            seen = eyes.see() => vehicle.see(now(clock), seen),
            event = outputs.events.recv() => {
                let Some(event) = event else { break };
                vehicle.heed(now(clock), event)
            }
            _ = tick.tick() => vehicle.tick(now(clock)),
            _ = show.tick() => {
                // An agent that is gone has published its last belief.
                let has_changed = outputs.known.has_changed().unwrap_or(false);
                let known = Arc::clone(&outputs.known.borrow_and_update());
                vehicle.show(now(clock), &known.belief, &known.positions, has_changed)
            }
        };
        service.act(effects).await?;
    }
    let last = service.vehicle.halt();
    service.act(last).await
}

fn now(clock: Clock) -> Now {
    Now { mission: clock.now(), unix_ns: unix_time::now_ns() }
}

impl Service {
    async fn act(&mut self, effects: Vec<Effect>) -> Result<(), RuntimeError> {
        for effect in effects {
            match effect {
                Effect::Sensed { cell, readings } => {
                    // An agent that is gone receives nothing: the vehicle is about to be stopped.
                    let _ = self.reports.send((None, Event::Sensed { cell, readings })).await;
                }
                Effect::Report(event) => {
                    let _ = self.reports.send((None, event)).await;
                }
                Effect::Picture(picture) => {
                    let age_ns = self.clock.now().0.saturating_sub(picture.time_ns);
                    self.shelf.put(Duration::from_nanos(age_ns), picture);
                }
                Effect::Publish(output) => self.node.publish(unix_time::now_ns(), output).await?,
                Effect::Detect(request) => self.eyes.show(request),
                Effect::Tell(Diagnostic { level: Level::Ok, name, message, .. }) => {
                    tracing::info!("{name}: {message}");
                }
                Effect::Tell(Diagnostic { name, message, .. }) => tracing::warn!("{name}: {message}"),
            }
        }
        Ok(())
    }
}
