//! `dragnet replay`: shows a recorded mission.

use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use dragnet_coordinator::Ending;
use dragnet_coordinator::finds::of_subject;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::news::{self, Given};
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::track::Tracks;
use dragnet_live::page::Page;
use dragnet_live::replay;
use dragnet_live::view::{About, View};
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::marks::{Marked, Marks};
use dragnet_proto::message::{MarkReport, MissionStatus, OrderReport, VerdictReport, ZoneReport};
use dragnet_proto::newest::Numbered;
use dragnet_proto::orders::{NumberedOrder, RobotOrder, RobotOrders};
use dragnet_proto::verdict::{Verdict, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::Places;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::measures::Truth;
use dragnet_search::observation::{RobotId, Source};
use dragnet_search::reach::Reach;

use super::{Failure, complain, live};
use crate::terminal::map::Picture;
use crate::terminal::{self, counted};

/// Replay a recorded mission.
///
/// Prints each decision and each declared object, then the map with the belief at the end. With --live the mission is
/// served as a page instead, with a time slider. All intact parts of a truncated or damaged recording are shown.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  dragnet replay ice_cream_cone-0.mcap\n  dragnet replay ice_cream_cone-0.mcap --live"
)]
pub(crate) struct Arguments {
    /// The recording (MCAP)
    file: PathBuf,
    /// Serve the mission as a page until Ctrl-C, at this address: IP:PORT, IP or PORT [default without ADDRESS:
    /// 127.0.0.1 and any free port]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = live::ANYWHERE, value_parser = live::parse_address)]
    live: Option<SocketAddr>,
    /// Map to show on the page under the search: a PMTiles file with raster tiles
    #[arg(long, value_name = "FILE", requires = "live")]
    basemap: Option<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let playback = Playback::read(&arguments.file).map_err(Failure::input)?;
    if playback.ending != Ending::Complete {
        let ending = &playback.ending;
        let what = format!("is {ending}; what is whole of it is shown");
        complain("warning", &format!("{}: {what}", arguments.file.display()));
    }
    if let Some(listen) = arguments.live {
        let page = Page::of_recording(&live::settings(listen, arguments.basemap.as_deref()), playback)?;
        live::announce(page, live::LIVE_PAGE).stay();
        return Ok(());
    }
    let mut teller = Teller::new(Arc::new(replay::about(&playback)));
    for (time, record) in &playback.records {
        for line in teller.take(*time, record) {
            terminal::print(&format!("{:>9.1} s  {line}\n", time.as_seconds()))?;
        }
    }
    Ok(terminal::print(&teller.end(playback.searched_until()))?)
}

/// Prints a mission from its records.
struct Teller {
    view: View,
    places: Places,
    tracks: Tracks,
    declared: BTreeSet<Cell>,
    alive: BTreeSet<RobotId>,
    /// The order to all robots, with its number.
    order: (u64, TeamOrder),
    /// Cells that the operator has added to the search area.
    added: BTreeSet<Cell>,
    verdicts: Verdicts,
    orders: RobotOrders,
    zones: Zones,
    marks: Marks,
    /// Cells that each robot was in; robots by number.
    paths: Vec<Vec<Cell>>,
}

impl Teller {
    fn new(about: Arc<About>) -> Self {
        Self {
            paths: vec![Vec::new(); about.team.len()],
            places: Places::new(&about.terrain, about.earth.as_ref().map(|earth| &earth.frame)),
            view: View::new(about),
            tracks: Tracks::default(),
            declared: BTreeSet::new(),
            alive: BTreeSet::new(),
            order: (0, TeamOrder::Search),
            added: BTreeSet::new(),
            verdicts: Verdicts::default(),
            orders: RobotOrders::default(),
            zones: Zones::default(),
            marks: Marks::default(),
        }
    }

    /// Handles a record; returns the lines to print.
    fn take(&mut self, time: MissionTime, record: &Record) -> Vec<String> {
        self.view.take(time, record);
        match record {
            Record::Intent(intent) if self.tracks.plans(intent) => {
                let what = match intent.path.last() {
                    Some(&waypoint) => {
                        let path = counted(intent.path.len(), "cell");
                        format!("goes to {}, {path}", self.places.cell(waypoint))
                    }
                    None => "stays".to_owned(),
                };
                vec![format!("robot {}  {what}", intent.robot)]
            }
            Record::Observation(observation) => {
                let Source::Robot(robot) = observation.origin.source else {
                    return vec![format!("a person marks {}", self.places.on_earth(observation.from))];
                };
                if let Some(way) = self.paths.get_mut(robot.index()) {
                    way.push(observation.from);
                }
                Vec::new()
            }
            Record::Status(status) => self.stand(status),
            Record::Verdicts(report) if report.from == Participant::Coordinator => self.judge(report),
            Record::Orders(report) if report.from == Participant::Coordinator => self.direct(report),
            Record::Zones(report) if report.from == Participant::Coordinator => self.close(report),
            Record::Picture(picture) => {
                let (place, source) = (self.object(picture.facts.cell), picture.facts.source());
                vec![format!("a picture of the object at {place} arrives, from {source}")]
            }
            Record::Marks(report) if report.from == Participant::Coordinator => self.mark(report),
            _ => Vec::new(),
        }
    }

    /// Where the object of a cell is.
    fn object(&self, cell: Cell) -> String {
        self.places.object(cell, self.view.fold().position(cell))
    }

    fn judge(&mut self, report: &VerdictReport) -> Vec<String> {
        let before = std::mem::replace(&mut self.verdicts, report.verdicts.clone());
        let line = |(cell, verdict, given): (Cell, Verdict, Given)| {
            let find = format!("the find at {}", self.object(cell));
            let what = match verdict.decision.word() {
                Some(word) => format!("the operator has {word} {find}"),
                None => format!("the operator's decision about {find} is undone"),
            };
            dated(given, &what)
        };
        news::verdicts(&before, &report.verdicts, MissionTime(report.time_ns)).filter_map(line).collect()
    }

    fn direct(&mut self, report: &OrderReport) -> Vec<String> {
        let before = std::mem::replace(&mut self.orders, report.orders.clone());
        let line = |(robot, NumberedOrder { value: order, .. }, given)| {
            let what = match order {
                RobotOrder::Search => format!("resumes robot {robot}"),
                RobotOrder::Go(there) => format!("sends robot {robot} to {}", self.places.on_earth(there)),
                RobotOrder::Return => format!("calls robot {robot} back to its base"),
                RobotOrder::Pause => format!("pauses robot {robot}"),
            };
            dated(given, &format!("the operator {what}"))
        };
        news::to_robots(&before, &report.orders, MissionTime(report.time_ns)).filter_map(line).collect()
    }

    fn close(&mut self, report: &ZoneReport) -> Vec<String> {
        let before = std::mem::replace(&mut self.zones, report.zones.clone());
        let line = |(zone, cells, given): (Numbered<Zone>, BTreeSet<Cell>, Given)| {
            let some = self.places.some(&cells);
            dated(given, &format!("by the operator's order {some} {}", zone.value.said_of(cells.len())))
        };
        news::zones(&before, &report.zones, MissionTime(report.time_ns)).filter_map(line).collect()
    }

    fn mark(&mut self, report: &MarkReport) -> Vec<String> {
        let before = std::mem::replace(&mut self.marks, report.marks.clone());
        let line = |(_, entry, given): (_, Numbered<Arc<Marked>>, Given)| {
            let done = if entry.value.is_withdrawn { "withdraws" } else { "marks" };
            dated(given, &format!("the operator {done} {}", entry.value.said(&self.places)))
        };
        news::marks(&before, &report.marks, MissionTime(report.time_ns)).filter_map(line).collect()
    }

    fn direct_all(&mut self, status: &MissionStatus) -> Option<String> {
        let before = std::mem::replace(&mut self.order, status.directive.numbered_order());
        let what = match status.directive.order {
            TeamOrder::Search => "resumes the search",
            TeamOrder::Pause => "pauses the search",
            TeamOrder::Return => "calls the robots back to their bases",
            TeamOrder::End => "ends the mission, and calls the robots back to their bases",
        };
        let given = news::to_all(before, &status.directive, MissionTime(status.time_ns))?;
        dated(given, &format!("the operator {what}"))
    }

    fn stand(&mut self, status: &MissionStatus) -> Vec<String> {
        let mut lines: Vec<String> = self.direct_all(status).into_iter().collect();
        lines.extend(news::added(&mut self.added, &status.directive, &self.places));
        let alive: BTreeSet<RobotId> = status.alive.iter().copied().collect();
        lines.extend(self.alive.difference(&alive).map(|robot| format!("robot {robot}  is lost")));
        self.alive = alive;
        let declared: BTreeSet<Cell> = status.declared.iter().map(|object| object.cell).collect();
        let is_of_subjects = self.view.about().subjects.is_some();
        lines.extend(news::declared(&self.declared, status).filter_map(|(object, given)| {
            let (place, probability) = (self.object(object.cell), object.probability);
            let what = if is_of_subjects {
                format!("declared: {}", of_subject(&place, probability, self.verdicts.decision(object.cell)))
            } else {
                format!("an object is declared at {place}, probability {probability:.4}")
            };
            dated(given, &what)
        }));
        let withdrawn = self.declared.difference(&declared);
        lines.extend(withdrawn.map(|&cell| format!("the object at {} is withdrawn", self.object(cell))));
        self.declared = declared;
        lines
    }

    /// The map at the end, and the declared objects of a search of this duration.
    fn end(&self, searched: MissionTime) -> String {
        let about = self.view.about();
        let known = about.objects.clone();
        let objects = known.clone().unwrap_or_else(|| self.declared.iter().copied().collect());
        let terrain = self.view.terrain();
        let everywhere = Reach::unknown(terrain.grid());
        let picture = Picture {
            terrain,
            reach: self.view.reach().unwrap_or(&everywhere),
            belief: self.view.belief(),
            truth: &Truth::new(terrain, objects),
            detection_threshold: about.detection_threshold,
            tracks: &self.paths,
        };
        let declared = counted(self.declared.len(), "object");
        let of = known.map_or_else(String::new, |objects| format!(" of {}", objects.len()));
        let (observations, marks) = self.view.counts();
        format!(
            "\n{}\n{} after {:.1} s: {declared} declared{of}, {} and {}, {:.1} nats of entropy left\n{}",
            picture.draw(terminal::columns()),
            about.name,
            searched.as_seconds(),
            counted(usize::try_from(observations).unwrap_or(usize::MAX), "observation"),
            counted(usize::try_from(marks).unwrap_or(usize::MAX), "mark"),
            self.view.entropy_nats(),
            self.subject(),
        )
    }

    /// Where the subjects are at the end, and what their finds are, as lines.
    fn subject(&self) -> String {
        let (Some(standing), Some(subject)) = (self.view.standing(), self.view.subject()) else {
            return String::new();
        };
        let find = |&cell: &Cell| {
            let operator = self.verdicts.decision(cell);
            format!("{}\n", of_subject(&self.object(cell), subject.probability(cell), operator))
        };
        format!("the {}: {standing}\n{}", standing.noun(), self.declared.iter().map(find).collect::<String>())
    }
}

/// An order or verdict with its time, if that is not now; none if it was told already.
fn dated(given: Given, what: &str) -> Option<String> {
    match given {
        Given::Now => Some(what.to_owned()),
        Given::Before(time) => Some(format!("before, at {:.1} s: {what}", time.as_seconds())),
        Given::Anew(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
    use dragnet_proto::directive::Directive;
    use dragnet_scenario::Scenario;

    use super::*;

    #[test]
    fn each_order_to_all_is_told_and_one_that_robots_knew_before_with_its_time() {
        let text = "name = 'lane'\nmap = { shape = 'all_traversable', rows = 1, columns = 4 }\nobjects.count = 1\n\
                    robots.count = 1\nsensor.radius = 2\nmission.budget_seconds = 900.0\n";
        let scenario = Scenario::from_text(Path::new("lane.toml"), text.to_owned()).unwrap();
        let mission = Mission::new(CoordinatorConfig::of(&scenario));
        let mut teller = Teller::new(Arc::new(About::of(&scenario, None)));
        let mut told = |now: u64, number: u64, order| {
            let [now, number] = [now, number].map(|seconds| seconds * 1_000_000_000);
            let directive = Directive { number, order, ..Directive::default() };
            let status = MissionStatus { directive, ..mission.status(MissionTime(now)) };
            teller.take(MissionTime(now), &Record::Status(status))
        };
        assert_eq!(told(50, 0, TeamOrder::Search), [""; 0]);
        assert_eq!(told(60, 50, TeamOrder::Pause), ["before, at 50.0 s: the operator pauses the search"]);
        assert_eq!(
            told(70, 70, TeamOrder::Pause),
            ["the operator pauses the search"],
            "again: one robot was not"
        );
        assert_eq!(told(71, 70, TeamOrder::Pause), [""; 0]);
        assert_eq!(told(80, 80, TeamOrder::Search), ["the operator resumes the search"]);
    }
}
