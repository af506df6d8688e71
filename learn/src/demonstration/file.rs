//! A trajectory as a file.

use std::path::Path;
use std::sync::Arc;

use dragnet_files::FileError;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::route::Connectivity;
use dragnet_search::sensor::{Noise, Sensor};
use dragnet_search::terrain::{Ground, Terrain};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::{Demonstration, Source, Trajectory};
use crate::file::{self, Kind, Tensor, Tensors};

/// Without a limit: their size depends on the map and on the length of the search.
pub(super) const KIND: Kind =
    Kind { name: "demonstrations", format: "dragnet-demonstrations-2", max_bytes: u64::MAX };

#[derive(Serialize, Deserialize)]
struct Header {
    #[serde(flatten)]
    source: Source,
    scenario: String,
    scenario_digest: String,
    seed: u64,
    decisions: usize,
    rows: u32,
    columns: u32,
    cell_meters: f64,
    /// 4 or 8.
    connectivity: u8,
    radius: u32,
    noise_variance: f64,
    /// The radius within which walls hide what is behind them, cells, if they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    line_of_sight_radius: Option<u32>,
    /// The numbers of the cells that walls thinner than a cell lead along, if they hide what is behind them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    thin_walls: Vec<u32>,
}

/// Writes a trajectory; the file appears when it is complete, replacing an older one.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, trajectory: &Trajectory) -> Result<(), FileError> {
    let bytes = to_bytes(trajectory).map_err(|reason| FileError::content(path, reason))?;
    dragnet_files::write(path, &bytes)
}

/// Reads a trajectory.
///
/// # Errors
/// If the file cannot be read, is truncated, has another format, or contains invalid values.
pub fn read(path: &Path) -> Result<Trajectory, FileError> {
    file::read(KIND, path, from_bytes)
}

fn to_bytes(trajectory: &Trajectory) -> Result<Vec<u8>, String> {
    let grid = trajectory.terrain.grid();
    let header = Header {
        source: trajectory.source.clone(),
        scenario: trajectory.scenario.clone(),
        scenario_digest: trajectory.scenario_digest.clone(),
        seed: trajectory.seed,
        decisions: trajectory.decisions.len(),
        rows: grid.rows(),
        columns: grid.columns(),
        cell_meters: trajectory.terrain.cell_meters(),
        connectivity: if trajectory.connectivity == Connectivity::Four { 4 } else { 8 },
        radius: trajectory.sensor.radius(),
        noise_variance: trajectory.sensor.noise_variance(),
        line_of_sight_radius: trajectory.terrain.line_of_sight().radius(),
        thin_walls: match trajectory.terrain.line_of_sight().radius() {
            Some(_) => trajectory.terrain.thin_walls().iter().map(|cell| cell.number()).collect(),
            None => Vec::new(),
        },
    };
    file::serialize(KIND, &header, &tensors(trajectory))
}

fn tensors(trajectory: &Trajectory) -> Vec<Tensor> {
    let (grid, decisions) = (trajectory.terrain.grid(), &trajectory.decisions);
    let (count, cells) = (decisions.len(), grid.cell_count());
    let tensor = |name: &str, dtype, shape: &[usize], bytes| Tensor {
        name: name.to_owned(),
        dtype,
        shape: shape.to_vec(),
        bytes,
    };
    let ground = grid.cells().map(|cell| {
        let Ground { traversable, searched } = trajectory.terrain.ground(cell);
        u8::from(traversable) + 2 * u8::from(searched)
    });
    let of_cell = |name: &str, cell: fn(&Demonstration) -> Cell| {
        let bytes = decisions.iter().flat_map(|decision| cell(decision).number().to_le_bytes()).collect();
        tensor(name, Dtype::U32, &[count], bytes)
    };
    let of_cells = |name: &str, values: fn(&Demonstration) -> &[f32]| {
        let values: Vec<f32> = decisions.iter().flat_map(values).copied().collect();
        Tensor::of_floats(name.to_owned(), vec![count, cells], &values)
    };
    let mut tensors = vec![
        tensor("ground", Dtype::U8, &[grid.rows() as usize, grid.columns() as usize], ground.collect()),
        of_cell("robot", |it| it.robot),
        of_cell("chosen", |it| it.chosen),
        of_cells("log_odds_nats", |it| &it.log_odds_nats),
        of_cells("scores", |it| &it.scores),
    ];
    // Plans are written only if there are any; a single robot has none.
    if decisions.iter().any(|decision| decision.planned_precision.is_anything()) {
        let of_decision = |decision: &Demonstration| {
            grid.cells().map(|cell| decision.planned_precision.precision(cell)).collect()
        };
        let precision: Vec<i64> =
            decisions.iter().flat_map(|decision| -> Vec<i64> { of_decision(decision) }).collect();
        let bytes = precision.iter().flat_map(|precision| precision.to_le_bytes()).collect();
        tensors.push(tensor("planned_precision", Dtype::I64, &[count, cells], bytes));
    }
    tensors
}

fn from_bytes(bytes: &[u8]) -> Result<Trajectory, String> {
    let (header, tensors): (Header, _) = file::parse(KIND, bytes)?;
    let grid = Grid::new(header.rows, header.columns).map_err(|error| error.to_string())?;
    let shape = [grid.rows() as usize, grid.columns() as usize];
    let ground = tensors.get("ground", Dtype::U8, &shape)?;
    let ground = ground.iter().map(|byte| Ground { traversable: byte & 1 > 0, searched: byte & 2 > 0 });
    let terrain =
        Terrain::new(grid, header.cell_meters, ground.collect()).map_err(|error| error.to_string())?;
    let sensor = Sensor::new(header.radius, header.noise_variance, Noise::Gaussian)
        .map_err(|error| error.to_string())?;
    let terrain = match header.line_of_sight_radius {
        Some(radius) if radius == 0 || LineOfSight::is_too_large(grid, radius) => {
            return Err(format!("line_of_sight_radius {radius}: the map is too large for it, or it is 0"));
        }
        Some(radius) => {
            let cell = |&number: &u32| {
                grid.cell_numbered(number).ok_or_else(|| format!("thin_walls: {number}: no cell of the map"))
            };
            let thin = header.thin_walls.iter().map(cell).collect::<Result<Vec<_>, _>>()?;
            terrain.with_thin_walls(thin).with_opaque_walls(radius)
        }
        None => terrain,
    };
    let reader = Reader { tensors, terrain: &terrain, count: header.decisions };
    let decisions = reader.decisions()?;
    Ok(Trajectory {
        source: header.source,
        scenario: header.scenario,
        scenario_digest: header.scenario_digest,
        seed: header.seed,
        connectivity: match header.connectivity {
            4 => Connectivity::Four,
            8 => Connectivity::Eight,
            other => return Err(format!("connectivity {other}: allowed are 4 and 8")),
        },
        sensor: Arc::new(sensor),
        decisions,
        terrain: Arc::new(terrain),
    })
}

/// The decisions of a file that should have this many.
struct Reader<'a> {
    tensors: Tensors<'a>,
    terrain: &'a Terrain,
    count: usize,
}

impl Reader<'_> {
    fn decisions(&self) -> Result<Vec<Demonstration>, String> {
        let (count, cells) = (self.count, self.terrain.grid().cell_count());
        let of_cells = |name: &str| {
            let values = self.tensors.floats(name, &[count, cells])?;
            match values.iter().position(|value| value.is_nan()) {
                Some(place) => Err(format!("{name} holds NaN at place {place}")),
                None => Ok(values),
            }
        };
        let (log_odds, scores) = (of_cells("log_odds_nats")?, of_cells("scores")?);
        let (robot, chosen) = (self.positions("robot")?, self.positions("chosen")?);
        let mut planned_precision = self.planned_precision()?.into_iter();
        let decisions = (0..count).map(|place| Demonstration {
            log_odds_nats: log_odds[place * cells..][..cells].to_vec(),
            planned_precision: planned_precision
                .next()
                .unwrap_or_else(|| PlannedPrecision::nothing(self.terrain)),
            robot: robot[place],
            chosen: chosen[place],
            scores: scores[place * cells..][..cells].to_vec(),
        });
        Ok(decisions.collect())
    }

    /// A traversable cell for each decision.
    fn positions(&self, name: &str) -> Result<Vec<Cell>, String> {
        let bytes = self.tensors.get(name, Dtype::U32, &[self.count])?;
        let numbers = bytes.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
        numbers
            .map(|number| {
                let cell = self.terrain.grid().cell_numbered(number);
                cell.filter(|&cell| self.terrain.is_traversable(cell))
                    .ok_or_else(|| format!("{name} {number} is no traversable cell of the map"))
            })
            .collect()
    }

    /// The planned precision of each decision; empty if the file has none.
    fn planned_precision(&self) -> Result<Vec<PlannedPrecision>, String> {
        if !self.tensors.has("planned_precision") {
            return Ok(Vec::new());
        }
        let cells = self.terrain.grid().cell_count();
        let bytes = self.tensors.get("planned_precision", Dtype::I64, &[self.count, cells])?;
        let precision: Vec<i64> =
            bytes.as_chunks::<8>().0.iter().map(|bytes| i64::from_le_bytes(*bytes)).collect();
        let of_decision = |precision: &[i64]| {
            PlannedPrecision::from_precision(precision.to_vec())
                .ok_or_else(|| "planned_precision is below 0".to_owned())
        };
        precision.chunks(cells).map(of_decision).collect()
    }
}
