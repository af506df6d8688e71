//! `dragnet agent --dry-run`: prints the actions of a robot on a recording, and a summary.

use std::path::Path;
use std::time::Duration;

use dragnet_coordinator::Ending;
use dragnet_ros2::output::Level;
use dragnet_runtime::dry_run::{self, FoundObject, News, Note, Summary};
use dragnet_search::cell::Position;

use super::{Failure, eyes};
use crate::terminal;
use crate::terminal::table::Table;

/// Observations without new finds that are listed; a long recording has too many to read.
const MAX_LISTED: usize = 5;

pub(super) fn execute(config: &Path, recording: &Path) -> Result<(), Failure> {
    let mut reported = Ok(());
    let mut tell = |note: Note| {
        if reported.is_ok() {
            reported = terminal::print(&line(&note));
        }
    };
    let summary = dry_run::run(config, recording, &eyes::make, &mut tell)?;
    reported?;
    Ok(terminal::print(&text(&summary))?)
}

fn line(note: &Note) -> String {
    let news = match &note.news {
        News::Observes { from, readings, objects } if objects.is_empty() => {
            format!("observes from {}: {} read", place(*from), terminal::counted(*readings, "cell"))
        }
        News::Observes { from, readings, objects } => {
            let mut seen: Vec<String> = objects.iter().take(MAX_LISTED).map(|&cell| place(cell)).collect();
            if objects.len() > MAX_LISTED {
                seen.push(format!("{} more", objects.len() - MAX_LISTED));
            }
            let cells = terminal::counted(*readings, "cell");
            format!("observes from {}: {cells} read, an object in {}", place(*from), seen.join(", "))
        }
        News::Decides { cells, toward, computing } => {
            let way = match toward {
                Some(toward) => format!("{} to {}", terminal::counted(*cells, "cell"), place(*toward)),
                None => "stays".to_owned(),
            };
            let took = computing.map(|took| format!(", in {}", milliseconds(took))).unwrap_or_default();
            format!("decides  {way}{took}")
        }
        News::Finds(object) => format!("finds    an object in {}", found(object)),
        News::Doubts(cell) => format!("doubts   that there is one in {}", place(*cell)),
        News::Tells(diagnostic) => {
            let level = match diagnostic.level {
                Level::Ok => "well",
                Level::Warning => "warning",
                Level::Error => "error",
                Level::Stale => "silent",
            };
            format!("{level:<7}  {}: {}", diagnostic.name.trim_start_matches("dragnet: "), diagnostic.message)
        }
    };
    format!("{:>9.2} s  {news}\n", note.time.as_seconds())
}

/// Rows count from the south, as everywhere.
fn place(position: Position) -> String {
    format!("[{}, {}]", position.row, position.column)
}

/// An object's cell, its expected position in the frame of the vehicle's network, and its standard deviation along the
/// least certain axis.
fn found(object: &FoundObject) -> String {
    let (at, [std_meters, _]) = (object.place, object.place.std_meters());
    format!("{} at ({:.2}, {:.2}) m, std {std_meters:.2} m", place(object.cell), at.x_meters, at.y_meters)
}

fn milliseconds(duration: Duration) -> String {
    format!("{:.2} ms", duration.as_secs_f64() * 1e3)
}

fn text(summary: &Summary) -> String {
    let mut received = Table::new(["topic", "type", "messages", "rejected"]);
    for traffic in &summary.received {
        let (messages, refused) = (traffic.messages.to_string(), traffic.refused.to_string());
        received.push([traffic.topic.clone(), traffic.message.to_owned(), messages, refused]);
    }
    let refused = summary.received.iter().filter(|traffic| traffic.refused > 0);
    let refused =
        refused.map(|traffic| format!("rejected on {}, the last: {}\n", traffic.topic, traffic.reason));
    let published = summary.published.iter().map(|(topic, count)| format!("{topic} {count}"));
    let slowest = summary.decisions.iter().max().copied().unwrap_or_default();
    let [before, after] = summary.entropy_nats;
    let ending = match &summary.ending {
        Ending::Complete => String::new(),
        Ending::CutOff => "the recording was cut off; all of it that is whole was read\n".to_owned(),
        ending @ (Ending::Damaged { .. } | Ending::Followed { .. }) => {
            format!("the recording is {ending}; all of it that is whole was read\n")
        }
    };
    format!(
        "\n{}{}\n{:.1} s: {}, {} readings, {}, the slowest in {}\n\
         entropy of the belief {before:.1} to {after:.1} nats; found: {}\n\
         it would have published (messages): {}\n{ending}",
        received.draw(2),
        refused.collect::<String>(),
        summary.duration.as_secs_f64(),
        terminal::counted(summary.observations, "observation"),
        summary.readings,
        terminal::counted(summary.decisions.len(), "decision"),
        milliseconds(slowest),
        listed(summary.found.iter().map(found)),
        listed(published),
    )
}

fn listed(entries: impl Iterator<Item = String>) -> String {
    let entries: Vec<String> = entries.collect();
    if entries.is_empty() { "nothing".to_owned() } else { entries.join(", ") }
}
