//! `dragnet doctor`: checks that a robot is ready.

use std::path::{Path, PathBuf};
use std::time::Duration;

use dragnet_files::read_at_most;
use dragnet_keys::certificate;
use dragnet_runtime::config::{self, AgentSettings};
use dragnet_runtime::doctor::{self, Finding, Verdict};
use dragnet_runtime::session;
use dragnet_search::utility::UtilityTable;
use time::OffsetDateTime;

use super::{Failure, eyes};
use crate::terminal;

/// Check a robot's settings, network, sensors and clocks before a mission.
///
/// Checks the settings, journal and disk, the decision time on this computer, the team's network and its participants,
/// clocks, certificates and, for a vehicle, each topic of its ROS 2 network. Prints a line for each check (pass, WARN
/// or FAIL), and the remedy for each problem.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  dragnet doctor --config robot_1.toml\n\nExit codes: 0 all checks passed, 1 a check failed."
)]
pub(crate) struct Arguments {
    /// File with the settings of the robot (TOML)
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Time to listen to each network, seconds, 1 to 600
    #[arg(long, value_name = "SECONDS", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=600))]
    listen: u64,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    UtilityTable::warm_up();
    let mut failed = 0;
    let mut reported = Ok(());
    let mut tell = |finding: Finding| {
        failed += u32::from(finding.verdict == Verdict::Fail);
        if reported.is_ok() {
            reported = terminal::print(&format!("{finding}\n"));
        }
    };
    doctor::examine(&arguments.config, Duration::from_secs(arguments.listen), &eyes::make, &mut tell);
    for finding in certificates(&arguments.config) {
        tell(finding);
    }
    reported?;
    match failed {
        0 => Ok(()),
        1 => Err(Failure::run("one check failed")),
        failed => Err(Failure::run(format!("{failed} checks failed"))),
    }
}

/// The expiry of each certificate that the robot uses or trusts. Mistakes in the settings themselves are reported
/// elsewhere.
fn certificates(file: &Path) -> Vec<Finding> {
    let Ok(config) = config::load::<AgentSettings>(file) else { return Vec::new() };
    let Ok(paths) = session::certificates(&config.common.zenoh.named_in(file)) else { return Vec::new() };
    let now = OffsetDateTime::now_utc();
    paths.iter().map(|path| certificate(path, now)).collect()
}

/// The maximum size of a certificate file, bytes.
const MAX_CERTIFICATE_BYTES: u64 = 1 << 20;

fn certificate(path: &Path, now: OffsetDateTime) -> Finding {
    let subject = format!("certificate {}", path.display());
    let advice = "make new ones: dragnet keys add";
    let bytes = match read_at_most(path, MAX_CERTIFICATE_BYTES) {
        Ok(bytes) => bytes,
        Err(error) => return Finding::fail(subject, error.to_string(), advice),
    };
    let Some(validity) = certificate::validity(&bytes) else {
        return Finding::fail(subject, "this is none", advice);
    };
    let until = validity.end.date();
    if validity.contains(&now) {
        Finding::pass(subject, format!("it holds until {until}"))
    } else if now < validity.start {
        let found = format!(
            "it holds from {} on, and this computer's clock says {}",
            validity.start.date(),
            now.date()
        );
        Finding::fail(subject, found, "set this computer's clock")
    } else {
        Finding::fail(subject, format!("it ended with {until}"), advice)
    }
}
