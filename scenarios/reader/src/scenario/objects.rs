//! The objects of a scenario.

use std::fmt;

use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::terrain::Terrain;

use super::check::{self, Invalid};
use super::file::ObjectsTable;

/// The objects of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub enum Objects {
    /// This number of objects, in searched cells drawn at random; at most the number of searched cells.
    Count(u32),
    /// Each searched cell holds one with this probability, above 0 and below 1, independently; the mean over cells where
    /// they are placed by the prior ([`super::Scenario::object_weights`]).
    Density(f64),
    /// In exactly these searched cells, by index, each once.
    Cells(Vec<Cell>),
}

impl Objects {
    pub(super) fn new(table: &ObjectsTable, terrain: &Terrain) -> Result<Self, Invalid> {
        match (table.count, table.density, &table.cells) {
            (Some(count), None, None) => {
                let searched = searched_count(terrain);
                Ok(Self::Count(check::integer("objects.count", count, 0, searched)?))
            }
            (None, Some(density), None) => {
                Ok(Self::Density(check::between("objects.density", density, 0.0, 1.0)?))
            }
            (None, None, Some(cells)) => object_cells(cells, terrain).map(Self::Cells),
            _ => {
                let given = [table.count.is_some(), table.density.is_some(), table.cells.is_some()];
                let found = format!("{} of them", given.into_iter().filter(|&given| given).count());
                let allowed = "exactly one of count, density and cells";
                Err(Invalid::new("objects", found, allowed))
            }
        }
    }

    /// How many objects there are, if that is known: one, if none is placed.
    pub(super) fn known_number(&self) -> Option<u32> {
        match self {
            Self::Count(count) => Some(*count),
            Self::Cells(cells) => Some(u32::try_from(cells.len()).unwrap_or(u32::MAX).max(1)),
            Self::Density(_) => None,
        }
    }

    /// Expected number of objects; for a known number by [`Objects::expected_density`].
    #[must_use]
    pub fn expected_count(&self, terrain: &Terrain) -> f64 {
        self.expected_density(terrain) * f64::from(searched_count(terrain))
    }

    /// Expected share of the searched cells that hold an object. For a given number of objects it is kept half an
    /// object away from 0 and from the number of cells, so that evidence can change it.
    #[must_use]
    pub fn expected_density(&self, terrain: &Terrain) -> f64 {
        let searched = f64::from(searched_count(terrain));
        let share = |count: f64| count.clamp(0.5, searched - 0.5) / searched;
        match self {
            Self::Count(count) => share(f64::from(*count)),
            Self::Density(density) => *density,
            Self::Cells(cells) => share(f64::from(u32::try_from(cells.len()).unwrap_or(u32::MAX))),
        }
    }
}

/// A description in words.
impl fmt::Display for Objects {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |count: usize| format!("{count} object{}", if count == 1 { "" } else { "s" });
        match self {
            Self::Count(count) => formatter.write_str(&counted(*count as usize)),
            Self::Density(density) => write!(formatter, "an object in {} % of the cells", density * 100.0),
            Self::Cells(cells) => write!(formatter, "{} in given cells", counted(cells.len())),
        }
    }
}

/// Whether objects are placed by the prior.
pub(super) fn is_by_prior(table: &ObjectsTable) -> Result<bool, Invalid> {
    let key = "objects.placement";
    match (table.placement.as_deref(), &table.cells) {
        (None | Some("prior"), None) => Ok(true),
        (Some("uniform"), None) | (None, Some(_)) => Ok(false),
        (Some(found), Some(_)) => Err(Invalid::new(key, format!("{found:?}"), "none with objects.cells")),
        (Some(found), None) => Err(Invalid::new(key, format!("{found:?}"), "\"prior\" or \"uniform\"")),
    }
}

/// The prior's probability of each cell, shape `[cells]`, 0 outside the searched ones; `None` if it is the same in all of
/// these, so that all places are alike.
///
/// # Errors
/// If fewer cells than objects have a chance.
pub(super) fn weights(
    objects: &Objects,
    prior: &Belief,
    terrain: &Terrain,
) -> Result<Option<Vec<f64>>, Invalid> {
    let mut weights = vec![0.0; terrain.grid().cell_count()];
    let mut searched = terrain.searched_cells();
    let first = searched.next().map(|cell| prior.log_odds_nats(cell));
    if searched.all(|cell| Some(prior.log_odds_nats(cell)) == first) {
        return Ok(None);
    }
    for cell in terrain.searched_cells() {
        weights[cell.index()] = prior.probability(cell);
    }
    let possible = weights.iter().filter(|&&weight| weight > 0.0).count();
    match *objects {
        Objects::Count(count) if count as usize > possible => {
            let allowed = format!(
                "at most {possible}, the cells in which the prior is above 0, or objects.placement = \"uniform\""
            );
            Err(Invalid::new("objects.count", count, allowed))
        }
        _ => Ok(Some(weights)),
    }
}

fn object_cells(fields: &[[i64; 2]], terrain: &Terrain) -> Result<Vec<Cell>, Invalid> {
    let mut cells = Vec::new();
    for (index, &field) in fields.iter().enumerate() {
        let key = format!("objects.cells[{index}]");
        let cell = check::cell(&key, field, terrain.grid())?;
        if !terrain.is_searched(cell) {
            return Err(Invalid::new(key, format!("{field:?}, not searched"), "a searched cell"));
        }
        cells.push((cell, index));
    }
    cells.sort_unstable();
    if let Some(pair) = cells.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let (_, index) = pair[1];
        let found = format!("{:?}, again", fields[index]);
        return Err(Invalid::new(format!("objects.cells[{index}]"), found, "each cell once"));
    }
    Ok(cells.into_iter().map(|(cell, _)| cell).collect())
}

fn searched_count(terrain: &Terrain) -> u32 {
    u32::try_from(terrain.searched_cells().count()).unwrap_or(u32::MAX)
}
