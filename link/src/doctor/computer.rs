//! The robot's own computer: is there room for its journal, and does it decide in time?

use std::path::Path;
use std::time::Duration;

use dragnet_agent::agent::{Agent, Orders};
use dragnet_proto::participant::{Mind, Stimulus};
use dragnet_proto::time::MissionTime;
use dragnet_search::information::InformationTable;

use super::Finding;

/// What a robot of a large team writes in a long day, and room for a log.
const ROOM_BYTES: u64 = 1 << 30;
/// So many decisions are timed, spread over the map.
const DECISIONS: usize = 20;

pub(super) fn journal(path: &Path) -> Finding {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let at = folder.display();
    if let Err(error) = tempfile::tempfile_in(folder) {
        let advice = "make the folder, and let the robot's user write there; or name another under `journal`";
        return Finding::fail("journal", format!("nothing can be written in {at}: {error}"), advice);
    }
    let free = rustix::fs::statvfs(folder).map(|it| it.f_bavail.saturating_mul(it.f_frsize));
    let begun = if path.exists() { "; it goes on with what it knew" } else { "" };
    match free {
        Err(error) => Finding::fail("journal", format!("{at}: {error}"), ""),
        Ok(free) if free < ROOM_BYTES => {
            let found = format!("{} MB are free in {at}", free >> 20);
            Finding::fail("journal", found, format!("make room: {} MB last for long", ROOM_BYTES >> 20))
        }
        Ok(free) => Finding::pass("journal", format!("{}; {} MB free{begun}", path.display(), free >> 20)),
    }
}

/// Times first decisions, for which most of the map is open: later ones take no longer.
pub(super) fn decisions(orders: &Orders) -> Finding {
    let mission = &orders.mission;
    let crossing = Duration::from_secs_f64(orders.terrain.cell_meters() / mission.speed_meters_per_second);
    let policy = orders.robot.policy.name;
    let cells: Vec<_> = orders.terrain.traversable_cells().collect();
    let start = MissionTime::START + mission.stagger * u32::from(orders.place.member);
    // What all decisions share is built once.
    let _ = InformationTable::shared();
    let mut slowest = Duration::ZERO;
    for place in 0..DECISIONS.min(cells.len()) {
        let cell = cells[place * cells.len() / DECISIONS.min(cells.len())];
        let sensed = Stimulus::Sensed { cell, readings: Vec::new() };
        match Agent::new(orders.clone()).experience(start, sensed) {
            Ok(reaction) => slowest = slowest.max(reaction.decision.unwrap_or_default()),
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
