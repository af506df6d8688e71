//! Facts about a run in its recording.

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_coordinator::record::encoder::{self, MessageListener};
use dragnet_coordinator::record::{
    Header, LINE_OF_SIGHT, MISSION_TIME, NOISE_VARIANCE, REST_OF_WORLD, Recorder, SUBJECTS, THIN_WALLS,
};
use dragnet_coordinator::recording::Notice;
use dragnet_scenario::{Class, Scenario};
use dragnet_sim::episode::Episode;

use super::Options;
use crate::{RuntimeError, unix_time};

/// Start of simulated missions: 2000-01-01, so that a recording does not depend on when it was made.
const SIMULATED_START_UNIX_NS: i64 = 946_684_800_000_000_000;

/// The coordinator of a scenario, with a recorder if the run is recorded, and a listener for its messages if there is one.
pub(crate) fn node(
    scenario: &Scenario,
    seed: u64,
    options: &Options,
    there: Existing,
    messages: Option<MessageListener>,
) -> Result<CoordinatorNode, RuntimeError> {
    let agent_config = CoordinatorConfig::of(scenario);
    let header = Header {
        start_unix_ns: start_unix_ns(options),
        terrain: Arc::clone(&agent_config.terrain),
        origin: scenario.origin(),
        prior: scenario.prior().clone(),
        scenario: scenario.source().text.clone(),
        earth: scenario.earth(),
        run: run_metadata(scenario, seed, options),
    };
    let told = messages.map(|messages| encoder::telling(&header, messages));
    let recorder = options.recording.as_ref().map(|path| match there {
        Existing::Rejected => Recorder::create(path, header),
        Existing::Beside => Recorder::create_beside(path, header),
    });
    let recorder = recorder.transpose()?;
    if let (Some(recorder), Some(path)) = (&recorder, &options.recording)
        && recorder.path() != path
    {
        let (path, free) = (path.display(), recorder.path().display());
        tracing::info!("{path} is there already, from an earlier start; this one records to {free}");
    }
    let node = CoordinatorNode::new(Mission::new(agent_config), recorder);
    Ok(node.with_listener(told).notifying(Box::new(tell)))
}

fn tell(notice: &Notice) {
    if notice.is_trouble() {
        tracing::warn!("{notice}");
    } else {
        tracing::info!("{notice}");
    }
}

/// What to do if the file of a recording exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Existing {
    /// Fail: the user can choose another name.
    Rejected,
    /// Begin another file beside it: there may be no user.
    Beside,
}

fn start_unix_ns(options: &Options) -> i64 {
    options.real_time_factor.map_or(SIMULATED_START_UNIX_NS, |_| unix_time::now_ns())
}

fn run_metadata(scenario: &Scenario, seed: u64, options: &Options) -> BTreeMap<String, String> {
    let policies: Vec<&str> = scenario.robots().iter().map(|robot| robot.policy.name.as_str()).collect();
    let mut facts = metadata([
        ("scenario", scenario.name().to_owned()),
        ("seed", seed.to_string()),
        ("version", options.version.clone()),
        ("robots", policies.len().to_string()),
        ("policies", policies.join(",")),
        ("detection_threshold", scenario.mission().detection_threshold.to_string()),
        ("sensor_radius", of_robots(scenario, |class| class.sensor.radius().to_string())),
        (NOISE_VARIANCE, of_robots(scenario, |class| class.sensor.noise_variance().to_string())),
        ("speed_meters_per_second", of_robots(scenario, |class| class.speed_meters_per_second.to_string())),
    ]);
    if scenario.robots().iter().any(|robot| robot.class.flies) {
        facts.extend(metadata([("flies", of_robots(scenario, |class| class.flies.to_string()))]));
    }
    if let Some(radius) = scenario.terrain().line_of_sight().radius() {
        facts.extend(metadata([(LINE_OF_SIGHT, radius.to_string())]));
        let thin: Vec<String> =
            scenario.terrain().thin_walls().iter().map(|cell| cell.number().to_string()).collect();
        if !thin.is_empty() {
            facts.extend(metadata([(THIN_WALLS, thin.join(" "))]));
        }
    }
    if let Some(earlier) = scenario.earlier() {
        facts.extend(metadata([("continues", earlier.belief.mission.clone())]));
    }
    if let Some(subjects) = scenario.subjects() {
        facts.extend(metadata([(REST_OF_WORLD, subjects.rest_of_world().to_string())]));
        if subjects.number() > 1 {
            facts.extend(metadata([(SUBJECTS, subjects.number().to_string())]));
        }
    }
    facts
}

/// A fact of each robot, separated by commas; once if all are of one class.
fn of_robots(scenario: &Scenario, fact: impl Fn(&Class) -> String) -> String {
    match scenario.only_class() {
        Some(class) => fact(class),
        None => scenario.robots().iter().map(|robot| fact(&robot.class)).collect::<Vec<_>>().join(","),
    }
}

/// Results of a run, for the end of its recording. Times measured by the wall clock are not included.
pub(super) fn summary(episode: &Episode) -> BTreeMap<String, String> {
    let objects: Vec<String> =
        episode.truth.objects().iter().map(|object| object.number().to_string()).collect();
    let path_cells: Vec<String> = episode.path_cells.iter().map(ToString::to_string).collect();
    metadata([
        (MISSION_TIME, episode.outcome.ended.as_seconds().to_string()),
        ("objects", episode.truth.objects().len().to_string()),
        ("object_cells", objects.join(",")),
        ("found", episode.score.true_positives.to_string()),
        ("false_positives", episode.score.false_positives.to_string()),
        ("path_cells", path_cells.join(",")),
        ("observations_sent", episode.outcome.observations.to_string()),
        ("beliefs_equal", episode.outcome.beliefs_equal.to_string()),
        ("belief_digest", episode.outcome.digest.to_string()),
    ])
}

fn metadata<const N: usize>(entries: [(&str, String); N]) -> BTreeMap<String, String> {
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}
