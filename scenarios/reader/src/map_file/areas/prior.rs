//! The prior of regions, as probabilities of independent cells.
//!
//! A region has a probability of area `POA`: that an object is inside. With `N` objects expected in total, a cell `c`
//! holds one with the probability
//!
//! ```text
//! p(c) = N sum over regions r of POA(r) w(r, c) + N rest(c),      sum over c of w(r, c) = 1
//! ```
//!
//! where `w` is the share of the cell that a polygon covers, or the mass of a distribution by distance in it (`by_distance`,
//! or a normal one), of searched cells only. The remaining probability, `1 - sum POA`, is spread evenly over the searched cells outside all polygons;
//! if there are none it lies beyond the map.

use std::path::Path;

use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::terrain::Terrain;
use geo::{Area as _, BooleanOps, CoordsIter, MapCoords, MultiPolygon, Polygon};

use super::{Area, Areas, Purpose, Spread, by_distance};
use crate::map_file::MapFileError;
use crate::map_file::georeference::{GeoPoint, Georeference};
use crate::map_file::scanline::covered_cells;
use crate::map_file::union::union;

/// Standard deviations at which a normal distribution is cut off: less than 1e-14 lies beyond.
const SPREADS: f64 = 8.0;
/// Least share of distances on searched ground: with less, the place or the line is elsewhere.
const LEAST_SHARE: f64 = 0.01;
/// Tolerance for the sum of rounded shares.
const WHOLE: f64 = 1.0 + 1e-9;

/// The prior computed from regions of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionPrior {
    /// Prior probability of an object, shape `[cells]`, from 0 to below 1.
    pub probability: Vec<f64>,
    /// The parts of the regions.
    pub claims: Claims,
}

/// The parts of the probability that regions claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Claims {
    /// The part of each region.
    pub regions: Vec<Region>,
    /// The remaining part.
    pub rest: Rest,
}

/// A region on a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// Probability of area, a share from 0 to 1.
    pub poa: f64,
    /// Number of searched cells that it touches.
    pub cells: usize,
    /// Share of its mass on searched cells, 0 to 1.
    pub searched_share: f64,
}

/// The probability that no region claims.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// A share from 0 to 1.
    pub poa: f64,
    /// Number of searched cells outside all polygons, over which it is spread; if 0 it lies beyond the map.
    pub cells: usize,
}

/// The distribution of an area's mass over a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// Searched cells that it touches, by index, at least one: the share of each that a polygon covers, or the mass of a
    /// distribution by distance in it, above 0.
    pub shares: Vec<(Cell, f64)>,
    /// Share of the area's mass on them, 0 to 1.
    pub searched_share: f64,
}

impl Weights {
    /// The cells of [`Weights::shares`] with weights that sum to 1.
    pub fn cells(&self) -> impl Iterator<Item = (Cell, f64)> + '_ {
        let sum: f64 = self.shares.iter().map(|(_, share)| share).sum();
        self.shares.iter().map(move |&(cell, share)| (cell, share / sum))
    }
}

impl Areas {
    /// The prior of all regions and last known positions on a map with this number of expected objects; `None` if there
    /// are none. Messages name the file.
    ///
    /// # Errors
    /// If a region is far from the map or touches no searched cell, the sum of all is above 1, or a cell would be
    /// certain.
    pub fn prior(
        &self,
        file: &Path,
        frame: &Georeference,
        terrain: &Terrain,
        expected_objects: f64,
    ) -> Result<Option<RegionPrior>, MapFileError> {
        let claims: Vec<(&Area, f64)> =
            self.areas.iter().filter_map(|area| Some((area, area.purpose.poa()?))).collect();
        if claims.is_empty() {
            return Ok(None);
        }
        let rest = 1.0 - claims.iter().map(|(_, poa)| poa).sum::<f64>();
        if rest < 1.0 - WHOLE {
            let found = format!("{:.6}", 1.0 - rest);
            return Err(MapFileError::value(file, "the sum of all poa", found, "at most 1, which is 100%"));
        }
        let mut prior = RegionPrior {
            probability: vec![0.0; terrain.grid().cell_count()],
            claims: Claims { regions: Vec::new(), rest: Rest { poa: rest.max(0.0), cells: 0 } },
        };
        let mut is_claimed = vec![false; terrain.grid().cell_count()];
        for (area, poa) in claims {
            let weights = area.weights(file, frame, terrain)?;
            for (cell, weight) in weights.cells() {
                prior.probability[cell.index()] += expected_objects * poa * weight;
                is_claimed[cell.index()] |= matches!(area.purpose, Purpose::Prior { .. });
            }
            check_uncertain(file, area, &weights, &prior.probability)?;
            let (cells, searched_share) = (weights.shares.len(), weights.searched_share);
            prior.claims.regions.push(Region { name: area.name.clone(), poa, cells, searched_share });
        }
        prior.spread_rest(file, terrain, &is_claimed, expected_objects)?;
        Ok(Some(prior))
    }
}

impl Areas {
    /// The share of the search areas' ground that no region covers, 0 to 1; 0 with a last known position or a linear feature,
    /// which have no border.
    pub(crate) fn unclaimed_share(&self) -> f64 {
        let has_no_border = |area: &Area| {
            matches!(area.purpose, Purpose::LastKnownPosition { .. } | Purpose::LinearFeature { .. })
        };
        if self.areas.iter().any(has_no_border) {
            return 0.0;
        }
        let of = |is_of: fn(&Purpose) -> bool| -> Vec<&Polygon<f64>> {
            self.areas
                .iter()
                .filter(|area| is_of(&area.purpose))
                .flat_map(|area| area.purpose.polygons())
                .collect()
        };
        let searched = union(&of(|purpose| matches!(purpose, Purpose::Search(_))));
        let claimed = union(&of(|purpose| matches!(purpose, Purpose::Prior { .. })));
        let unclaimed = searched.difference(&claimed).unsigned_area();
        if searched.0.is_empty() { 0.0 } else { unclaimed / searched.unsigned_area() }
    }
}

impl RegionPrior {
    fn spread_rest(
        &mut self,
        file: &Path,
        terrain: &Terrain,
        is_claimed: &[bool],
        expected_objects: f64,
    ) -> Result<(), MapFileError> {
        let free: Vec<Cell> = terrain.searched_cells().filter(|cell| !is_claimed[cell.index()]).collect();
        self.claims.rest.cells = free.len();
        let objects = expected_objects * self.claims.rest.poa;
        for &cell in &free {
            let probability = &mut self.probability[cell.index()];
            *probability += objects / free.len() as f64;
            if *probability >= 1.0 {
                let found = format!("{objects:.3} objects in {} cells outside of all areas", free.len());
                let allowed = "a probability below 1: areas with more poa, smaller cells, or fewer objects";
                return Err(MapFileError::value(file, "the rest", found, allowed));
            }
        }
        Ok(())
    }
}

fn check_uncertain(
    file: &Path,
    area: &Area,
    weights: &Weights,
    probability: &[f64],
) -> Result<(), MapFileError> {
    let highest = weights.shares.iter().map(|(cell, _)| probability[cell.index()]).fold(0.0, f64::max);
    if highest < 1.0 {
        return Ok(());
    }
    let found = format!("a probability of {highest:.3} in one of {} cells", weights.shares.len());
    let allowed = "below 1: a larger area, smaller cells, or fewer objects";
    Err(MapFileError::value(file, area.place(), found, allowed))
}

impl Area {
    /// The distribution of its mass over a map. Messages name the file.
    ///
    /// # Errors
    /// If it is far from the map, or touches no searched cell.
    pub fn weights(
        &self,
        file: &Path,
        frame: &Georeference,
        terrain: &Terrain,
    ) -> Result<Weights, MapFileError> {
        self.check_near(file, frame)?;
        let cell_meters = terrain.cell_meters();
        let (mut cells, whole) = match &self.purpose {
            Purpose::Search(region) | Purpose::NoGo(region, _) | Purpose::Prior { region, .. } => {
                let region = region.map_coords(|corner| frame.cells(corner, cell_meters));
                (covered_cells(terrain.grid(), &rings(&region)), region.unsigned_area())
            }
            Purpose::LastKnownPosition { point, spread: Spread::Normal(meters), .. } => {
                let (east, north) = frame.meters(*point);
                let center = (east / cell_meters, north / cell_meters);
                (normal_cells(terrain.grid(), center, meters / cell_meters), 1.0)
            }
            Purpose::LastKnownPosition { point, spread: Spread::Quartiles(quartiles), .. } => {
                (by_distance::cells(terrain, &[[frame.meters(*point); 2]], quartiles), 1.0)
            }
            Purpose::LinearFeature { lines, quartiles, .. } => {
                let ends = lines.iter().flat_map(geo::LineString::lines);
                let ends = ends.map(|line| [line.start, line.end].map(|end| frame.meters(end.into())));
                (by_distance::cells(terrain, &ends.collect::<Vec<_>>(), quartiles), 1.0)
            }
            Purpose::Start(_) => (Vec::new(), 1.0),
        };
        cells.retain(|&(cell, share)| share > 0.0 && terrain.is_searched(cell));
        let sum: f64 = cells.iter().map(|(_, share)| share).sum();
        let has_quartiles = matches!(
            self.purpose,
            Purpose::LinearFeature { .. } | Purpose::LastKnownPosition { spread: Spread::Quartiles(_), .. }
        );
        if has_quartiles && sum < LEAST_SHARE {
            let found = format!("with {:.2} % of its distances on searched ground", 100.0 * sum);
            let allowed = format!("at least {:.0} %", 100.0 * LEAST_SHARE);
            return Err(MapFileError::value(file, self.place(), found, allowed));
        }
        if sum <= 0.0 {
            let allowed = "an area that touches at least one";
            return Err(MapFileError::value(file, self.place(), "on no searched cell", allowed));
        }
        Ok(Weights { shares: cells, searched_share: (sum / whole).min(1.0) })
    }

    /// Checks that no corner is too far from a map.
    pub(in crate::map_file) fn check_near(
        &self,
        file: &Path,
        frame: &Georeference,
    ) -> Result<(), MapFileError> {
        let far = self.corners().into_iter().find_map(|corner| frame.check_near(corner).err());
        far.map_or(Ok(()), |far| Err(MapFileError::value(file, self.place(), far, Georeference::NEAR)))
    }

    fn place(&self) -> String {
        format!("area {:?}", self.name)
    }

    fn corners(&self) -> Vec<GeoPoint> {
        match &self.purpose {
            Purpose::Search(region) | Purpose::Prior { region, .. } => {
                region.coords_iter().map(GeoPoint::from).collect()
            }
            Purpose::NoGo(region, lines) => {
                region.coords_iter().chain(lines.coords_iter()).map(GeoPoint::from).collect()
            }
            Purpose::LinearFeature { lines, .. } => lines.coords_iter().map(GeoPoint::from).collect(),
            Purpose::LastKnownPosition { point, .. } | Purpose::Start(point) => vec![*point],
        }
    }
}

/// The rings of polygons, holes included.
pub(in crate::map_file) fn rings(region: &MultiPolygon<f64>) -> Vec<Vec<(f64, f64)>> {
    let rings =
        region.iter().flat_map(|polygon| std::iter::once(polygon.exterior()).chain(polygon.interiors()));
    rings.map(|ring| ring.0.iter().map(|corner| (corner.x, corner.y)).collect()).collect()
}

/// Mass of a normal distribution in each cell, cells.
fn normal_cells(grid: Grid, (east, north): (f64, f64), spread: f64) -> Vec<(Cell, f64)> {
    let columns = masses(grid.columns(), east, spread);
    let rows = masses(grid.rows(), north, spread);
    let mut cells = Vec::new();
    for &(row, along) in &rows {
        for &(column, across) in &columns {
            cells.extend(grid.cell(Position { row, column }).map(|cell| (cell, along * across)));
        }
    }
    cells
}

/// Mass between the edges of each cell on a line, except for cells that are too far away.
fn masses(count: u32, center: f64, spread: f64) -> Vec<(u32, f64)> {
    let below = |edge: f64| 0.5 * libm::erfc((center - edge) / (spread * std::f64::consts::SQRT_2));
    (0..count)
        .filter(|&index| (f64::from(index) + 0.5 - center).abs() <= SPREADS * spread + 1.0)
        .map(|index| (index, below(f64::from(index) + 1.0) - below(f64::from(index))))
        .collect()
}
