//! First tours: parallel lanes over what is left.

use super::ground::Ground;
use super::planner::{Leg, Planner};

/// Lanes are at most this many cells apart for each cell of the sensor's radius, and at least that many.
const WIDEST: f64 = 2.0;
const NARROWEST: f64 = 1.7;
/// A cell counts in what is left if it hides this share of the mean.
const LEAST_SHARE: f64 = 0.2;
/// How far a waypoint may be from its place on the lane, cells.
const SEARCHED: i32 = 6;

/// What is left lies between these rows and columns of the frame.
struct Bounds {
    rows: (i32, i32),
    columns: (i32, i32),
}

/// Lanes in both directions, from all four corners, at several distances.
pub(super) fn lanes(planner: &Planner<'_>) -> Vec<Vec<Leg>> {
    let Some(Bounds { rows, columns }) = bounds(planner) else { return Vec::new() };
    let radius = f64::from(planner.ground.radius());
    let mut tours = Vec::new();
    for is_along_columns in [false, true] {
        let (across, along) = if is_along_columns { (columns, rows) } else { (rows, columns) };
        let count = |cells_per_radius: f64| {
            let lanes = (f64::from(across.1 - across.0 + 1) / (cells_per_radius * radius)).ceil();
            #[expect(clippy::cast_possible_truncation, reason = "a map's side")]
            let lanes = lanes.max(1.0) as i32;
            lanes
        };
        for count in count(WIDEST)..=count(NARROWEST) {
            for corner in 0..4 {
                tours
                    .push(lanes_of(planner.ground, Lanes { is_along_columns, across, along, count, corner }));
            }
        }
    }
    tours
}

/// One pattern of lanes.
#[derive(Clone, Copy)]
struct Lanes {
    is_along_columns: bool,
    across: (i32, i32),
    along: (i32, i32),
    count: i32,
    /// Bit 0: from the far side; bit 1: backwards first.
    corner: i32,
}

fn lanes_of(ground: &Ground, lanes: Lanes) -> Vec<Leg> {
    let Lanes { is_along_columns, across, along, count, corner } = lanes;
    let margin = ground.radius().cast_signed() - 1;
    let inner = ((along.0 + margin).min(along.1), (along.1 - margin).max(along.0));
    let bend = u8::from(!is_along_columns);
    let mut tour = Vec::new();
    for index in 0..count {
        let lane = if corner & 1 == 0 { index } else { count - 1 - index };
        let place = across.0 + (across.1 - across.0 + 1) * (2 * lane + 1) / (2 * count);
        let ends = if (index + corner / 2) % 2 == 0 { [inner.0, inner.1] } else { [inner.1, inner.0] };
        for end in ends {
            let (row, column) = if is_along_columns { (end, place) } else { (place, end) };
            tour.extend(nearest(ground, row, column).map(|to| Leg { to, bend }));
        }
    }
    tour
}

/// A waypoint near a row and column of the frame.
fn nearest(ground: &Ground, row: i32, column: i32) -> Option<u16> {
    let offsets =
        (-SEARCHED..=SEARCHED).flat_map(|north| (-SEARCHED..=SEARCHED).map(move |east| (north, east)));
    offsets
        .filter_map(|(north, east)| {
            let waypoint = ground.waypoint_at(row + north, column + east)?;
            Some((north.abs() + east.abs(), waypoint))
        })
        .min()
        .map(|(_, waypoint)| waypoint)
}

fn bounds(planner: &Planner<'_>) -> Option<Bounds> {
    let ground = planner.ground;
    let least = LEAST_SHARE * planner.root.left / f64::from(ground.count());
    let left = (0..ground.count()).filter(|&number| planner.hidden_at(number) > least);
    left.map(|number| ground.place(number)).fold(None, |bounds, (row, column)| {
        let wider = |(low, high): (i32, i32), value: i32| (low.min(value), high.max(value));
        let Bounds { rows, columns } =
            bounds.unwrap_or(Bounds { rows: (row, row), columns: (column, column) });
        Some(Bounds { rows: wider(rows, row), columns: wider(columns, column) })
    })
}
