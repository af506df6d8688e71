//! `dragnet export`: a recorded mission for maps, GPS receivers and ground stations.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use dragnet_coordinator::Ending;
use dragnet_coordinator::finds::of_subject;
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::segment;
use dragnet_export::{Account, ExportError, belief, csv, geojson, gpx, kml, plan};
use dragnet_proto::message::Detection;
use dragnet_proto::picture::Picture;
use dragnet_scenario::Places;
use dragnet_scenario::map_file::{BeliefFile, GeoPoint, Purpose};
use dragnet_scenario::time::MissionTime;

use super::{Failure, complain, output, segments};
use crate::terminal::{self, counted};

/// Export a recorded mission for maps, GPS receivers and ground stations.
///
/// Writes found objects, tracks of the robots and cleared areas with their probability of detection (.geojson, .kml);
/// finds and tracks (.gpx); the robots' plans for a ground station (.plan), one file for each robot; how thoroughly each area
/// was searched, and with which effort (.csv); or what the search believed (.belief.json), the prior of the next one. Prints
/// how thoroughly each area was searched.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  dragnet export missing_person-0.mcap --to mission.kml\n  dragnet export missing_person-0.mcap --to next.plan --at 600\n  dragnet export warehouse-0.mcap --to mission.geojson --origin 49.236,-2.24\n  dragnet export missing_person-0.mcap --to shift1.belief.json"
)]
pub(crate) struct Arguments {
    /// The recording (MCAP)
    recording: PathBuf,
    /// The file to write; its extension determines the format. The format `plan` writes a file for each robot:
    /// next-robot-1.plan for --to next.plan
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    /// The format of the file, instead of that of the extension
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Latitude (-85 to 85) and longitude (-180 to 180) of the map's south-western corner, degrees; only for a
    /// recording without a position on the earth
    #[arg(long, value_name = "LAT,LON", value_parser = parse_origin, allow_hyphen_values = true)]
    origin: Option<GeoPoint>,
    /// Mission time of the exported state, seconds from the mission's start [default: the end of the search]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, allow_negative_numbers = true)]
    at: Option<MissionTime>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Geojson,
    Kml,
    Gpx,
    Plan,
    Csv,
    Belief,
}

impl Format {
    fn of(path: &Path) -> Option<Self> {
        if BeliefFile::is_file(path) {
            return Some(Self::Belief);
        }
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        match extension.as_str() {
            "geojson" | "json" => Some(Self::Geojson),
            "kml" => Some(Self::Kml),
            "gpx" => Some(Self::Gpx),
            "plan" => Some(Self::Plan),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

fn parse_origin(text: &str) -> Result<GeoPoint, String> {
    let point = text.split_once(',').and_then(|(latitude, longitude)| {
        GeoPoint::checked(longitude.trim().parse().ok()?, latitude.trim().parse().ok()?)
    });
    point.ok_or_else(|| format!("allowed is LATITUDE,LONGITUDE with {}", GeoPoint::ALLOWED))
}

fn parse_seconds(text: &str) -> Result<MissionTime, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    let time = seconds.filter(|seconds| seconds.as_secs() <= 1_000_000_000);
    time.map(|time| MissionTime::START + time).ok_or_else(|| "allowed is 0 to 1000000000 seconds".to_owned())
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let format = arguments.format.or_else(|| Format::of(&arguments.to)).ok_or_else(|| {
        let to = arguments.to.display();
        Failure::Input(format!(
            "--to {to}: unknown extension; allowed are .geojson, .kml, .gpx, .csv, .plan and .belief.json"
        ))
    })?;
    let playback = Playback::read(&arguments.recording).map_err(Failure::input)?;
    if let Some(at) = arguments.at.filter(|&at| at > playback.end()) {
        let (at, end) = (at.as_seconds(), playback.end().as_seconds());
        return Err(Failure::Input(format!(
            "--at {at}: the recording ends at {end:.1} s; allowed is 0 to that"
        )));
    }
    if playback.ending != Ending::Complete {
        let what = format!("is {}; what is whole of it is exported", playback.ending);
        complain("warning", &format!("{}: {what}", arguments.recording.display()));
    }
    let Exported { files, summary } = exported(arguments, format, &playback)?;
    for (path, bytes) in files {
        let path = output::free("--to", &path, "no file is")?;
        output::write(&path, &bytes)?;
        terminal::print(&format!("{}\n", path.display()))?;
    }
    Ok(terminal::print(&summary)?)
}

/// The files of a format, by path, and what is printed.
struct Exported {
    files: Vec<(PathBuf, Vec<u8>)>,
    summary: String,
}

fn exported(arguments: &Arguments, format: Format, playback: &Playback) -> Result<Exported, Failure> {
    let text: fn(&Account) -> String = match format {
        Format::Geojson => geojson::text,
        Format::Kml => kml::text,
        Format::Gpx => gpx::text,
        Format::Csv if playback.earth.is_none() && arguments.origin.is_none() => {
            return Ok(effort(arguments, playback));
        }
        Format::Csv => |account| csv::text(&account.segments),
        Format::Plan => return plans(arguments, playback),
        Format::Belief => return believed(arguments, playback),
    };
    let mut account = account(arguments, playback)?;
    let stem = arguments.to.file_stem().unwrap_or_default().to_string_lossy();
    account.pictures_folder = format!("{stem}-pictures");
    let pictures = if format == Format::Csv { Vec::new() } else { pictures(&arguments.to, &account)? };
    let files = [(arguments.to.clone(), text(&account).into_bytes())].into_iter().chain(pictures).collect();
    Ok(Exported { files, summary: summary(&account) })
}

/// How thoroughly a map that is nowhere on the earth was searched.
fn effort(arguments: &Arguments, playback: &Playback) -> Exported {
    let rows = segment::rows_of(playback, arguments.at);
    let files = vec![(arguments.to.clone(), csv::text(&rows).into_bytes())];
    Exported { files, summary: segments::table(&rows) }
}

/// The pictures of finds, in a folder of their own beside a file.
fn pictures(beside: &Path, account: &Account) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let folder = beside.with_file_name(&account.pictures_folder);
    if !account.pictures.is_empty() {
        std::fs::create_dir_all(&folder)
            .map_err(|error| Failure::Input(format!("--to {}: {error}", folder.display())))?;
    }
    let file = |(&cell, picture): (_, &Arc<Picture>)| {
        Some((beside.with_file_name(account.picture_file(cell)?), picture.jpeg.to_vec()))
    };
    Ok(account.pictures.iter().filter_map(file).collect())
}

fn account(arguments: &Arguments, playback: &Playback) -> Result<Account, Failure> {
    Account::new(playback, arguments.origin, arguments.at).map_err(|error| of_recording(arguments, &error))
}

fn of_recording(arguments: &Arguments, error: &ExportError) -> Failure {
    Failure::Input(format!("{}: {error}", arguments.recording.display()))
}

/// The plans, one file for each robot.
fn plans(arguments: &Arguments, playback: &Playback) -> Result<Exported, Failure> {
    let account = account(arguments, playback)?;
    let texts = plan::texts(&account).map_err(|error| of_recording(arguments, &error))?;
    let stem = arguments.to.file_stem().unwrap_or_default().to_string_lossy();
    let named = |robot| arguments.to.with_file_name(format!("{stem}-robot-{robot}.plan"));
    let files = texts.into_iter().map(|(robot, text)| (named(robot), text.into_bytes())).collect();
    Ok(Exported { files, summary: summary(&account) })
}

/// The belief, for the next search.
fn believed(arguments: &Arguments, playback: &Playback) -> Result<Exported, Failure> {
    let to = &arguments.to;
    if !BeliefFile::is_file(to) {
        let allowed = "for a belief a name that ends in .belief.json is allowed";
        return Err(Failure::Input(format!("--to {}: {allowed}", to.display())));
    }
    let belief = belief::belief_file(playback, arguments.origin, arguments.at)
        .map_err(|error| of_recording(arguments, &error))?;
    let searched: Vec<f64> = belief.probability.iter().copied().flatten().collect();
    let (cells, expected) = (counted(searched.len(), "searched cell"), searched.iter().sum::<f64>());
    let content = match belief.rest_of_world.filter(|_| belief.subjects.is_none()) {
        Some(rest) => format!("the subject is in {cells} with {expected:.4}, outside of them with {rest:.4}"),
        None => format!("{expected:.2} objects expected in {cells}"),
    };
    let summary = format!("{content}; the next scenario names the file as prior.file\n");
    Ok(Exported { files: vec![(to.clone(), belief.text().into_bytes())], summary })
}

/// The finds, and how thoroughly each area was searched.
fn summary(account: &Account) -> String {
    let found = counted(account.found.len(), if account.subject.is_some() { "find" } else { "object" });
    let head = format!(
        "{} after {:.1} s: {found} {}, {}\n",
        account.name,
        account.until.as_seconds(),
        if account.subject.is_some() { "declared" } else { "found" },
        counted(account.tracks.len(), "track"),
    );
    let searches = account.areas.iter().filter(|(area, _)| matches!(area.purpose, Purpose::Search(_)));
    let by_area: usize = searches.filter_map(|(_, coverage)| Some(coverage.as_ref()?.cells)).sum();
    let shared = if by_area > account.total.cells {
        "a cell that several areas touch counts in the cells of each, and its probability is divided among them\n"
    } else {
        ""
    };
    head + &segments::table(&account.segments) + shared + &subject(account)
}

/// The finds of the subjects and where they are, and what the table's two probabilities mean.
fn subject(account: &Account) -> String {
    let Some(standing) = account.subject else { return String::new() };
    let places = Places::new(&account.terrain, Some(&account.frame));
    let find = |object: &Detection| {
        let operator = account.verdicts.decision(object.cell);
        format!(
            "{}\n",
            of_subject(
                &places.object(object.cell, account.positions.get(&object.cell)),
                object.probability,
                operator
            )
        )
    };
    let finds: String = account.found.iter().map(find).collect();
    let (each, found) = if standing.number == 1 {
        ("the subject", "")
    } else {
        ("any one of the subjects", ", found or not")
    };
    format!(
        "POS is of the effort, POA x POD: how probable it was beforehand that this search finds {each} there; the posterior \
         is of {each}{found}: how probable it is there after all that was seen\n\
         the {}, by the posterior: {standing}\n{finds}",
        standing.noun()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_latitude_and_longitude() {
        let point = parse_origin("49.5, -2.25").unwrap();
        assert!(
            (point.latitude_degrees - 49.5).abs() < 1e-12 && (point.longitude_degrees + 2.25).abs() < 1e-12
        );
        for wrong in ["", "49.5", "49.5;2", "91,0", "0,181", "nan,0", "1,2,3"] {
            assert!(parse_origin(wrong).unwrap_err().contains("LATITUDE,LONGITUDE"), "{wrong}");
        }
        for wrong in ["-1", "nan", "1e300", "x"] {
            assert!(parse_seconds(wrong).is_err(), "{wrong}");
        }
    }
}
