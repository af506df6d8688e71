//! `dragnet keys`: the certificates of a mission.

use std::fmt::Write;
use std::path::PathBuf;

use dragnet_keys::certificate::{MAX_DAYS, check_host};
use dragnet_keys::folder::{Folder, SETTINGS};
use dragnet_keys::name::Name;
use dragnet_keys::register::{Entry, Standing, Topology};
use dragnet_proto::key::Mission;
use serde::Serialize;
use time::OffsetDateTime;

use super::Failure;
use crate::terminal;
use crate::terminal::table::Table;

/// Create, list and revoke the certificates of a mission.
///
/// A folder holds the certificate authority of one mission and a folder for each participant, which is copied to the
/// participant's computer unchanged. There, the settings of `dragnet agent`, `coordinator` or `sim` name its
/// zenoh.json5 as `config` and use tls/ endpoints. The authority's key stays in its folder.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet keys init valley-keys --mission valley --robots 3
  dragnet keys add valley-keys robot-4
  dragnet keys list valley-keys
  dragnet keys revoke valley-keys robot-2")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Create a mission's certificate authority, and certificates of its robots, its coordinator and its simulator
    Init {
        /// The folder to create; it must not exist
        folder: PathBuf,
        /// Name of the mission, as in the settings of its processes
        #[arg(long, value_name = "NAME", value_parser = parse_mission)]
        mission: Mission,
        /// Number of robots, which are numbered from 1, 0 to 65535
        #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true)]
        robots: u16,
        /// Create settings for a star: all participants connect to the coordinator only, which forwards their messages
        #[arg(long)]
        star: bool,
        #[command(flatten)]
        terms: Terms,
    },
    /// Create further certificates, also for a participant whose certificate was revoked
    Add {
        /// A folder made by `dragnet keys init`
        folder: PathBuf,
        /// Participants: robot-1 and so on, coordinator, sim
        #[arg(required = true, value_name = "NAME", value_parser = parse_name)]
        names: Vec<Name>,
        #[command(flatten)]
        terms: Terms,
    },
    /// List the certificates
    List {
        /// A folder made by `dragnet keys init`
        folder: PathBuf,
        /// Print one JSON object instead of a table
        #[arg(long)]
        json: bool,
    },
    /// Revoke a participant's certificate, and print which files the other participants need
    Revoke {
        /// A folder made by `dragnet keys init`
        folder: PathBuf,
        /// Participant: robot-1 and so on, coordinator, sim
        #[arg(value_parser = parse_name)]
        name: Name,
    },
}

/// The contents of a certificate.
#[derive(clap::Args)]
struct Terms {
    /// Host name or IP address of the participant; may be repeated. Host names are verified if every certificate has
    /// one
    #[arg(long = "host", value_name = "NAME|IP", value_parser = parse_host)]
    hosts: Vec<String>,
    /// Validity of the certificate, days, 1 to 3650
    #[arg(
        long, value_name = "D", default_value_t = 365, allow_negative_numbers = true,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_DAYS))
    )]
    days: u32,
}

fn parse_mission(text: &str) -> Result<Mission, String> {
    text.parse().map_err(|error| format!("{error}"))
}

fn parse_name(text: &str) -> Result<Name, String> {
    text.parse().map_err(|error| format!("{error}"))
}

fn parse_host(text: &str) -> Result<String, String> {
    check_host(text).map_err(|error| format!("{error}"))?;
    Ok(text.to_owned())
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let now = OffsetDateTime::now_utc();
    let text = match &arguments.action {
        Action::Init { folder, mission, robots, star, terms } => {
            let topology = if *star { Topology::Star } else { Topology::Mesh };
            let names: Vec<Name> =
                (1..=*robots).filter_map(Name::robot).chain([Name::COORDINATOR, Name::Simulator]).collect();
            let mut made = Folder::init(folder, mission.clone(), topology, now).map_err(Failure::input)?;
            made.add(&names, &terms.hosts, terms.days, now).map_err(Failure::input)?;
            handed_out(&made, &names)
        }
        Action::Add { folder, names, terms } => {
            let mut made = Folder::open(folder).map_err(Failure::input)?;
            made.add(names, &terms.hosts, terms.days, now).map_err(Failure::input)?;
            handed_out(&made, names) + &how_to_inform(&made, names)
        }
        Action::List { folder, json } => {
            let made = Folder::open(folder).map_err(Failure::input)?;
            if *json {
                return Ok(terminal::print_json(&Listing::of(&made, now))?);
            }
            Listing::of(&made, now).draw()
        }
        Action::Revoke { folder, name } => {
            let mut made = Folder::open(folder).map_err(Failure::input)?;
            let revoked = made.revoke(*name).map_err(Failure::input)?;
            format!("{} is revoked.\n{}", revoked.common_name(), how_to_inform(&made, &[*name]))
        }
    };
    Ok(terminal::print(&text)?)
}

/// Which folder to copy to which participant.
fn handed_out(folder: &Folder, names: &[Name]) -> String {
    let mut text =
        "Copy each folder unchanged to the computer of its owner, and then delete the keys here if you like:\n"
            .to_owned();
    for name in names {
        // A string takes all that is written to it.
        let _ = writeln!(text, "  {:<12}  {}", name.to_string(), folder.home(*name).display());
    }
    text + "Its settings then say: config = \"zenoh.json5\", and tls/ADDRESS:PORT to listen and to connect.\n\
            authority.key stays here: its owner can impersonate any participant.\n"
}

/// How to inform the others.
fn how_to_inform(folder: &Folder, changed: &[Name]) -> String {
    let holders = folder.register().holders();
    let others: Vec<&Entry> = holders.into_iter().filter(|entry| !changed.contains(&entry.name)).collect();
    if others.is_empty() {
        return "No other participant has a valid certificate.\n".to_owned();
    }
    let mut text =
        "The others apply this once they have their new settings and are restarted. Copy and restart:\n"
            .to_owned();
    for entry in &others {
        let _ = writeln!(
            text,
            "  {:<12}  {}",
            entry.name.to_string(),
            folder.home(entry.name).join(SETTINGS).display()
        );
    }
    text
}

/// All certificates of a mission.
#[derive(Serialize)]
struct Listing {
    mission: String,
    topology: Topology,
    certificates: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    name: String,
    common_name: String,
    serial: u64,
    /// The last day, UTC.
    valid_until: String,
    standing: Standing,
    hosts: Vec<String>,
}

impl Listing {
    fn of(folder: &Folder, now: OffsetDateTime) -> Self {
        let register = folder.register();
        let listed = |entry: &Entry| Listed {
            name: entry.name.to_string(),
            common_name: entry.common_name(),
            serial: entry.serial,
            valid_until: entry.last_day().to_string(),
            standing: entry.standing(now),
            hosts: entry.hosts.clone(),
        };
        Self {
            mission: register.mission.clone(),
            topology: register.topology,
            certificates: register.certificates.iter().map(listed).collect(),
        }
    }

    fn draw(&self) -> String {
        let mut table = Table::new(["name", "common name", "valid until", "standing", "serial"]);
        for listed in &self.certificates {
            let Listed { name, common_name, serial, valid_until, standing, .. } = listed;
            table.push([
                name.clone(),
                common_name.clone(),
                valid_until.clone(),
                standing.to_string(),
                serial.to_string(),
            ]);
        }
        format!("mission {}\n{}", self.mission, table.draw(4))
    }
}
