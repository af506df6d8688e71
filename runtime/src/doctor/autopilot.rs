//! Checks of the vehicle's autopilot: its heartbeat, and whether it can be steered. Nothing is sent.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_mavlink::autopilot::config::PositionSource;
use dragnet_mavlink::frames::{Decoder, Frame};
use dragnet_mavlink::mode::{Craft, Mode, is_armed};
use dragnet_mavlink::{MavHeader, MavMessage};
use tokio::time::Instant;

use super::Finding;
use crate::mavlink::link::{Arrived, Link};
use crate::mavlink::settings::{Checked, Connection};

/// The component number of autopilots.
const AUTOPILOT: u8 = 1;

/// What was heard of each system's autopilot.
#[derive(Default)]
struct Heard {
    /// Its last heartbeat in words, or why it cannot be steered.
    vehicle: Option<Result<String, String>>,
    positions: u32,
}

/// Listens to the autopilot. The robot that `runs_here` has its socket.
pub(super) async fn examine(
    settings: &Checked,
    runs_here: bool,
    listen: Duration,
    tell: &mut dyn FnMut(Finding),
) {
    let subject = format!("autopilot, {}", settings.connection);
    if runs_here {
        return tell(Finding::pass(
            subject,
            "not listened to: the robot runs, and its log says what it hears",
        ));
    }
    if matches!(settings.connection, Connection::UdpOut(_)) {
        let advice = "start the robot, whose log says what it hears";
        return tell(Finding::warn(subject, "not checked: it sends only once it is called", advice));
    }
    let mut link = match Link::open(&settings.connection).await {
        Ok(link) => link,
        Err(error) => {
            return tell(Finding::fail(
                subject,
                error.to_string(),
                "name a free address under mavlink.connection",
            ));
        }
    };
    let mut systems: BTreeMap<u32, Heard> = BTreeMap::new();
    let (mut decoder, mut trouble) = (Decoder::default(), None);
    let end = Instant::now() + listen;
    while let Ok(arrived) = tokio::time::timeout_at(end, link.receive()).await {
        match arrived {
            Arrived::Bytes(bytes) => {
                for frame in decoder.push(&bytes) {
                    if let Frame::Message(header, message) = frame {
                        note(&mut systems, header, &message, settings.config.position);
                    }
                }
            }
            Arrived::Trouble(text) => trouble = Some(text),
        }
    }
    if systems.is_empty() {
        let found = trouble.unwrap_or_else(|| format!("no heartbeat in {:.0} s", listen.as_secs_f64()));
        let advice = "start the autopilot, and see that its telemetry goes where mavlink.connection says";
        return tell(Finding::fail(subject, found, advice));
    }
    if let (None, true) = (settings.config.autopilot_system, systems.len() > 1) {
        let numbers: Vec<String> = systems.keys().map(ToString::to_string).collect();
        let found = format!("there are autopilots of the systems {}", numbers.join(", "));
        return tell(Finding::fail(subject, found, "name one under mavlink.autopilot_system"));
    }
    let wanted = settings.config.autopilot_system.map(u32::from);
    let found = match wanted {
        Some(wanted) => systems.get_key_value(&wanted),
        None => systems.first_key_value(),
    };
    let Some((system, heard)) = found else {
        let numbers: Vec<String> = systems.keys().map(ToString::to_string).collect();
        let found = format!("it sends nothing; those of the systems {} do", numbers.join(", "));
        return tell(Finding::fail(subject, found, "correct mavlink.autopilot_system"));
    };
    tell(heard.finding(subject, *system));
}

fn note(
    systems: &mut BTreeMap<u32, Heard>,
    header: MavHeader,
    message: &MavMessage,
    position: PositionSource,
) {
    if header.component_id != AUTOPILOT {
        return;
    }
    let heard = systems.entry(header.system_id).or_default();
    match (message, position) {
        (MavMessage::HEARTBEAT(heartbeat), _) => {
            heard.vehicle = Some(Craft::of(heartbeat).map(|craft| {
                let armed = if is_armed(heartbeat) { "armed" } else { "disarmed" };
                let kind = if craft.flies { "a copter" } else { "a rover or boat" };
                format!("{kind} of {:?}, {armed}, in {}", craft.firmware, Mode::of(craft, heartbeat))
            }));
        }
        (MavMessage::GLOBAL_POSITION_INT(_), PositionSource::Global)
        | (MavMessage::LOCAL_POSITION_NED(_), PositionSource::Local) => heard.positions += 1,
        _ => {}
    }
}

impl Heard {
    fn finding(&self, subject: String, system: u32) -> Finding {
        match &self.vehicle {
            Some(Ok(vehicle)) => {
                let positions = self.positions;
                Finding::pass(
                    subject,
                    format!("system {system}: {vehicle}; {positions} positions, asked for by none"),
                )
            }
            Some(Err(reason)) => Finding::fail(subject, format!("system {system}: {reason}"), ""),
            None => {
                let advice = "see that its heartbeats are sent to this computer too";
                Finding::fail(subject, format!("system {system} sends, but no heartbeat"), advice)
            }
        }
    }
}
