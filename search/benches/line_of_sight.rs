//! Decisions where walls hide what is behind them against decisions of sensors that see through the same walls, measured by turns.

use std::time::Duration;

use dragnet_search::cell::Grid;
use dragnet_search::generated::Generated;
use dragnet_search::policy::{Parameters, PolicyName, build};
use dragnet_search::seed::{Purpose, stream};

use crate::field::Field;
use crate::times::{Times, time};

const SIDES: [u32; 3] = [30, 60, 300];
const SEED: u64 = 1;
/// The radius of the default sensor.
const RADIUS: u32 = 5;

/// Prints the ratios of the medians.
pub(crate) fn print() {
    println!("\nwith a line of sight against without one, in rooms at the start; ratios of medians\n");
    println!("| side | limited cells | {} |", PolicyName::ALL.map(PolicyName::as_str).join(" | "));
    println!("|---|---|{}", "---|".repeat(PolicyName::ALL.len()));
    for side in SIDES {
        let map = Generated::Rooms.terrain(Grid::new(side, side).unwrap(), 1.0, SEED).unwrap();
        let opaque = map.clone().with_opaque_walls(RADIUS);
        let sees_less = |&cell: &_| opaque.line_of_sight().shadows(cell).is_some();
        let share =
            opaque.traversable_cells().filter(sees_less).count() * 100 / map.traversable_cells().count();
        let fields = [map, opaque].map(|terrain| Field::on(terrain, 0.01, SEED));
        let ratios = PolicyName::ALL.map(|name| format!("{:.2}", ratio(&fields, name)));
        println!("| {side} | {share} % | {} |", ratios.join(" | "));
    }
}

fn ratio([open, opaque]: &[Field; 2], name: PolicyName) -> f64 {
    let mut times = [Vec::new(), Vec::new()];
    while times[0].len() < 5
        || times[0].len() < 51 && times[0].iter().sum::<Duration>() < Duration::from_millis(300)
    {
        for (field, times) in [open, opaque].into_iter().zip(&mut times) {
            let mut random = stream(SEED, Purpose::Decision, 1);
            let decide = || build(name, Parameters::default()).choose(&field.situation(), &mut random);
            times.push(time(decide).0);
        }
    }
    let [open, opaque] = times.map(|times| Times::of(times).quantile(0.5).as_secs_f64());
    opaque / open
}
