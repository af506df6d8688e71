//! What is wrong with a vehicle's senses and ways, told when it begins, when it changes and when it is over: by
//! [`super::alarms`], so that neither the log nor the vehicle starts and stops with every message.

use std::fmt;

use super::alarms::Alarms;
use crate::settings::{FaultResponse, OnFault};

/// What is told of the pose where none comes that could be refused.
pub const NO_POSE: &str = "no pose comes";

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// It is well again.
    Ok,
    /// It goes on, with less.
    Warning,
    /// Something is missing without which nothing is seen, or nobody knows where.
    Error,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How bad it is.
    pub level: Level,
    /// What it is about: `pose`, `clock`, `map`, `path`, `ground`, `camera NAME`, `silence of NAME`.
    pub name: String,
    /// What happened, in a sentence.
    pub message: String,
    /// The numbers behind it, each with its name, the unit last.
    pub numbers: Vec<(&'static str, f64)>,
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.name, self.message)
    }
}

/// What can be ill.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Subject {
    Clock,
    Pose,
    Ground,
    Map,
    Path,
    /// A camera's frames.
    Camera(String),
    /// A camera that gives none that can be used.
    Silence(String),
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fault {
    /// In a word: as long as it is the same, it is not told again.
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
            Self::Camera(_) | Self::Ground | Self::Path => Level::Warning,
            Self::Clock | Self::Pose | Self::Map | Self::Silence(_) => Level::Error,
        }
    }

    /// What to do while it is ill; single bad frames and bad ground forbid nothing.
    const fn response(&self, on_fault: &OnFault) -> FaultResponse {
        match self {
            Self::Clock => on_fault.clock,
            Self::Pose => on_fault.pose,
            Self::Map => on_fault.map,
            Self::Silence(_) => on_fault.camera,
            // The way is given up where it is found to be none.
            Self::Camera(_) | Self::Ground | Self::Path => FaultResponse::Continue,
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
        }
    }
}

/// All that is ill.
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

    /// Nothing is wrong with it now; it is well again once that has lasted.
    pub(super) fn well(&mut self, now_ns: u64, subject: &Subject) {
        self.0.ease(now_ns, subject);
    }

    /// It has been well for long enough, as whoever says so knows.
    pub(super) fn cured(&mut self, subject: &Subject) -> Option<Diagnostic> {
        self.0.end(subject).then(|| well_again(subject))
    }

    /// What is well again.
    pub(super) fn settle(&mut self, now_ns: u64) -> Vec<Diagnostic> {
        self.0.settle(now_ns).iter().map(well_again).collect()
    }

    /// Whether something is wrong with it right now.
    pub(super) fn is_bad(&self, subject: &Subject) -> bool {
        self.0.is_bad(subject)
    }

    /// Whether something is ill for which the vehicle is to stand.
    pub(super) fn forbid(&self, on_fault: &OnFault) -> bool {
        self.0.standing().any(|subject| subject.response(on_fault) == FaultResponse::Stop)
    }
}

fn well_again(subject: &Subject) -> Diagnostic {
    let message = "well again".to_owned();
    Diagnostic { level: Level::Ok, name: subject.to_string(), message, numbers: Vec::new() }
}
