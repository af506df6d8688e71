//! The robots of a scenario: policies and start cells.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;

use dragnet_learn::network::Network;
use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_learn::weights::Weights;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::policy::{AfterPattern, Parameters, Pattern, PolicyName as Exact};
use dragnet_search::utility::Utility;

use super::check::{self, Invalid};
use super::class::{Class, Classes};
use super::error::Fault;
use super::file::{PolicyField, PolicyTable, RobotsTable};
use super::start;
use crate::map_file::MapFile;

/// The largest team.
pub(super) const MAX_ROBOTS: u32 = 1000;

/// One robot of the team.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its number, from 1.
    pub id: RobotId,
    /// Its policy.
    pub policy: Policy,
    /// Its start cell.
    pub start: Start,
    /// What it can do.
    pub class: Arc<Class>,
}

/// A policy and its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Policy {
    /// The policy's name.
    pub name: PolicyName,
    /// Its parameters.
    pub parameters: Parameters,
    /// Number of cells after which it decides again; `None`: at the waypoint.
    pub replan_after_cells: Option<NonZeroU32>,
    /// The network of the weights file that the scenario names; `None`: the built-in one of a learned policy.
    pub network: Option<Arc<Network>>,
}

/// A policy with default parameters.
impl From<PolicyName> for Policy {
    fn from(name: PolicyName) -> Self {
        let replan_after_cells = name.replan_after_cells();
        Self { name, parameters: Parameters::default(), replan_after_cells, network: None }
    }
}

/// The start cell of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// In one random cell of a connected area, shared by all robots with this start.
    Together {
        /// Its place in [`Terrain::connected_areas`]: 0 is the largest.
        ///
        /// [`Terrain::connected_areas`]: dragnet_search::terrain::Terrain::connected_areas
        area: usize,
    },
    /// In a random cell of its own, in the largest connected area.
    Scattered,
    /// In this traversable cell.
    Cell(Cell),
}

/// The team, by number.
pub(super) fn robots(
    table: &RobotsTable,
    classes: &Classes,
    folder: &Path,
    map: &MapFile,
) -> Result<Vec<Robot>, Fault> {
    let count = check::integer("robots.count", table.count, 1, MAX_ROBOTS)?;
    let of_all = policy("robots.policy", &table.policy, folder)?;
    let class = match &table.class {
        Some(name) => classes.named("robots.class", name)?,
        None => Arc::clone(&classes.unnamed),
    };
    let start = start::of_team(table, count, &class, map)?;
    let team = RobotId::first(u16::try_from(count).unwrap_or(u16::MAX));
    let robot = |id: RobotId| Robot {
        id,
        policy: of_all.clone(),
        start: start(id.index()),
        class: Arc::clone(&class),
    };
    let mut robots: Vec<Robot> = team.map(robot).collect();
    let mut is_named = vec![false; robots.len()];
    for (index, differing) in table.robot.iter().enumerate() {
        let key = format!("robots.robot[{index}]");
        let place = check::integer(format!("{key}.number"), differing.number, 1, count)? as usize - 1;
        if std::mem::replace(&mut is_named[place], true) {
            let found = format!("{}, again", differing.number);
            return Err(Invalid::new(format!("{key}.number"), found, "each robot once").into());
        }
        if let Some(field) = &differing.policy {
            robots[place].policy = policy(&format!("{key}.policy"), field, folder)?;
        }
        if let Some(name) = &differing.class {
            robots[place].class = classes.named(&format!("{key}.class"), name)?;
        }
        if let Some(field) = &differing.start {
            let key = format!("{key}.start");
            robots[place].start = start::of_field(&key, field, &robots[place].class, map)?;
        }
    }
    Ok(robots)
}

fn policy(key: &str, field: &PolicyField, folder: &Path) -> Result<Policy, Fault> {
    match field {
        PolicyField::Name(name) => Ok(policy_name(key, name)?.into()),
        PolicyField::Table(table) => policy_table(key, table, folder),
    }
}

fn policy_name(key: &str, name: &str) -> Result<PolicyName, Invalid> {
    name.parse().map_err(|_| {
        let allowed = PolicyName::all().map(PolicyName::as_str).collect::<Vec<_>>().join(", ");
        Invalid::new(key, format!("{name:?}"), allowed)
    })
}

fn policy_table(key: &str, table: &PolicyTable, folder: &Path) -> Result<Policy, Fault> {
    let name = policy_name(&format!("{key}.name"), &table.name)?;
    let mut policy = Policy::from(name);
    if let Some(weight) = table.path_length_weight {
        let key = format!("{key}.path_length_weight");
        check_is_of(&key, check::written(weight), name, &[Exact::Path.into(), Exact::PathAdditive.into()])?;
        policy.parameters.path_length_weight = check::at_least_zero(key, weight, 1000.0)?;
    }
    if let Some(word) = &table.utility {
        let key = format!("{key}.utility");
        check_is_of(&key, format!("{word:?}"), name, &[Exact::Greedy.into(), Exact::Path.into()])?;
        policy.parameters.utility = one_of(key, word, Utility::ALL.map(|it| (it.as_str(), it)))?;
    }
    if let Some(word) = &table.pattern {
        let key = format!("{key}.pattern");
        check_is_of(&key, format!("{word:?}"), name, &[Exact::Coverage.into()])?;
        policy.parameters.pattern = one_of(key, word, Pattern::ALL.map(|it| (it.as_str(), it)))?;
    }
    if let Some(word) = &table.after_pattern {
        let key = format!("{key}.after_pattern");
        check_is_of(&key, format!("{word:?}"), name, &[Exact::Coverage.into()])?;
        policy.parameters.after_pattern = one_of(key, word, AfterPattern::ALL.map(|it| (it.as_str(), it)))?;
    }
    if let Some(cells) = table.lane_spacing_cells {
        let key = format!("{key}.lane_spacing_cells");
        check_is_of(&key, cells, name, &[Exact::Coverage.into()])?;
        policy.parameters.lane_spacing_cells = Some(check::integer(key, cells, 1, 1000)?);
    }
    if let Some(evaluations) = table.evaluations {
        let key = format!("{key}.evaluations");
        check_is_of(&key, evaluations, name, &[Exact::Tour.into()])?;
        policy.parameters.evaluations = check::integer(key, evaluations, 0, 1_000_000)?;
    }
    if let Some(cells) = table.replan_after_cells {
        let cells = check::integer(format!("{key}.replan_after_cells"), cells, 1, 1_000_000)?;
        policy.replan_after_cells = NonZeroU32::new(cells);
    }
    if let Some(file) = &table.weights {
        let key = format!("{key}.weights");
        check_is_of(&key, format!("{file:?}"), name, &[PolicyName::Learned(Shipped::General)])?;
        let weights = Weights::load(&folder.join(file)).map_err(|source| Fault::Weights { key, source })?;
        policy.network = Some(Arc::new(Network::new(&weights)));
    }
    Ok(policy)
}

/// The value of a word.
fn one_of<T: Copy, const COUNT: usize>(
    key: String,
    word: &str,
    allowed: [(&'static str, T); COUNT],
) -> Result<T, Invalid> {
    allowed
        .iter()
        .find(|(name, _)| *name == word)
        .map(|&(_, value)| value)
        .ok_or_else(|| Invalid::new(key, format!("{word:?}"), allowed.map(|(name, _)| name).join(", ")))
}

fn check_is_of(
    key: &str,
    value: impl std::fmt::Display,
    name: PolicyName,
    of: &[PolicyName],
) -> Result<(), Invalid> {
    if of.contains(&name) {
        return Ok(());
    }
    let allowed = of.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(" and ");
    Err(Invalid::new(key, format!("{value} for {name}"), format!("a value for {allowed} only")))
}
