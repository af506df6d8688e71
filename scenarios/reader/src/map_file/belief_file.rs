//! Belief files, `.belief.json`: what a search believed in the end, as the prior of the next one.
//!
//! The next search may have another area and other cells. Both maps then need a position on the earth, and probability is
//! moved as object density per area. With `A` for areas, `P(i)` the probability of an old cell, and `own(j)` the scenario's own
//! prior of a new one,
//!
//! ```text
//! p(j) = sum over old cells i of P(i) A(i and j) / A(i)  +  own(j) (1 - sum over i of A(i and j) / A(j))
//! ```
//!
//! So what was in a cell that is split is shared out by area, what was in cells that are merged adds up, and a cell, or a part of
//! one, that was not searched before has the scenario's own prior. Old cells that were not searched count as absent.

use std::path::Path;

use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::subjects::Subjects;
use dragnet_search::terrain::Terrain;
use serde::{Deserialize, Serialize};

use super::georeference::{GeoPoint, Georeference};
use super::{MapFile, MapFileError, MapOrigin, read_text};

/// The ending of belief files.
const ENDING: &str = ".belief.json";
/// The version of the format.
const VERSION: u32 = 1;
/// Tolerance for equal lengths and angles.
const SAME: f64 = 1e-6;
/// Share of a cell that rounding may let another map touch.
const TOUCH: f64 = 1e-6;

/// What a search believed in the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeliefFile {
    /// Version of the format: 1.
    pub dragnet_belief: u32,
    /// The mission's name.
    pub mission: String,
    /// Rows of its map, from the south.
    pub rows: u32,
    /// Columns of its map, from the west.
    pub columns: u32,
    /// Edge of its cells, meters.
    pub cell_meters: f64,
    /// Where its map lies on the earth, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earth: Option<Frame>,
    /// Its map's pose in the frame of its file.
    pub origin: Pose,
    /// Probability that the one subject is outside of the searched cells, if exactly one is sought; of several whose number is
    /// known the prior probability that each of them is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_of_world: Option<f64>,
    /// The number of subjects, if several are sought and their number is known: 2 to 100. The probabilities are then those of
    /// independent cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub subjects: Option<u32>,
    /// Probability of an object in each cell, the southern row first; null where nothing was searched.
    pub probability: Vec<Option<f64>>,
}

/// The frame of a map on the earth, as [`Georeference`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// Of the south-western corner.
    pub south_west_latitude_degrees: f64,
    /// Of the south-western corner.
    pub south_west_longitude_degrees: f64,
    /// Latitude for which the frame is scaled.
    pub reference_latitude_degrees: f64,
    /// From the east to the map's rows, counterclockwise.
    pub yaw_radians: f64,
}

/// A pose as [`MapOrigin`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Along the x axis.
    pub x_meters: f64,
    /// Along the y axis.
    pub y_meters: f64,
    /// Counterclockwise.
    pub yaw_radians: f64,
}

/// A belief on another map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moved {
    /// Expected number of objects in each cell by the old belief, shape `[cells]`.
    pub(crate) mass: Vec<f64>,
    /// Share of each cell that the old search covers, 0 to 1, shape `[cells]`.
    pub(crate) covered: Vec<f64>,
}

impl From<&Georeference> for Frame {
    fn from(frame: &Georeference) -> Self {
        let GeoPoint { longitude_degrees, latitude_degrees } = frame.south_west();
        Self {
            south_west_latitude_degrees: latitude_degrees,
            south_west_longitude_degrees: longitude_degrees,
            reference_latitude_degrees: frame.reference_latitude_degrees(),
            yaw_radians: frame.yaw_radians(),
        }
    }
}

impl From<MapOrigin> for Pose {
    fn from(MapOrigin { x_meters, y_meters, yaw_radians }: MapOrigin) -> Self {
        Self { x_meters, y_meters, yaw_radians }
    }
}

impl BeliefFile {
    /// The same of several subjects of known number, whose cells are independent of each other but for it.
    #[must_use]
    pub fn of_several(self, subjects: Subjects) -> Self {
        let (number, rest) = (subjects.number(), subjects.rest_of_world());
        Self { rest_of_world: Some(rest), subjects: Some(number), ..self }
    }

    /// A belief on a map, of which the position on the earth may be known.
    #[must_use]
    pub fn new(
        mission: &str,
        terrain: &Terrain,
        earth: Option<&Georeference>,
        origin: MapOrigin,
        probability: impl Fn(Cell) -> f64,
        rest_of_world: Option<f64>,
    ) -> Self {
        let of = |cell| terrain.is_searched(cell).then(|| probability(cell));
        Self {
            dragnet_belief: VERSION,
            mission: mission.to_owned(),
            rows: terrain.grid().rows(),
            columns: terrain.grid().columns(),
            cell_meters: terrain.cell_meters(),
            earth: earth.map(Frame::from),
            origin: origin.into(),
            rest_of_world,
            subjects: None,
            probability: terrain.grid().cells().map(of).collect(),
        }
    }

    /// Whether a file's name ends as those of belief files.
    #[must_use]
    pub fn is_file(file: &Path) -> bool {
        file.to_string_lossy().to_lowercase().ends_with(ENDING)
    }

    /// The text of the file.
    #[must_use]
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default() + "\n"
    }

    /// Reads a belief file.
    ///
    /// # Errors
    /// If it cannot be read, is no belief file, or has a value out of range.
    pub fn load(file: &Path) -> Result<Self, MapFileError> {
        Self::read(file, &read_text(file)?)
    }

    fn read(file: &Path, text: &str) -> Result<Self, MapFileError> {
        let belief: Self = serde_json::from_str(text).map_err(|error| MapFileError::syntax(file, error))?;
        let invalid = |place: &str, found: &dyn std::fmt::Display, allowed: &str| {
            Err(MapFileError::value(file, place, found, allowed))
        };
        if belief.dragnet_belief != VERSION {
            return invalid("dragnet_belief", &belief.dragnet_belief, "1, the version of this format");
        }
        if !(belief.cell_meters.is_finite() && belief.cell_meters > 0.0) {
            return invalid("cell_meters", &belief.cell_meters, "a finite length above 0");
        }
        let grid = belief.grid(file)?;
        if belief.probability.len() != grid.cell_count() {
            let (found, cells) = (belief.probability.len(), grid.cell_count());
            return invalid("probability", &format!("{found} numbers"), &format!("{cells}, rows by columns"));
        }
        let is_share = |share: &f64| (0.0..=1.0).contains(share);
        let wrong = belief.probability.iter().position(|it| it.as_ref().is_some_and(|it| !is_share(it)));
        if let Some((index, wrong)) = wrong.and_then(|index| Some((index, belief.probability[index]?))) {
            return invalid(&format!("probability[{index}]"), &wrong, "from 0 to 1, or null");
        }
        if let Some(rest) = belief.rest_of_world.filter(|rest| !is_share(rest)) {
            return invalid("rest_of_world", &rest, "from 0 to 1");
        }
        let is_counted = |&number: &u32| (2..=Subjects::MAX_NUMBER).contains(&number);
        if let Some(number) = belief.subjects.filter(|number| !is_counted(number)) {
            return invalid("subjects", &number, &format!("from 2 to {}", Subjects::MAX_NUMBER));
        }
        if belief.subjects.is_some() && belief.rest_of_world.is_none_or(|rest| rest >= 1.0) {
            return invalid("rest_of_world", &"not below 1", "from 0 to below 1 with subjects");
        }
        if belief.earth.is_some() && belief.georeference().is_none() {
            return invalid("earth", &"not a place", GeoPoint::ALLOWED);
        }
        Ok(belief)
    }

    fn grid(&self, file: &Path) -> Result<Grid, MapFileError> {
        Grid::new(self.rows, self.columns).map_err(|error| MapFileError::syntax(file, error))
    }

    fn georeference(&self) -> Option<Georeference> {
        let it = self.earth?;
        let corner = GeoPoint::checked(it.south_west_longitude_degrees, it.south_west_latitude_degrees)?;
        GeoPoint::checked(it.south_west_longitude_degrees, it.reference_latitude_degrees)?;
        let frame = Georeference::new(corner, it.reference_latitude_degrees);
        it.yaw_radians.is_finite().then(|| frame.turned(it.yaw_radians))
    }

    /// The belief on another map; messages name the file.
    ///
    /// # Errors
    /// If the maps have no common frame, or do not overlap.
    pub(crate) fn moved_to(&self, file: &Path, map: &MapFile) -> Result<Moved, MapFileError> {
        let place = "its map";
        let moved = match (self.georeference(), &map.georeference) {
            (Some(from), Some(to)) => {
                if let Err(far) = to.check_near(from.south_west()) {
                    return Err(MapFileError::value(file, place, far, Georeference::NEAR));
                }
                self.moved(self.grid(file)?, &from, to, &map.terrain)
            }
            (None, None) if self.is_of(map) => self.kept(&map.terrain),
            (None, None) => {
                let Self { rows, columns, cell_meters, .. } = self;
                let found = format!(
                    "without a position on the earth, and of {rows} rows and {columns} columns of {cell_meters} m"
                );
                let allowed = "one with a position on the earth (and map.origin), or the scenario's own map";
                return Err(MapFileError::value(file, place, found, allowed));
            }
            (Some(_), None) => {
                let allowed = "a scenario whose map has one, such as by map.origin";
                return Err(MapFileError::value(file, place, "on the earth, the scenario's is not", allowed));
            }
            (None, Some(_)) => {
                let allowed = "one with a position: dragnet export --origin LATITUDE,LONGITUDE";
                return Err(MapFileError::value(file, place, "without a position on the earth", allowed));
            }
        };
        if moved.covered.iter().all(|&covered| covered <= TOUCH) {
            let allowed = "one that shares at least one searched cell with the scenario's map";
            return Err(MapFileError::value(file, place, "elsewhere", allowed));
        }
        Ok(moved)
    }

    /// Whether it has the cells of a map in the same frame.
    fn is_of(&self, map: &MapFile) -> bool {
        let (grid, origin) = (map.terrain.grid(), Pose::from(map.origin));
        let pairs = [
            (self.cell_meters, map.terrain.cell_meters()),
            (self.origin.x_meters, origin.x_meters),
            (self.origin.y_meters, origin.y_meters),
            (self.origin.yaw_radians, origin.yaw_radians),
        ];
        let is_near = pairs.iter().all(|(a, b)| (a - b).abs() <= SAME);
        is_near && (self.rows, self.columns) == (grid.rows(), grid.columns())
    }

    fn kept(&self, terrain: &Terrain) -> Moved {
        let of = |cell: Cell| self.probability[cell.index()].filter(|_| terrain.is_searched(cell));
        let cells = || terrain.grid().cells().map(of);
        Moved {
            mass: cells().map(|it| it.unwrap_or(0.0)).collect(),
            covered: cells().map(|it| f64::from(u8::from(it.is_some()))).collect(),
        }
    }

    fn moved(&self, grid: Grid, from: &Georeference, to: &Georeference, terrain: &Terrain) -> Moved {
        let cells = terrain.grid().cell_count();
        let mut moved = Moved { mass: vec![0.0; cells], covered: vec![0.0; cells] };
        let corner = |row: u32, column: u32| {
            let meters = (f64::from(column) * self.cell_meters, f64::from(row) * self.cell_meters);
            let (east, north) = to.meters(from.point(meters));
            (east / terrain.cell_meters(), north / terrain.cell_meters())
        };
        for (cell, probability) in grid.cells().zip(&self.probability) {
            let Some(probability) = probability else { continue };
            let Position { row, column } = grid.position(cell);
            let square = [
                corner(row, column),
                corner(row, column + 1),
                corner(row + 1, column + 1),
                corner(row + 1, column),
            ];
            let whole = area(&square);
            for (new, share) in shares(&square, terrain.grid()) {
                if terrain.is_searched(new) && whole > 0.0 {
                    moved.mass[new.index()] += probability * share / whole;
                    moved.covered[new.index()] += share;
                }
            }
        }
        for covered in &mut moved.covered {
            *covered = covered.min(1.0);
        }
        moved
    }
}

/// The cells of a grid that a convex polygon covers in part, each with its share. Corners are in cells east and north of the
/// grid's south-western one.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
fn shares(polygon: &[(f64, f64)], grid: Grid) -> Vec<(Cell, f64)> {
    let span = |values: &dyn Fn(&(f64, f64)) -> f64, count: u32| {
        let low = polygon.iter().map(values).fold(f64::INFINITY, f64::min).floor();
        let high = polygon.iter().map(values).fold(f64::NEG_INFINITY, f64::max).ceil();
        let clamped = |value: f64| value.clamp(0.0, f64::from(count)) as u32;
        clamped(low)..clamped(high)
    };
    let mut shares = Vec::new();
    for row in span(&|corner| corner.1, grid.rows()) {
        let south = f64::from(row);
        let flipped: Vec<(f64, f64)> = polygon.iter().map(|&(x, y)| (y, x)).collect();
        let strip: Vec<(f64, f64)> =
            between(&flipped, south, south + 1.0).into_iter().map(|(y, x)| (x, y)).collect();
        for column in span(&|corner| corner.0, grid.columns()) {
            let west = f64::from(column);
            let share = area(&between(&strip, west, west + 1.0));
            if let Some(cell) = grid.cell(Position { row, column }).filter(|_| share > 0.0) {
                shares.push((cell, share));
            }
        }
    }
    shares
}

/// The part of a convex polygon with an abscissa between two, by Sutherland and Hodgman (1974).
fn between(polygon: &[(f64, f64)], low: f64, high: f64) -> Vec<(f64, f64)> {
    clipped(&clipped(polygon, |x| x - low), |x| high - x)
}

/// The part of a convex polygon in which a linear function of the abscissa is not negative.
fn clipped(polygon: &[(f64, f64)], inside: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let mut corners = Vec::with_capacity(polygon.len() + 1);
    for (index, &to) in polygon.iter().enumerate() {
        let from = polygon[(index + polygon.len() - 1) % polygon.len()];
        let (before, after) = (inside(from.0), inside(to.0));
        if (before < 0.0) != (after < 0.0) {
            let share = before / (before - after);
            corners.push((from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1)));
        }
        if after >= 0.0 {
            corners.push(to);
        }
    }
    corners
}

/// The area of a polygon, by the shoelace formula.
fn area(polygon: &[(f64, f64)]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    let next = polygon.iter().skip(1).chain(std::iter::once(&first));
    // Relative to a corner, so that nothing cancels far from the origin.
    let at = |&(x, y): &(f64, f64)| (x - first.0, y - first.1);
    let cross = polygon.iter().zip(next).map(|(a, b)| {
        let ((ax, ay), (bx, by)) = (at(a), at(b));
        ax * by - bx * ay
    });
    (cross.sum::<f64>() / 2.0).abs()
}
