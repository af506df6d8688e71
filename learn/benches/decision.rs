//! One decision of the built-in network, and its parts, by size of an all-traversable map.
//!
//! `cargo bench -p dragnet-learn --bench decision`
#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dragnet_learn::graph::Graph;
use dragnet_learn::network::{Network, Workspace};
use dragnet_learn::policy::Gnn;
use dragnet_learn::shape::Shape as Sizes;
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Grid, Position};
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::policy::Policy;
use dragnet_search::route::ShortestPathTree;
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::shape::Shape;
use dragnet_search::situation::Situation;
use rand::RngExt;

fn decisions(criterion: &mut Criterion) {
    let mut random = stream(1, Purpose::Training, 0);
    let weights = Weights::build(Sizes::DEFAULT, Recipe::default(), |_, shape| {
        (0..shape.iter().product()).map(|_| random.random_range(-0.3..0.3)).collect()
    });
    let network = Arc::new(Network::new(&weights.unwrap()));
    let mut group = criterion.benchmark_group("decision");
    for side in [30, 60] {
        let grid = Grid::new(side, side).unwrap();
        let terrain = Shape::AllTraversable.terrain(grid, 30.0).unwrap();
        let log_odds = grid.cells().map(|_| random.random_range(-5.0..2.0)).collect();
        let belief = Belief::from_log_odds(&terrain, log_odds).unwrap();
        let (sensor, planned_precision) = (Sensor::default(), PlannedPrecision::nothing(&terrain));
        let situation = Situation::alone(
            &terrain,
            &sensor,
            &belief,
            &planned_precision,
            grid.cell(Position { row: side / 3, column: side / 3 }).unwrap(),
        );
        let routes = ShortestPathTree::from(&terrain, situation.connectivity, situation.robot);
        let (mut topology, mut workspace) = (None, Workspace::default());
        let graph = Graph::new(&situation, &routes, &mut topology);
        let mut policy = Gnn::new(Arc::clone(&network));
        group.bench_function(BenchmarkId::new("whole", side), |bencher| {
            bencher.iter(|| policy.decide(black_box(&situation), &mut random));
        });
        group.bench_function(BenchmarkId::new("graph", side), |bencher| {
            bencher.iter(|| Graph::new(black_box(&situation), &routes, &mut topology));
        });
        group.bench_function(BenchmarkId::new("network", side), |bencher| {
            bencher.iter(|| network.logits_in(black_box(&graph), &mut workspace).len());
        });
    }
    group.finish();
}

criterion_group!(benches, decisions);
criterion_main!(benches);
