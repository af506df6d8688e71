//! The view of a recording at any time.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_coordinator::mission::Record;
use dragnet_coordinator::playback::Playback;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use crate::view::{About, View};

/// The facts about a recorded mission.
#[must_use]
pub fn about(playback: &Playback) -> About {
    let fact = |name: &str| playback.run.get(name).map(String::as_str);
    let robots = fact("robots").and_then(|count| count.parse().ok()).unwrap_or(0);
    About {
        name: fact("scenario").unwrap_or("recording").to_owned(),
        terrain: Arc::clone(&playback.terrain),
        prior: playback.prior.clone(),
        sights: playback.sights().unwrap_or_default(),
        sensors: playback.sensors().unwrap_or_default(),
        speeds_meters_per_second: playback.of_robots("speed_meters_per_second").unwrap_or_default(),
        subjects: playback.subjects(),
        detection_threshold: playback.detection_threshold(),
        team: RobotId::first(robots).collect(),
        objects: objects(playback),
        earth: playback.earth.clone(),
    }
}

/// The objects, if the recording contains them.
fn objects(playback: &Playback) -> Option<Vec<Cell>> {
    let cells = playback.summary.get("object_cells")?;
    let grid = playback.terrain.grid();
    let numbers = cells.split(',').filter(|number| !number.is_empty());
    numbers.map(|number| number.parse().ok().and_then(|number| grid.cell_numbered(number))).collect()
}

/// A view of a recording that can be moved to any time.
#[derive(Clone, Debug)]
pub struct Replay {
    playback: Arc<Playback>,
    about: Arc<About>,
    view: View,
    /// Number of records that the view has applied.
    taken: usize,
}

impl Replay {
    /// A recording at its start.
    #[must_use]
    pub fn new(playback: Arc<Playback>) -> Self {
        let about = Arc::new(about(&playback));
        Self { view: View::new(Arc::clone(&about)), about, playback, taken: 0 }
    }

    /// Moves the view to a mission time, forward or backward.
    pub fn seek(&mut self, time: MissionTime) {
        if time < self.view.now() {
            self.view = View::new(Arc::clone(&self.about));
            self.taken = 0;
        }
        while let Some((due, record)) = self.playback.records.get(self.taken)
            && *due <= time
        {
            self.view.take(*due, record);
            self.taken += 1;
        }
        self.view.pass(time);
    }

    /// The view at that time.
    #[must_use]
    pub const fn view(&self) -> &View {
        &self.view
    }

    /// The times at which objects were declared, seconds, ascending: those of the records that show them.
    #[must_use]
    pub fn find_seconds(&self) -> Vec<f64> {
        let mut declared = BTreeSet::new();
        let mut seconds = Vec::new();
        for (time, record) in &self.playback.records {
            let Record::Status(status) = record else { continue };
            let now: BTreeSet<Cell> = status.declared.iter().map(|object| object.cell).collect();
            if !now.is_subset(&declared) {
                seconds.push(time.as_seconds());
            }
            declared = now;
        }
        seconds
    }

    /// The end of the recording.
    #[must_use]
    pub fn end(&self) -> MissionTime {
        self.playback.end()
    }
}
