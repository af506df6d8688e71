//! `dragnet forecast`: what a search is expected to find, and when, before anybody moves.

use std::path::PathBuf;

use dragnet_experiments::forecast::{Forecast, PROBABILITIES, Probability, forecast};
use dragnet_experiments::jobs::Effort;
use dragnet_experiments::seeds::Seeds;
use dragnet_scenario::Scenario;
use dragnet_scenario::file::PolicyField;
use serde::Serialize;

use super::earlier::{self, PriorFrom};
use super::{Failure, scenario};
use crate::terminal::progress::Bars;
use crate::terminal::table::Table;
use crate::terminal::{self, counted};

/// Forecast what a search finds, and when, before anybody moves.
///
/// Simulates missions whose objects are drawn from the prior, and prints the probability of success over time for teams
/// of several sizes: the share of the objects that is found by then, in the mean; with one object the probability that it is
/// found. Where regions leave a part of the probability to the rest of the world, that part is never found.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet forecast missing_person
  dragnet forecast area.kml --robots 1,2,4,8
  dragnet forecast missing_person --policy tour --seeds 500 --json")]
pub(crate) struct Arguments {
    /// Scenario file (TOML), a map, or a name that `dragnet scenarios` lists
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    #[command(flatten)]
    prior: PriorFrom,
    /// Numbers of robots, 1 to 1000 each, separated by commas [default: half as many as in the scenario, as many, and
    /// twice as many]
    #[arg(long, value_name = "N,..", value_delimiter = ',', allow_negative_numbers = true)]
    robots: Vec<u32>,
    /// Policy of all robots, instead of the scenario's; parameters in parentheses
    #[arg(long, value_name = "POLICY", value_parser = scenario::POLICY)]
    policy: Option<PolicyField>,
    /// Missions for each team, by their seeds: N for 0 to N - 1, or A..B for A to B - 1
    #[arg(long, value_name = "N | A..B", default_value = "100", allow_negative_numbers = true)]
    seeds: Seeds,
    /// Number of missions to run in parallel, 1 to 1024 [default: the number of cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Json<'a> {
    scenario: &'a str,
    policy: String,
    teams: &'a [Forecast],
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let loaded = arguments.prior.load(&arguments.scenario)?;
    let policy = arguments.policy.clone();
    let scenario = scenario::with(loaded, "--policy", policy, Scenario::with_local_policy)?;
    scenario::warn(&scenario);
    earlier::tell(&scenario);
    let teams = teams(&scenario, &arguments.robots)?;
    let done = forecast(&teams, arguments.seeds, arguments.threads, &Bars)?;
    if arguments.json {
        let policy = scenario::policies(&scenario);
        let json = Json { scenario: scenario.name(), policy, teams: &done.results };
        return Ok(terminal::print_json(&json)?);
    }
    Ok(terminal::print(&text(&scenario, &done.results, arguments.seeds, done.effort))?)
}

/// The scenario with each number of robots; by default those numbers around the scenario's own that it allows.
fn teams(scenario: &Scenario, robots: &[u32]) -> Result<Vec<Scenario>, Failure> {
    if !robots.is_empty() {
        let with = |&count| scenario::with(scenario.clone(), "--robots", Some(count), Scenario::with_robots);
        return robots.iter().map(with).collect();
    }
    let count = u32::try_from(scenario.robots().len()).unwrap_or(u32::MAX);
    let mut counts = vec![count.div_ceil(2), count, count.saturating_mul(2)];
    counts.dedup();
    // A scenario that names its robots may not do with fewer.
    Ok(counts.into_iter().filter_map(|count| scenario.with_robots(count).ok()).collect())
}

fn text(scenario: &Scenario, forecasts: &[Forecast], seeds: Seeds, effort: Effort) -> String {
    let Some(first) = forecasts.first() else { return String::new() };
    let on_map = if first.on_map < 1.0 {
        format!("; {:.0} % of the probability is outside of the area", 100.0 * (1.0 - first.on_map))
    } else {
        String::new()
    };
    let missions: u64 = seeds.count() * forecasts.len() as u64;
    let missions = counted(usize::try_from(missions).unwrap_or(usize::MAX), "mission");
    format!(
        "{}: {}, policy {}, {} to search{on_map}\n{seeds}: {missions} {}\n\n{}\n\
         success: mean share of the objects that is found by then, with its 95 % interval; with one\n\
         object the probability that it is found. ends: when the last robot rests, in the mean.\n",
        scenario.name(),
        scenario.objects(),
        scenario::policies(scenario),
        clock(first.budget_seconds),
        terminal::effort(effort),
        table(forecasts).draw(1),
    )
}

fn table(forecasts: &[Forecast]) -> Table {
    let reached = PROBABILITIES.map(|probability| format!("{:.0} % after", 100.0 * probability));
    let [half, most, nearly_all] = reached.each_ref().map(String::as_str);
    let mut table =
        Table::new(["robots", "success at half time", "at the end", half, most, nearly_all, "ends"]);
    for forecast in forecasts {
        let success = [forecast.success_at_half, forecast.success];
        let [at_half, at_end] = success.map(percent);
        let [half, most, nearly_all] =
            forecast.seconds_to.map(|seconds| seconds.map_or_else(|| "never".to_owned(), clock));
        let ends = clock(forecast.end_seconds.mean);
        table.push([forecast.robots.to_string(), at_half, at_end, half, most, nearly_all, ends]);
    }
    table
}

/// `93 % (86 to 97)`.
fn percent(Probability { mean, low, high }: Probability) -> String {
    format!("{:.0} % ({:.0} to {:.0})", 100.0 * mean, 100.0 * low, 100.0 * high)
}

/// `45 s`, `12 min`, `3 h 05 min`.
fn clock(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round();
    if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else if minutes < 60.0 {
        format!("{minutes:.0} min")
    } else {
        format!("{:.0} h {:02.0} min", (minutes / 60.0).floor(), minutes % 60.0)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scenario(robots: &str) -> Scenario {
        let text = format!(
            "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 5, columns = 5, cell_meters = 2.0 }}\n\
             sensor.radius = 2\nobjects.count = 1\nmission.budget_seconds = 300.0\n[robots]\n{robots}"
        );
        Scenario::from_text(Path::new("a.toml"), text).unwrap()
    }

    fn sizes(scenario: &Scenario, robots: &[u32]) -> Vec<usize> {
        teams(scenario, robots).unwrap().iter().map(|team| team.robots().len()).collect()
    }

    #[test]
    fn teams_are_those_around_the_scenarios_own_or_those_that_are_asked_for() {
        assert_eq!(sizes(&scenario("count = 3"), &[]), [2, 3, 6]);
        assert_eq!(sizes(&scenario("count = 1"), &[]), [1, 2]);
        assert_eq!(sizes(&scenario("count = 4\nrobot = [{ number = 4, start = [0, 0] }]"), &[]), [4, 8]);
        assert_eq!(sizes(&scenario("count = 3"), &[5, 1]), [5, 1]);
        assert!(teams(&scenario("count = 3"), &[0]).is_err());
    }

    #[test]
    fn a_probability_has_its_interval_beside_it() {
        assert_eq!(percent(Probability { mean: 1.0, low: 0.7225, high: 1.0 }), "100 % (72 to 100)");
    }

    #[test]
    fn times_are_in_the_unit_that_people_say_them_in() {
        let said = [0.0, 119.0, 121.0, 3_560.0, 3_580.0, 7_300.0].map(clock);
        assert_eq!(said, ["0 s", "119 s", "2 min", "59 min", "1 h 00 min", "2 h 02 min"]);
    }
}
