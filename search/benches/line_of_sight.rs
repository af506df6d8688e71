//! Decisions where walls hide what is behind them against decisions of sensors that see through the same walls, measured by turns.

use std::time::Duration;

use dragnet_search::cell::Grid;
use dragnet_search::generated::Generated;
use dragnet_search::policy::{Parameters, PolicyName, build};
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::sensor::{Noise, Sensor};

use crate::field::Field;
use crate::times::{Times, milliseconds, time};

/// Sides of the maps, each with the radius of the sensor, cells.
const SIZES: [(u32, u32); 4] = [(30, 5), (60, 5), (300, 5), (150, 30)];
const SEED: u64 = 1;

/// Prints the ratios of the medians.
pub(crate) fn print() {
    println!(
        "\nwith a line of sight against without one, in rooms at the start; ratios of medians, and medians without one, ms\n"
    );
    println!("| side | radius | limited cells | {} |", PolicyName::ALL.map(PolicyName::as_str).join(" | "));
    println!("|---|---|---|{}", "---|".repeat(PolicyName::ALL.len()));
    for (side, radius) in SIZES {
        let map = Generated::Rooms.terrain(Grid::new(side, side).unwrap(), 1.0, SEED).unwrap();
        let opaque = map.clone().with_opaque_walls(radius);
        let sees_less = |&cell: &_| opaque.line_of_sight().shadows(cell).is_some();
        let share =
            opaque.traversable_cells().filter(sees_less).count() * 100 / map.traversable_cells().count();
        let sensor = Sensor::new(radius, Sensor::DEFAULT_NOISE_VARIANCE, Noise::Gaussian).unwrap();
        let fields = [map, opaque].map(|terrain| Field::on(terrain, sensor.clone(), 0.01, SEED));
        let ratios = PolicyName::ALL.map(|name| ratio(&fields, name));
        println!("| {side} | {radius} | {share} % | {} |", ratios.join(" | "));
    }
}

/// The ratio, and the median without a line of sight.
fn ratio([open, opaque]: &[Field; 2], name: PolicyName) -> String {
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
    let [open, opaque] = times.map(|times| Times::of(times).quantile(0.5));
    format!("{:.2} of {}", opaque.as_secs_f64() / open.as_secs_f64(), milliseconds(open))
}
