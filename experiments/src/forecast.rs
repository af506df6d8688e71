//! What a search is expected to find, and when, before anybody moves.
//!
//! A forecast is the mean of simulated missions: their objects are drawn from the prior, and the robots decide again with
//! what they see, so that it is not bound to one plan. It is as good as the prior and the sensor's model are.

use std::time::Duration;

use dragnet_scenario::Scenario;
use dragnet_search::measures::Curve;
use dragnet_search::utility::UtilityTable;
use dragnet_sim::comparison::Estimate;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::simulation::End;
use serde::Serialize;

use crate::ExperimentError;
use crate::jobs::{self, Done};
use crate::progress::Progress;
use crate::seeds::Seeds;

pub use probability::Probability;

mod probability;

/// Probabilities of success whose time is forecast.
pub const PROBABILITIES: [f64; 3] = [0.5, 0.8, 0.95];
/// Times of a curve: from the start to the end of the budget, in equal steps.
const CURVE_STEPS: u32 = 60;

/// The forecast for a team. Names are those of the JSON object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// Robots of the team.
    pub robots: usize,
    /// Missions that count: those with at least one object, or all if the number of subjects is known.
    pub missions: usize,
    /// From the start to the end of the budget, seconds.
    pub budget_seconds: f64,
    /// Probability that an object is on the map at all; below 1 where subjects may be in the rest of the world, or regions leave a part to it.
    pub on_map: f64,
    /// Probability of success at half of the budget.
    pub success_at_half: Probability,
    /// Probability of success at the end of the budget.
    pub success: Probability,
    /// When the probability of success reaches each of [`PROBABILITIES`], seconds; `None` if it does not in the budget.
    pub seconds_to: [Option<f64>; PROBABILITIES.len()],
    /// When the last robot rests, mean over missions, seconds.
    pub end_seconds: Estimate,
    /// `[seconds, probability of success]`, from the start to the end of the budget.
    pub curve: Vec<[f64; 2]>,
}

/// One simulated mission.
struct Mission {
    /// Share of its objects that can be found, times that which was found, over the time in seconds; `None` if there
    /// was no object, and their number is not known.
    found: Option<(f64, Curve)>,
    end_seconds: f64,
}

/// Forecasts for the teams of these scenarios, from missions with these seeds. They do not depend on the number of
/// threads.
///
/// The probability of success at a time is the mean, over missions, of the share of the objects that are found by then:
/// with one object the probability that it is.
///
/// # Errors
/// If no mission had an object, or the system provides no threads.
pub fn forecast(
    teams: &[Scenario],
    seeds: Seeds,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Done<Forecast>, ExperimentError> {
    UtilityTable::warm_up();
    let with_seeds = |team| (0..seeds.count()).map(move |place| (team, seeds.at(place)));
    let missions: Vec<(&Scenario, u64)> = teams.iter().flat_map(with_seeds).collect();
    let done = jobs::run(&missions, threads, "missions", progress, |&(scenario, seed)| {
        let episode = episode::run(scenario, seed, End::Resting).map_err(ExperimentError::run)?;
        Ok(Mission::of(scenario, episode))
    })?;
    let of_teams = done.results.chunks(done.results.len() / teams.len().max(1));
    let forecasts = teams.iter().zip(of_teams).map(|(scenario, missions)| Forecast::of(scenario, missions));
    Ok(Done { results: forecasts.collect::<Result<_, _>>()?, effort: done.effort })
}

impl Mission {
    fn of(scenario: &Scenario, episode: Episode) -> Self {
        let objects = episode.truth.objects();
        let in_reach = objects.iter().filter(|&&object| episode.reach.covers(object)).count();
        // Subjects who are outside of the area are sought too, and never found.
        let sought = scenario.subjects().map_or(objects.len(), |subjects| subjects.number() as usize);
        let found = (sought > 0).then(|| (in_reach as f64 / sought as f64, episode.outcome.recall_over_time));
        Self { found, end_seconds: episode.outcome.ended.as_seconds() }
    }

    /// Share of the objects found by this time, seconds; `None` if there are none.
    fn found(&self, seconds: f64) -> Option<f64> {
        let found = |(in_reach, recall): &(f64, Curve)| {
            // Without an object in reach there is no recall.
            if *in_reach > 0.0 { in_reach * recall.at(seconds) } else { 0.0 }
        };
        self.found.as_ref().map(found)
    }
}

impl Forecast {
    fn of(scenario: &Scenario, missions: &[Mission]) -> Result<Self, ExperimentError> {
        let count = missions.iter().filter(|mission| mission.found.is_some()).count();
        if count == 0 {
            let name = scenario.name();
            return Err(ExperimentError::Input(format!(
                "{name}: no mission had an object: allowed are more seeds, or objects.count of at least 1"
            )));
        }
        let on_map = on_map(scenario);
        // Where their number is known, missions are drawn with the subjects that are outside.
        let drawn_on_map = if scenario.subjects().is_some() { 1.0 } else { on_map };
        let budget_seconds = budget_seconds(scenario);
        let success = |seconds: f64| {
            Probability::of(missions.iter().filter_map(|mission| mission.found(seconds))).times(drawn_on_map)
        };
        let time = |step: u32| budget_seconds * f64::from(step) / f64::from(CURVE_STEPS);
        let curve: Vec<[f64; 2]> =
            (0..=CURVE_STEPS).map(|step| [time(step), success(time(step)).mean]).collect();
        Ok(Self {
            robots: scenario.robots().len(),
            missions: count,
            budget_seconds,
            on_map,
            success_at_half: success(budget_seconds / 2.0),
            success: success(budget_seconds),
            seconds_to: PROBABILITIES.map(|probability| reached(&curve, probability)),
            end_seconds: Estimate::of(missions.iter().map(|mission| mission.end_seconds)),
            curve,
        })
    }
}

/// When a curve first reaches a probability, between its points in a straight line.
fn reached(curve: &[[f64; 2]], probability: f64) -> Option<f64> {
    if curve.first()?[1] >= probability {
        return Some(curve[0][0]);
    }
    let [[from, below], [to, above]] =
        curve.windows(2).map(|pair| [pair[0], pair[1]]).find(|[_, end]| end[1] >= probability)?;
    Some(from + (to - from) * (probability - below) / (above - below))
}

/// The probability that subjects, or regions, leave on the map.
fn on_map(scenario: &Scenario) -> f64 {
    if let Some(subjects) = scenario.subjects() {
        return 1.0 - subjects.rest_of_world();
    }
    match scenario.claims() {
        Some(claims) if claims.rest.cells == 0 => 1.0 - claims.rest.poa,
        _ => 1.0,
    }
}

/// The time that the budget lasts, seconds: that of the path length where there is no budget of time. Of unlike robots the longest.
fn budget_seconds(scenario: &Scenario) -> f64 {
    let seconds = scenario.robots().iter().map(|robot| {
        let mission = scenario.mission().of(&robot.class);
        mission.remaining_meters(0.0, Duration::ZERO) / mission.speed_meters_per_second
    });
    seconds.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::progress::Work;

    struct Silent;

    impl Progress for Silent {
        fn begin(&self, _steps: u64, _unit: &str) -> Box<dyn Work> {
            Box::new(Self)
        }
    }

    impl Work for Silent {
        fn advance(&self, _steps: u64) {}
    }

    fn team(rest: &str) -> Scenario {
        let text = format!(
            "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 6, columns = 6, cell_meters = 10.0 }}\n\
             sensor.radius = 2\nmission.budget_seconds = 200.0\nrobots.start = [0, 0]\n{rest}"
        );
        Scenario::from_text(Path::new("a.toml"), text).unwrap()
    }

    fn forecasts(teams: &[Scenario], missions: &str, threads: u16) -> Result<Vec<Forecast>, ExperimentError> {
        forecast(teams, missions.parse().unwrap(), Some(threads), &Silent).map(|done| done.results)
    }

    #[test]
    fn success_rises_with_time_and_robots_and_no_result_depends_on_threads() {
        let one = team("objects.count = 1\n");
        let teams = [one.clone(), one.with_robots(3).unwrap()];
        let made = forecasts(&teams, "40", 1).unwrap();
        assert_eq!(made, forecasts(&teams, "40", 2).unwrap());
        for forecast in &made {
            assert_eq!((forecast.missions, forecast.budget_seconds, forecast.on_map), (40, 200.0, 1.0));
            assert!(
                forecast
                    .curve
                    .windows(2)
                    .all(|pair| pair[0][0] < pair[1][0] && pair[0][1] <= pair[1][1] + 0.05)
            );
            assert!(forecast.success.mean > 0.9 && forecast.end_seconds.mean < 200.0, "{forecast:?}");
            assert!(forecast.success.low < 0.95 && forecast.success.low > 0.7, "{forecast:?}");
        }
        assert!(made[1].seconds_to[1] < made[0].seconds_to[1], "{made:?}");
        assert_eq!([made[0].robots, made[1].robots], [1, 3]);
    }

    #[test]
    fn missions_without_objects_do_not_count_and_without_any_there_is_no_forecast() {
        let sparse = team("objects.density = 0.01\n");
        let made = forecasts(&[sparse], "30", 2).unwrap();
        assert!((1..30).contains(&made[0].missions), "{made:?}");
        let error = forecasts(&[team("objects.count = 0\n")], "3", 1).unwrap_err().to_string();
        assert!(error.contains("no mission had an object") && error.contains("objects.count"), "{error}");
    }

    /// Nine of ten are outside: most missions find nobody, and count.
    #[test]
    fn subjects_who_may_be_outside_are_found_accordingly_less() {
        for number in [1, 3] {
            let teams = [0.0, 0.9]
                .map(|rest| team(&format!("objects.count = {number}\nprior.rest_of_world = {rest:?}\n")));
            let [here, outside] = &forecasts(&teams, "100", 2).unwrap()[..] else { panic!("two teams") };
            assert_eq!((outside.missions, here.on_map), (100, 1.0));
            assert!((outside.on_map - 0.1).abs() < 1e-12, "{outside:?}");
            assert!(here.success.mean > 0.8 && outside.success.mean < 0.2, "{here:?} {outside:?}");
        }
    }

    #[test]
    fn a_probability_is_reached_between_two_points_or_never() {
        let curve = [[0.0, 0.0], [10.0, 0.4], [20.0, 0.6]];
        let times = [0.0, 0.4, 0.5, 0.7].map(|probability| reached(&curve, probability));
        assert_eq!(times, [Some(0.0), Some(10.0), Some(15.0), None]);
    }
}
