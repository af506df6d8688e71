//! The network's input, and its output compared with independent implementations and under symmetries.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod geometric;
mod graph;
#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;
mod motion;
mod scene;
mod symmetry;

use dragnet_learn::shape::Shape;
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::seed::{Purpose, stream};
use rand::RngExt;

/// The shape of the built-in networks; one that only decays, one that only sums; one without paths.
const SHAPES: [Shape; 4] = [
    Shape::DEFAULT,
    Shape { hidden: 64, layers: 1, decay_channels: 5, sum_channels: 0, ..Shape::DEFAULT },
    Shape { hidden: 32, layers: 2, decay_channels: 0, sum_channels: 3, ..Shape::DEFAULT },
    PATHLESS,
];

const PATHLESS: Shape = Shape { hidden: 32, layers: 3, decay_channels: 0, sum_channels: 0, ..Shape::DEFAULT };

/// With levels, and without paths too, of which equally short ones are not turned with a map.
const LEVELS: Shape = Shape { layers: 1, levels: 3, coarse_channels: 32, coarse_layers: 1, ..Shape::DEFAULT };
const PATHLESS_LEVELS: Shape = Shape { decay_channels: 0, sum_channels: 0, ..LEVELS };

/// Two orders of summing the same numbers, of the order of 10 and of 32 bits, differ by less.
const TOLERANCE: f32 = 1e-4;

/// Weights of about the size that training starts from, no two alike.
fn weights(shape: Shape, seed: u64) -> Weights {
    let mut random = stream(seed, Purpose::Training, 0);
    let fill = |name: &str, shape: &[usize]| {
        let limit = match (name, shape) {
            ("decay.factor", _) => 3.0,
            (_, [outputs, inputs]) => (6.0 / (outputs + inputs) as f32).sqrt(),
            _ => 0.5,
        };
        (0..shape.iter().product()).map(|_| random.random_range(-limit..limit)).collect()
    };
    Weights::build(shape, Recipe::default(), fill).unwrap()
}
