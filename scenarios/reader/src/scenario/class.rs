//! Classes of robots: what unlike robots of a team can do.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use dragnet_search::cell::Grid;
use dragnet_search::reach::Sight;
use dragnet_search::sensor::Sensor;

use super::check::Invalid;
use super::file::{ClassTable, ScenarioFile};
use super::mission::{Budget, Mission};
use super::{check_name, world};

/// The longest time that a robot is waited for over one step, however slow it is.
const LONGEST_STEP_SECONDS: f64 = 3600.0;

/// What the robots of a class can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    /// Its name; `None` for the robots that are of no named class.
    pub name: Option<String>,
    /// Their sensor.
    pub sensor: Arc<Sensor>,
    /// Their speed, above 0; observations that imply a higher speed are rejected.
    pub speed_meters_per_second: f64,
    /// The budgets of path length and time of each.
    pub budget: Budget,
    /// Whether they cross cells that are not traversable.
    pub flies: bool,
}

impl Class {
    /// The duration of their longest move, a diagonal one, on cells of an edge in meters; at most an hour.
    #[must_use]
    pub fn step_time(&self, cell_meters: f64) -> Duration {
        let seconds = std::f64::consts::SQRT_2 * cell_meters / self.speed_meters_per_second;
        Duration::from_secs_f64(seconds.min(LONGEST_STEP_SECONDS))
    }

    /// What their reach depends on.
    #[must_use]
    pub fn sight(&self) -> Sight {
        let radius = self.sensor.radius();
        if self.flies { Sight::from_above(radius) } else { Sight::on_ground(radius) }
    }

    /// Path length that each may drive, meters: the budget of path length, or else the length in the budget of time.
    pub(super) fn budget_meters(&self) -> f64 {
        let seconds = self.budget.time().map_or(0.0, |time| time.as_secs_f64());
        self.budget.meters().unwrap_or(seconds * self.speed_meters_per_second)
    }

    /// The key of their speed.
    pub(super) fn speed_key(&self) -> String {
        let table = self.name.as_ref().map_or_else(|| "mission".to_owned(), |name| format!("classes.{name}"));
        format!("{table}.speed_meters_per_second")
    }
}

/// The named classes of a scenario, and the class of the other robots.
pub(super) struct Classes {
    pub(super) unnamed: Arc<Class>,
    named: BTreeMap<String, Arc<Class>>,
}

impl Classes {
    pub(super) fn new(file: &ScenarioFile, grid: Grid, mission: &Mission) -> Result<Self, Invalid> {
        let unnamed = Class {
            name: None,
            sensor: Arc::new(world::sensor("sensor", &file.sensor, grid)?),
            speed_meters_per_second: mission.speed_meters_per_second,
            budget: mission.budget,
            flies: false,
        };
        let named = file
            .classes
            .iter()
            .map(|(name, table)| Ok((name.clone(), Arc::new(class(file, grid, &unnamed, name, table)?))));
        Ok(Self { named: named.collect::<Result<_, Invalid>>()?, unnamed: Arc::new(unnamed) })
    }

    /// The class that a key names.
    pub(super) fn named(&self, key: &str, name: &str) -> Result<Arc<Class>, Invalid> {
        self.named.get(name).cloned().ok_or_else(|| {
            let names: Vec<&str> = self.named.keys().map(String::as_str).collect();
            let allowed = if names.is_empty() {
                "the name of a class, of which the scenario has none: [classes.NAME] makes one".to_owned()
            } else {
                names.join(", ")
            };
            Invalid::new(key, format!("{name:?}"), allowed)
        })
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &Class> {
        std::iter::once(&*self.unnamed).chain(self.named.values().map(|class| &**class))
    }
}

fn class(
    file: &ScenarioFile,
    grid: Grid,
    unnamed: &Class,
    name: &str,
    table: &ClassTable,
) -> Result<Class, Invalid> {
    let key = format!("classes.{name}");
    check_name(&format!("the name of {key}"), name)?;
    let mut sensor = file.sensor.clone();
    sensor.radius = table.sensor.radius.unwrap_or(sensor.radius);
    sensor.noise_variance = table.sensor.noise_variance.unwrap_or(sensor.noise_variance);
    let speed_key = format!("{key}.speed_meters_per_second");
    let speed = table.speed_meters_per_second.map(|speed| Mission::check_speed(&speed_key, speed));
    Ok(Class {
        name: Some(name.to_owned()),
        sensor: Arc::new(world::sensor(&format!("{key}.sensor"), &sensor, grid)?),
        speed_meters_per_second: speed.transpose()?.unwrap_or(unnamed.speed_meters_per_second),
        budget: unnamed.budget.with(&key, table.budget_meters, table.budget_seconds)?,
        flies: table.flies,
    })
}
