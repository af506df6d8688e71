//! Prints the robots' decisions and finds as they happen.

use std::io;

use dragnet_coordinator::finds::of_subject;
use dragnet_proto::message::Activity;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Places, Scenario};
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_sim::simulation::StepContext;
use indicatif::ProgressBar;

use crate::terminal::{self, counted};

/// Observes a search, and prints a line for each decision and each find.
pub(super) struct Narrator {
    places: Places,
    /// Whether the number of objects is known.
    is_of_subjects: bool,
    bar: ProgressBar,
    watched: Watched,
    /// Cells that were found at some time, shape `[cells]`.
    was_found: Vec<bool>,
    /// Why printing stopped.
    silenced: Option<io::Error>,
}

/// Tracks and finds of a search.
#[derive(Default)]
pub(super) struct Watched {
    /// Cells that each robot was in, in order; robots by number.
    pub(super) tracks: Vec<Vec<Cell>>,
    /// The first find of each cell, in order.
    pub(super) finds: Vec<Find>,
}

/// The first time that a cell was found.
pub(super) struct Find {
    pub(super) cell: Cell,
    pub(super) robot: RobotId,
    pub(super) time: MissionTime,
}

impl Narrator {
    pub(super) fn new(scenario: &Scenario, bar: ProgressBar) -> Self {
        let tracks = vec![Vec::new(); scenario.robots().len()];
        Self {
            places: scenario.places(),
            is_of_subjects: scenario.subjects().is_some(),
            bar,
            watched: Watched { tracks, finds: Vec::new() },
            was_found: vec![false; scenario.terrain().grid().cell_count()],
            silenced: None,
        }
    }

    /// Handles a simulated event.
    pub(super) fn see(&mut self, now: MissionTime, scene: &StepContext) {
        match *scene {
            StepContext::Departs { robot, ref route, activity } => {
                self.tell(now, robot, &self.plan(route, activity));
            }
            StepContext::Arrives { robot, cell, farthest_cells } => {
                self.watched.tracks[robot.index()].push(cell);
                self.bar.set_position(steps(farthest_cells));
            }
            StepContext::Finds { robot, cell, probability } => self.find(now, robot, cell, probability),
        }
    }

    /// Ends the output. Fails if a line could not be printed.
    pub(super) fn finish(self) -> io::Result<Watched> {
        self.bar.finish_and_clear();
        self.silenced.map_or(Ok(self.watched), Err)
    }

    fn plan(&self, route: &[Cell], activity: Option<Activity>) -> String {
        match route.last() {
            Some(&waypoint) => {
                let goes = match activity {
                    Some(Activity::Returning) => "returns to its base, to",
                    Some(Activity::Sent) => "is sent to",
                    Some(Activity::Leaving) => "leaves a no-go zone, to",
                    Some(Activity::GivingWay) => "makes way for its teammates, to",
                    _ => "goes to",
                };
                format!("{goes} {}, {}", self.places.cell(waypoint), counted(route.len(), "cell"))
            }
            None => activity.map_or("stays".to_owned(), |activity| {
                format!(
                    "{}: {}",
                    match activity {
                        Activity::Waiting => "waits",
                        Activity::Holding => "holds",
                        Activity::Paused => "pauses",
                        activity if activity.is_rest() => "rests",
                        _ => "stays",
                    },
                    activity.reason()
                )
            }),
        }
    }

    fn find(&mut self, time: MissionTime, robot: RobotId, cell: Cell, probability: f64) {
        if std::mem::replace(&mut self.was_found[cell.index()], true) {
            return;
        }
        self.watched.finds.push(Find { cell, robot, time });
        self.bar.set_message(format!("{} found", self.watched.finds.len()));
        let place = self.places.on_earth(cell);
        let what = if self.is_of_subjects {
            of_subject(&place, probability, None)
        } else {
            format!("finds an object at {place}")
        };
        self.tell(time, robot, &what);
    }

    fn tell(&mut self, now: MissionTime, robot: RobotId, what: &str) {
        if self.silenced.is_none() {
            let line = format!("{:>9.1} s  robot {robot}  {what}\n", now.as_seconds());
            self.silenced = self.bar.suspend(|| terminal::print(&line)).err();
        }
    }
}

/// Steps of a progress bar.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of cells, at least 0")]
pub(super) fn steps(cells: f64) -> u64 {
    cells.ceil() as u64
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_robot_rests_only_once_its_search_is_over() {
        let text = "name = 'lane'\nmap = { shape = 'all_traversable', rows = 1, columns = 4 }\nobjects.count = 1\n\
                    robots.count = 1\nsensor.radius = 2\nmission.budget_seconds = 900.0\n";
        let scenario = Scenario::from_text(Path::new("lane.toml"), text.to_owned()).unwrap();
        let narrator = Narrator::new(&scenario, ProgressBar::hidden());
        let told = |activity| narrator.plan(&[], activity);
        assert_eq!(told(Some(Activity::Cleared)), "rests: too little is left for it to find");
        assert_eq!(told(Some(Activity::Paused)), "pauses: the operator has paused it");
        assert_eq!(told(Some(Activity::Holding)), "holds: it waits for the operator's next order");
        assert_eq!(
            told(Some(Activity::Waiting)),
            "waits: its teammates are to observe all that is left, or to pass first"
        );
        assert_eq!(told(None), "stays");
    }
}
