//! The state machine between a robot and its autopilot. It steers the vehicle while it has control, and yields.
//!
//! **Control.** The robot steers only a vehicle that is armed and in the mode in which it follows targets: `GUIDED` of
//! ArduPilot, `OFFBOARD` of PX4. In every other mode the vehicle is its pilot's, or the autopilot's own: in `RTL`, in a
//! failsafe. Then nothing is sent that moves it, and the last wish waits until the mode is back. The robot switches
//! modes in two cases only: at its start, if it is to arm the vehicle ([`config::Engage::Robot`]), and to send it home.
//!
//! PX4 enters `OFFBOARD` only while targets arrive. So it gets its own place as a target in its other modes, in which it
//! ignores it.
//!
//! **Faults.** Each is reported when it begins and when it has been over for three seconds, in the log and as
//! `STATUSTEXT`; until then the vehicle does what the settings say ([`config::Response`]). Nothing is sent to restore a
//! lost link: what happens then is the autopilot's own failsafe.
//!
//! **Loss.** Every message may be lost, repeated or overtaken. What is wished is sent again every second, requests are
//! repeated until they are granted, and older positions than the last are dropped.

pub mod battery;
mod boot_clock;
pub mod config;
mod control;
mod engage;
mod event;
mod fence;
mod orders;
mod requests;
mod senses;

use std::collections::BTreeMap;
use std::fmt;

use dragnet_vehicle::pilot::alarms::Alarms;
use mavlink_core::MavHeader;

use crate::MavMessage;
use crate::common::HEARTBEAT_DATA;
use crate::mode::{Craft, Firmware, Mode, is_armed};
use crate::target::{Limits, Place, Position, Target};

use battery::Batteries;
use boot_clock::BootClock;
use config::Config;
use control::{Control, Order, Wish};
use engage::Starter;

pub use event::{Action, Event, Level, Notice};

/// Time without a fault after which it is over, nanoseconds.
const RECOVERY_NS: u64 = 3_000_000_000;
/// Period of heartbeats, and of repeated wishes, nanoseconds.
const SECOND_NS: u64 = 1_000_000_000;
/// Period of repeated wishes to PX4, which leaves `OFFBOARD` without them for half a second.
const STREAM_NS: u64 = 200_000_000;

/// The subject of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Subject {
    /// Heartbeats.
    Link,
    /// Two autopilots.
    Identity,
    /// A vehicle that cannot be steered.
    Vehicle,
    Position,
    /// A low battery.
    Battery,
    /// A charge that cannot be.
    Charge,
    Fence,
    Target,
    Input,
}

impl fmt::Display for Subject {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Link => "link",
            Self::Identity => "identity",
            Self::Vehicle => "vehicle",
            Self::Position => "position",
            Self::Battery => "battery",
            Self::Charge => "charge",
            Self::Fence => "fence",
            Self::Target => "target",
            Self::Input => "input",
        })
    }
}

/// An autopilot.
#[derive(Clone, Debug)]
pub struct Autopilot {
    config: Config,
    now_ns: u64,
    /// When the first event came.
    begun_ns: Option<u64>,
    /// The system number of the autopilot, once it is known.
    system: Option<u8>,
    /// The autopilot's last heartbeat, and when it came.
    heartbeat: Option<(HEARTBEAT_DATA, u64)>,
    craft: Option<Craft>,
    clock: BootClock,
    senses: senses::Senses,
    batteries: Batteries,
    /// The autopilot's own fence.
    fence: fence::Fence,
    starter: Starter,
    wish: Wish,
    /// The last order that was sent, and when.
    sent: Option<(Order, u64)>,
    /// Whether that was to stay.
    held: bool,
    /// Who had control when that was last reported.
    control: Option<Control>,
    /// The place of the last progress toward the target, and when.
    progress: Option<(Place, u64)>,
    /// When each kind of message last came.
    heard_ns: BTreeMap<u32, u64>,
    requested_ns: Option<u64>,
    beaten_ns: Option<u64>,
    alarms: Alarms<Subject>,
    /// Number of the last `STATUSTEXT`.
    texts: u16,
    actions: Vec<Action>,
}

impl Autopilot {
    /// An autopilot of which nothing is known.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            config,
            now_ns: 0,
            begun_ns: None,
            system: config.autopilot_system,
            heartbeat: None,
            craft: None,
            clock: BootClock::default(),
            senses: senses::Senses::default(),
            batteries: Batteries::default(),
            fence: fence::Fence::default(),
            starter: Starter::new(config.engage),
            wish: Wish::Nothing,
            sent: None,
            held: false,
            control: None,
            progress: None,
            heard_ns: BTreeMap::new(),
            requested_ns: None,
            beaten_ns: None,
            alarms: Alarms::new(RECOVERY_NS),
            texts: 0,
            actions: Vec::new(),
        }
    }

    /// Handles an event: the only function that changes the state. The caller passes the time, nanoseconds, which does
    /// not run backward.
    pub fn handle(&mut self, now_ns: u64, event: Event) -> Vec<Action> {
        self.now_ns = self.now_ns.max(now_ns);
        let begun_ns = *self.begun_ns.get_or_insert(self.now_ns);
        match event {
            Event::Received(header, message) => self.receive(header, &message),
            Event::Unreadable(reason) => self.ill(Subject::Input, Level::Warning, reason),
            Event::Go(target) => self.go(target),
            Event::Hold => self.wish = Wish::Hold(None),
            Event::Say(notice) => self.say(&notice),
            Event::Tick => self.tick(begun_ns),
        }
        self.notice_control();
        self.steer();
        std::mem::take(&mut self.actions)
    }

    fn tick(&mut self, begun_ns: u64) {
        if self.beaten_ns.is_none_or(|beaten_ns| self.now_ns - beaten_ns >= SECOND_NS) {
            self.beaten_ns = Some(self.now_ns);
            self.send(orders::heartbeat());
        }
        self.notice_silence(begun_ns);
        if self.is_linked() {
            self.request();
            self.start();
            self.notice_standstill();
        }
        for subject in self.alarms.settle(self.now_ns) {
            self.tell(Level::Ok, &subject.to_string(), "well again".to_owned());
        }
    }

    fn receive(&mut self, header: MavHeader, message: &MavMessage) {
        let system = u8::try_from(header.system_id).unwrap_or(0);
        if header.component_id != orders::AUTOPILOT || system == 0 {
            // Ground stations, cameras, other companions.
            return;
        }
        if let MavMessage::HEARTBEAT(heartbeat) = message {
            self.receive_heartbeat(system, heartbeat);
        } else if self.system == Some(system) && self.heartbeat.is_some() {
            self.sense(message);
        }
    }

    /// The first autopilot with a heartbeat is the one, if the settings name none.
    fn receive_heartbeat(&mut self, system: u8, heartbeat: &HEARTBEAT_DATA) {
        if *self.system.get_or_insert(system) != system {
            let known = self.system.unwrap_or_default();
            if self.config.autopilot_system.is_none() {
                let message = format!(
                    "there are two autopilots, of systems {known} and {system}; name one under mavlink.autopilot_system"
                );
                self.ill(Subject::Identity, Level::Error, message);
            }
            return;
        }
        match Craft::of(heartbeat) {
            Ok(craft) if craft.flies && self.config.altitude_meters.is_none() => {
                self.craft = None;
                let message =
                    "the vehicle is a copter; its height above home is needed: mavlink.altitude_meters";
                self.ill(Subject::Vehicle, Level::Error, message.to_owned());
            }
            Ok(craft) => {
                self.craft = Some(craft);
                self.well(Subject::Vehicle);
            }
            Err(reason) => {
                self.craft = None;
                self.ill(Subject::Vehicle, Level::Error, reason);
            }
        }
        self.heartbeat = Some((heartbeat.clone(), self.now_ns));
        self.well(Subject::Link);
        if !self.clock.has_twin(self.now_ns) {
            self.well(Subject::Identity);
        }
    }

    /// The autopilot has started again: what it was asked for, and where it was, is forgotten.
    fn notice_reboot(&mut self) {
        self.senses = senses::Senses::default();
        self.fence = fence::Fence::default();
        self.heard_ns.clear();
        (self.requested_ns, self.progress, self.sent) = (None, None, None);
        if self.clock.has_twin(self.now_ns) {
            let system = self.system.unwrap_or_default();
            let message = format!("two autopilots have the number of system {system}; allowed is one");
            self.ill(Subject::Identity, Level::Error, message);
            return;
        }
        self.starter.stop();
        let message =
            "the autopilot has started again; the robot goes on once it is armed and guided".to_owned();
        self.tell(Level::Warning, "link", message);
    }

    fn notice_silence(&mut self, begun_ns: u64) {
        if self.is_linked() {
            if self.craft.is_some() && self.senses.silence_ns(self.now_ns) > self.config.link_timeout_ns {
                let name = senses::position_name(self.config.position);
                let message = format!("no valid {name} arrives");
                self.ill(Subject::Position, Level::Error, message);
            }
            return;
        }
        if self.now_ns - begun_ns <= self.config.link_timeout_ns {
            return;
        }
        let message = match (self.heartbeat.is_some(), self.system) {
            (true, _) => "heartbeats have stopped; what the vehicle does is its own failsafe".to_owned(),
            (false, Some(system)) => format!("no heartbeat of system {system} has arrived yet"),
            (false, None) => "no heartbeat of an autopilot has arrived yet".to_owned(),
        };
        self.ill(Subject::Link, Level::Error, message);
    }

    fn is_linked(&self) -> bool {
        let timeout_ns = self.config.link_timeout_ns;
        self.heartbeat.as_ref().is_some_and(|(_, heard_ns)| self.now_ns - heard_ns <= timeout_ns)
    }

    fn mode(&self) -> Option<Mode> {
        let (heartbeat, _) = self.heartbeat.as_ref()?;
        Some(Mode::of(self.craft?, heartbeat))
    }

    fn is_armed(&self) -> bool {
        self.heartbeat.as_ref().is_some_and(|(heartbeat, _)| is_armed(heartbeat))
    }

    fn is_px4(&self) -> bool {
        self.craft.is_some_and(|craft| craft.firmware == Firmware::Px4)
    }

    fn flies(&self) -> bool {
        self.craft.is_some_and(|craft| craft.flies)
    }

    /// The height of targets above home, meters; `None` on the ground.
    fn target_altitude_meters(&self) -> Option<f64> {
        self.config.altitude_meters.filter(|_| self.flies())
    }

    /// Valid and recent.
    fn position(&self) -> Option<&Position> {
        let timeout_ns = self.config.link_timeout_ns;
        self.senses.position().filter(|_| self.senses.silence_ns(self.now_ns) <= timeout_ns)
    }

    fn limits(&self) -> Limits {
        self.config.limits.within(self.fence.limits())
    }

    fn go(&mut self, target: Target) {
        self.progress = None;
        if self.wish != Wish::Go(target) {
            self.wish = Wish::Go(target);
        }
    }

    fn send(&mut self, message: MavMessage) {
        self.actions.push(Action::Send(Box::new(message)));
    }

    fn ill(&mut self, subject: Subject, level: Level, message: String) {
        if self.alarms.raise(self.now_ns, subject, message.clone()) {
            self.tell(level, &subject.to_string(), message);
        }
    }

    fn well(&mut self, subject: Subject) {
        self.alarms.ease(self.now_ns, &subject);
    }

    fn tell(&mut self, level: Level, subject: &str, message: String) {
        let notice = Notice { level, subject: subject.to_owned(), message };
        self.say(&notice);
        self.actions.push(Action::Tell(notice));
    }

    fn say(&mut self, notice: &Notice) {
        // 0 is the number of notices in one part.
        self.texts = self.texts.wrapping_add(1).max(1);
        for text in orders::texts(self.texts, notice) {
            self.send(text);
        }
    }
}

#[cfg(test)]
mod tests;
