//! The recording of a mission in the field, which tolerates a full disk.
//!
//! While the disk is full, records wait in memory. If there are too many, the file ends with the records that were
//! written. Once there is space again, another file beside it begins with all observations so far, so that each file
//! can be shown by itself.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use dragnet_scenario::time::MissionTime;

use crate::RecordingError;
use crate::mission::{Mission, Record};
use crate::record::{Header, Recorder};

/// Time between attempts to begin a further file.
const RETRY: Duration = Duration::from_secs(10);

/// A notice about a recording.
#[derive(Debug)]
pub enum Notice {
    /// The disk is not writable; records wait in memory.
    Waits {
        /// The file.
        path: PathBuf,
        /// The cause.
        reason: String,
    },
    /// All pending records are written.
    Written {
        /// The file.
        path: PathBuf,
    },
    /// A file has ended before the mission, because of this error.
    Ended(RecordingError),
    /// The recording continues in another file.
    GoesOn {
        /// The file.
        path: PathBuf,
        /// Number of observations that it begins with.
        observations: u64,
    },
}

impl fmt::Display for Notice {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waits { path, reason } => {
                let path = path.display();
                write!(
                    formatter,
                    "{path}: {reason}; the mission goes on, and what is to be recorded waits in memory"
                )
            }
            Self::Written { path } => {
                write!(formatter, "{}: written again, nothing is missing", path.display())
            }
            Self::Ended(error) => {
                write!(
                    formatter,
                    "{error}; what was written stays, and a further file begins when there is room"
                )
            }
            Self::GoesOn { path, observations } => {
                let path = path.display();
                write!(
                    formatter,
                    "{path}: the recording goes on here, with all {observations} observations so far"
                )
            }
        }
    }
}

impl Notice {
    /// Whether it reports a persisting error.
    #[must_use]
    pub const fn is_trouble(&self) -> bool {
        matches!(self, Self::Waits { .. } | Self::Ended(_))
    }
}

/// Receives notices about the recording.
pub type Notify = Box<dyn FnMut(&Notice) + Send>;

/// A recording in progress.
pub(crate) struct Recording {
    state: State,
    is_waiting: bool,
    notify: Option<Notify>,
}

enum State {
    Writing(Box<Recorder>),
    /// The last file failed.
    Interrupted {
        path: PathBuf,
        header: Box<Header>,
        error: RecordingError,
        next_try: MissionTime,
    },
    /// Placeholder during a transition.
    Moving,
}

impl Recording {
    pub(crate) fn new(recorder: Recorder) -> Self {
        Self { state: State::Writing(Box::new(recorder)), is_waiting: false, notify: None }
    }

    pub(crate) fn notify(&mut self, notify: Notify) {
        self.notify = Some(notify);
    }

    /// Why recording fails now, if it does.
    pub(crate) const fn failure(&self) -> Option<&RecordingError> {
        match &self.state {
            State::Interrupted { error, .. } => Some(error),
            State::Writing(_) | State::Moving => None,
        }
    }

    pub(crate) fn record(&mut self, now: MissionTime, record: &Record) {
        if let State::Writing(recorder) = &mut self.state
            && let Err(error) = recorder.record(now, record)
        {
            self.interrupt(now, error);
        }
    }

    /// Flushes if it is due, and checks the disk.
    pub(crate) fn tick(&mut self, now: MissionTime, mission: &Mission) {
        match &mut self.state {
            State::Writing(recorder) => match recorder.tick(now) {
                Ok(()) => self.check_disk(),
                Err(error) => self.interrupt(now, error),
            },
            State::Interrupted { next_try, .. } if now >= *next_try => self.go_on(now, mission),
            State::Interrupted { .. } | State::Moving => {}
        }
    }

    /// Sends a notice when the disk becomes unwritable, and when it is writable again.
    fn check_disk(&mut self) {
        let State::Writing(recorder) = &self.state else { return };
        let trouble = recorder.trouble();
        if trouble.is_some() == self.is_waiting {
            return;
        }
        self.is_waiting = trouble.is_some();
        let path = recorder.path().to_owned();
        self.tell(&match trouble {
            Some(reason) => Notice::Waits { path, reason },
            None => Notice::Written { path },
        });
    }

    fn interrupt(&mut self, now: MissionTime, error: RecordingError) {
        let reported = Notice::Ended(error);
        self.tell(&reported);
        let (Notice::Ended(error), State::Writing(recorder)) =
            (reported, std::mem::replace(&mut self.state, State::Moving))
        else {
            return;
        };
        let (path, header) = (recorder.path().to_owned(), Box::new(recorder.give_up()));
        self.state = State::Interrupted { path, header, error, next_try: now + RETRY };
    }

    /// Begins a further file, if there is space for its beginning.
    fn go_on(&mut self, now: MissionTime, mission: &Mission) {
        let State::Interrupted { path, header, error, .. } =
            std::mem::replace(&mut self.state, State::Moving)
        else {
            return;
        };
        match begun(&path, (*header).clone(), now, mission) {
            Some(recorder) => {
                let observations = mission.replica().log().len();
                self.tell(&Notice::GoesOn { path: recorder.path().to_owned(), observations });
                self.is_waiting = false;
                self.state = State::Writing(Box::new(recorder));
            }
            None => self.state = State::Interrupted { path, header, error, next_try: now + RETRY },
        }
    }

    fn tell(&mut self, notice: &Notice) {
        if let Some(notify) = &mut self.notify {
            notify(notice);
        }
    }

    /// Ends the recording, if necessary in a further file.
    pub(crate) fn finish(
        mut self,
        now: MissionTime,
        mission: &Mission,
        summary: std::collections::BTreeMap<String, String>,
    ) -> Result<(), RecordingError> {
        if self.failure().is_some() {
            self.go_on(now, mission);
        }
        match self.state {
            State::Writing(recorder) => recorder.finish(summary),
            State::Interrupted { error, .. } => Err(error),
            State::Moving => Ok(()),
        }
    }
}

/// A further file with all that is known; `None`, and no file, if it cannot be written.
fn begun(path: &Path, header: Header, now: MissionTime, mission: &Mission) -> Option<Recorder> {
    let mut recorder = Recorder::create_beside(path, header).ok()?;
    let log = mission.replica().log();
    let versions = log.versions();
    let observations = versions.iter().flat_map(|version| log.since(version.origin, 0));
    let records = observations.map(|observation| Record::Observation(observation.clone()));
    let stand =
        [Record::Status(mission.status(now)), Record::Belief(std::sync::Arc::new(mission.shown_belief()))];
    let has_verdicts = !mission.verdicts().is_empty();
    let verdicts = has_verdicts.then(|| Record::Verdicts(mission.verdict_report(now)));
    let orders = Record::Orders(mission.order_report(now));
    let orders = (!mission.orders().is_empty()).then_some(orders);
    let zones = (!mission.zones().is_empty()).then(|| Record::Zones(mission.zone_report(now)));
    let marks = (!mission.marks().is_empty()).then(|| Record::Marks(mission.mark_report(now)));
    let pictures = mission.pictures().map(|picture| Record::Picture(std::sync::Arc::clone(picture)));
    let written = records
        .chain(verdicts)
        .chain(orders)
        .chain(zones)
        .chain(marks)
        .chain(stand)
        .chain(pictures)
        .try_for_each(|record| recorder.record(now, &record));
    if written.and_then(|()| recorder.flush()).is_ok() && recorder.trouble().is_none() {
        return Some(recorder);
    }
    let path = recorder.path().to_owned();
    drop(recorder);
    // It holds nothing new.
    let _ = std::fs::remove_file(path);
    None
}
