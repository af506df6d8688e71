//! The files of a plan.

use dragnet_scenario::file::{MissionTable, NetworkTable, PriorTable, RecordingTable, ZenohTable};
use geojson::{FeatureCollection, GeoJson};
use serde::Serialize;
use toml::{Table, Value};

use crate::MissionPlan;

/// The two files of a plan, which lie in one folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanFiles {
    /// Name of the scenario's file.
    pub scenario_name: String,
    /// The scenario (TOML), which names the other file.
    pub scenario_text: String,
    /// Name of the areas' file.
    pub areas_name: String,
    /// The areas (`GeoJSON`).
    pub areas_text: String,
}

impl MissionPlan {
    /// The files of the plan; they say what the plan says, be it valid or not. Their names are plain names if that of
    /// the mission is valid.
    #[must_use]
    pub fn files(&self) -> PlanFiles {
        let name = &self.scenario.name;
        let (scenario_name, areas_name) = (format!("{name}.toml"), format!("{name}.geojson"));
        let mut scenario = self.scenario.clone();
        scenario.map.file = Some(areas_name.clone());
        let collection =
            FeatureCollection { bbox: None, features: self.features.clone(), foreign_members: None };
        PlanFiles {
            scenario_text: format!(
                "# Planned with `dragnet plan`. `dragnet schema` describes all keys.\n{}",
                text(&scenario)
            ),
            areas_text: GeoJson::FeatureCollection(collection).to_string_pretty().unwrap_or_default(),
            scenario_name,
            areas_name,
        }
    }
}

/// A scenario as TOML, without what is as by default and a plan does not show.
fn text(scenario: &impl Serialize) -> String {
    let mut table = Table::try_from(scenario).unwrap_or_default();
    let defaults = [
        ("network", of(&NetworkTable::default())),
        ("recording", of(&RecordingTable::default())),
        ("zenoh", of(&ZenohTable::default())),
        ("prior", of(&PriorTable::default())),
    ];
    for (key, usual) in defaults {
        table.retain(|name, value| name != key || value.as_table() != Some(&usual));
    }
    if let Some(mission) = table.get_mut("mission").and_then(Value::as_table_mut) {
        let usual = of(&MissionTable::default());
        mission.retain(|name, value| name == "speed_meters_per_second" || usual.get(name) != Some(value));
    }
    toml::to_string(&table).unwrap_or_default()
}

fn of(table: &impl Serialize) -> Table {
    Table::try_from(table).unwrap_or_default()
}
