//! Checks of the robot's own computer: disk space for its journal, and decision time.

use std::path::Path;
use std::time::{Duration, Instant};

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::state_machine::{Event, StateMachine};
use dragnet_proto::validation::SPEED_TOLERANCE;
use dragnet_ros2::input::Image;
use dragnet_scenario::Class;
use dragnet_scenario::time::MissionTime;
use dragnet_search::utility::UtilityTable;
use dragnet_vehicle::camera::CameraSettings;

use super::Finding;
use crate::clock::Clock;
use crate::config::Body;
use crate::journal::{self, Prospect, Subject};
use crate::vehicle::detector::Make;

/// The journal of a robot of a large team after a long day, with space for a log.
const ROOM_BYTES: u64 = 1 << 30;
/// Number of timed decisions, spread over the map.
const DECISIONS: usize = 20;

/// Checks the disk space for a journal, and the state that the robot would restore from it; returns the clock by which
/// it would continue, if it has one.
pub(super) fn journal(
    path: &Path,
    subject: Subject<'_>,
    runs_here: bool,
    real_time_factor: f64,
) -> (Vec<Finding>, Option<Clock>) {
    let content = if runs_here {
        // While it runs, its time is in its messages.
        Ok(("; its robot runs, and writes it".to_owned(), None))
    } else {
        remembered(path, subject, real_time_factor)
    };
    match (room(path), content) {
        (Ok(free), Ok((note, clock))) => (
            vec![Finding::pass("journal", format!("{}; {} MB free{note}", path.display(), free >> 20))],
            clock,
        ),
        (room, content) => {
            let clock = content.as_ref().ok().and_then(|(_, clock)| *clock);
            (room.err().into_iter().chain(content.err()).collect(), clock)
        }
    }
}

/// Free bytes at the journal's path.
fn room(path: &Path) -> Result<u64, Finding> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let at = folder.display();
    if let Err(error) = tempfile::tempfile_in(folder) {
        let advice = "make the folder, and let the robot's user write there; or name another under `journal`";
        return Err(Finding::fail("journal", format!("nothing can be written in {at}: {error}"), advice));
    }
    match rustix::fs::statvfs(folder).map(|it| it.f_bavail.saturating_mul(it.f_frsize)) {
        Err(error) => Err(Finding::fail("journal", format!("{at}: {error}"), "")),
        Ok(free) if free < ROOM_BYTES => {
            let found = format!("{} MB are free in {at}", free >> 20);
            Err(Finding::fail("journal", found, format!("make room: {} MB last for long", ROOM_BYTES >> 20)))
        }
        Ok(free) => Ok(free),
    }
}

/// The state that a robot would restore now, in words, and the clock by which it would continue.
fn remembered(
    path: &Path,
    subject: Subject<'_>,
    real_time_factor: f64,
) -> Result<(String, Option<Clock>), Finding> {
    if !path.exists() {
        return Ok((String::new(), None));
    }
    match journal::peek(path, subject) {
        Ok(Prospect::GoesOn(memory, noted)) => {
            let clock = Clock::new(real_time_factor);
            let clock = memory.resumed(noted.as_ref(), &clock).map(|now| clock.at(now));
            let note = match memory.observations.len() {
                0 => String::new(),
                count => format!("; it goes on with {count} observations"),
            };
            Ok((note, clock))
        }
        Ok(Prospect::SetAside { damage }) => {
            let found =
                format!("{} is damaged ({damage}): all that the robot knew is lost to it", path.display());
            let advice = "when the robot starts, it keeps this file as NAME.damaged and begins a new one; what its teammates \
                          know it hears again";
            Err(Finding::warn("journal", found, advice))
        }
        Err(error) => Err(Finding::fail(
            "journal",
            error.to_string(),
            "until that is repaired, the robot will not start",
        )),
    }
}

/// Times first decisions, for which most of the map is open: later ones take no longer.
pub(super) fn decisions(agent_config: &AgentConfig) -> Finding {
    let mission = &agent_config.mission;
    let crossing =
        Duration::from_secs_f64(agent_config.terrain.cell_meters() / mission.speed_meters_per_second);
    let policy = agent_config.robot.policy.name;
    let cells: Vec<_> = agent_config.terrain.traversable_cells().collect();
    let start = MissionTime::START + mission.stagger * u32::from(agent_config.place.member);
    // Shared tables are built once.
    UtilityTable::warm_up();
    let mut slowest = Duration::ZERO;
    for place in 0..DECISIONS.min(cells.len()) {
        let cell = cells[place * cells.len() / DECISIONS.min(cells.len())];
        let sensed = Event::Sensed { cell, readings: Vec::new() };
        match Agent::new(agent_config.clone()).handle(start, sensed) {
            Ok(effects) => slowest = slowest.max(effects.decision.unwrap_or_default()),
            Err(error) => return Finding::fail("decisions", error.to_string(), ""),
        }
    }
    let (slowest_ms, crossing_ms) = (slowest.as_secs_f64() * 1e3, crossing.as_secs_f64() * 1e3);
    let found = format!("{policy} takes up to {slowest_ms:.2} ms; a cell is crossed in {crossing_ms:.0} ms");
    if slowest <= crossing {
        Finding::pass("decisions", found)
    } else {
        Finding::fail("decisions", found, "take larger cells, a faster policy (gnn) or a faster computer")
    }
}

/// Checks that the vehicle is not faster than the team accepts.
pub(super) fn speed(vehicle: f64, class: &Class) -> Finding {
    let accepted = class.speed_meters_per_second;
    let found = format!("the vehicle drives {vehicle} m/s, the scenario's robot {accepted} m/s");
    if vehicle <= accepted * SPEED_TOLERANCE {
        return Finding::pass("speed", found);
    }
    let advice =
        "make vehicle.speed_meters_per_second and mission.speed_meters_per_second true of the vehicle";
    Finding::fail(
        "speed",
        format!("{found}: its observations are rejected, as of a robot that moves too fast"),
        advice,
    )
}

/// Checks that the detector of the settings can be made, and times it on a gray image of each camera.
pub(super) fn detector(body: &Body, file: &Path, make: Make<'_>) -> Vec<Finding> {
    let advice = "see docs/field-guide.md: which modules are understood, and how to build with libtorch";
    let mut detector = match body.make_detector(file, make) {
        Ok(Some(detector)) => detector,
        Ok(None) => return Vec::new(),
        Err(error) => return vec![Finding::fail("detector", error.to_string(), advice)],
    };
    let cameras = body.ros.cameras_with_images().filter(|name| !body.ros.is_detected_elsewhere(name));
    let cameras = cameras.filter_map(|name| body.pilot.camera(name));
    let observed = cameras.map(|camera| {
        let settings = camera.settings();
        let (subject, image) = (format!("detector, {}", settings.name), gray(settings));
        let start = Instant::now();
        match detector.detect(&image) {
            Ok(_) => {
                let size = format!("{} x {} pixels", image.width_pixels, image.height_pixels);
                let took_ms = start.elapsed().as_secs_f64() * 1e3;
                Finding::pass(subject, format!("an image of {size} takes {took_ms:.0} ms"))
            }
            Err(reason) => Finding::fail(subject, reason, advice),
        }
    });
    observed.collect()
}

fn gray(camera: &CameraSettings) -> Image {
    const GRAY: u8 = 114;
    let (width_pixels, height_pixels) = (camera.width_pixels, camera.height_pixels);
    let rgb = vec![GRAY; 3 * width_pixels as usize * height_pixels as usize];
    Image { stamp_unix_ns: 0, frame: String::new(), width_pixels, height_pixels, rgb }
}
