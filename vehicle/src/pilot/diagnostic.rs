//! Faults of a vehicle's sensors and paths, reported when they begin, change and end: by [`super::alarms`], so that
//! neither the log nor the vehicle alternates with every message.

use std::fmt;

use super::Interlock;
use super::alarms::Alarms;
use crate::settings::{FaultResponse, OnFault};

/// The message when no pose arrives, neither valid nor invalid.
pub const NO_POSE: &str = "no pose arrives";

/// The severity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The fault is over.
    Ok,
    /// It works with restrictions.
    Warning,
    /// Required input is missing, so that nothing is observed, or the position is unknown.
    Error,
}

/// A diagnostic message.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The severity.
    pub level: Level,
    /// The subject: `pose`, `clock`, `map`, `path`, `ground`, `camera NAME`, `silence of NAME`,
    /// `false alarms of NAME`, `lens of NAME`, `objects`, `emergency stop`, `battery`.
    pub name: String,
    /// What happened, in a sentence.
    pub message: String,
    /// Related numbers, each with its name, the unit last.
    pub numbers: Vec<(&'static str, f64)>,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.name, self.message)
    }
}

/// The subject of a fault.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Subject {
    Clock,
    Pose,
    Ground,
    Map,
    Path,
    /// A camera's frames.
    Camera(String),
    /// A camera without valid frames.
    Silence(String),
    /// A camera with more false alarms than its settings say.
    FalseAlarms(String),
    /// A camera with detections that turn with it.
    Lens(String),
    Interlock(Interlock),
}

/// A fault.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    /// In a word: the same kind is not reported again.
    kind: &'static str,
    message: String,
    numbers: Vec<(&'static str, f64)>,
}

impl Fault {
    pub(super) fn new(kind: &'static str, message: &str, numbers: &[(&'static str, f64)]) -> Self {
        Self { kind, message: message.to_owned(), numbers: numbers.to_vec() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)
    }
}

impl Subject {
    const fn level(&self) -> Level {
        match self {
            Self::Camera(_) | Self::FalseAlarms(_) | Self::Lens(_) | Self::Ground | Self::Path => {
                Level::Warning
            }
            Self::Clock | Self::Pose | Self::Map | Self::Silence(_) | Self::Interlock(_) => Level::Error,
        }
    }

    /// The response during the fault; single bad frames and bad ground do not stop the vehicle.
    const fn response(&self, on_fault: &OnFault) -> FaultResponse {
        match self {
            Self::Clock => on_fault.clock,
            Self::Pose => on_fault.pose,
            Self::Map => on_fault.map,
            Self::Silence(_) => on_fault.camera,
            // It is reported only if it is to stop the vehicle.
            Self::Interlock(_) => FaultResponse::Stop,
            // A path is given up where it turns out to be impossible.
            Self::Camera(_) | Self::FalseAlarms(_) | Self::Lens(_) | Self::Ground | Self::Path => {
                FaultResponse::Continue
            }
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clock => formatter.write_str("clock"),
            Self::Pose => formatter.write_str("pose"),
            Self::Ground => formatter.write_str("ground"),
            Self::Map => formatter.write_str("map"),
            Self::Path => formatter.write_str("path"),
            Self::Camera(name) => write!(formatter, "camera {name}"),
            Self::Silence(name) => write!(formatter, "silence of {name}"),
            Self::FalseAlarms(name) => write!(formatter, "false alarms of {name}"),
            Self::Lens(name) => write!(formatter, "lens of {name}"),
            Self::Interlock(Interlock::EmergencyStop) => formatter.write_str("emergency stop"),
            Self::Interlock(Interlock::Battery) => formatter.write_str("battery"),
        }
    }
}

/// The faults of all subjects.
#[derive(Clone, Debug)]
pub(super) struct Conditions(Alarms<Subject>);

impl Conditions {
    pub(super) const fn new(recovery_ns: u64) -> Self {
        Self(Alarms::new(recovery_ns))
    }

    pub(super) fn ill(&mut self, now_ns: u64, subject: Subject, fault: Fault) -> Option<Diagnostic> {
        let (level, name) = (subject.level(), subject.to_string());
        let is_news = self.0.raise(now_ns, subject, fault.kind);
        is_news.then_some(Diagnostic { level, name, message: fault.message, numbers: fault.numbers })
    }

    /// The subject has no fault now; the fault ends once that has lasted.
    pub(super) fn well(&mut self, now_ns: u64, subject: &Subject) {
        self.0.ease(now_ns, subject);
    }

    /// The subject is known to have been without fault for long enough.
    pub(super) fn cured(&mut self, subject: &Subject) -> Option<Diagnostic> {
        self.0.end(subject).then(|| well_again(subject))
    }

    /// The faults that have ended.
    pub(super) fn settle(&mut self, now_ns: u64) -> Vec<Diagnostic> {
        self.0.settle(now_ns).iter().map(well_again).collect()
    }

    /// Whether a subject has a fault now.
    pub(super) fn is_bad(&self, subject: &Subject) -> bool {
        self.0.is_bad(subject)
    }

    /// Whether a fault requires the vehicle to stand.
    pub(super) fn forbid(&self, on_fault: &OnFault) -> bool {
        self.0.standing().any(|subject| subject.response(on_fault) == FaultResponse::Stop)
    }
}

/// Something is detected where nothing is searched for, at meters east and north of the map's corner: no find, but news
/// for people.
pub(super) fn outside(x_meters: f64, y_meters: f64) -> Diagnostic {
    let message = format!(
        "an object outside of the search area: {x_meters:.1} m east and {y_meters:.1} m north of the map's corner"
    );
    let numbers = vec![("x_meters", x_meters), ("y_meters", y_meters)];
    Diagnostic { level: Level::Warning, name: "objects".to_owned(), message, numbers }
}

fn well_again(subject: &Subject) -> Diagnostic {
    let message = "well again".to_owned();
    Diagnostic { level: Level::Ok, name: subject.to_string(), message, numbers: Vec::new() }
}
