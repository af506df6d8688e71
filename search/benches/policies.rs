//! One decision of each policy by size of map, and the parts that decisions are made of.
//!
//! Every decision is that of a policy built anew, so that nothing it keeps from the decision before counts.

#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

mod field;

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, criterion_group, criterion_main};
use dragnet_search::cell::{Grid, Position};
use dragnet_search::policy::{Parameters, PolicyName, build};
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::shape::Shape;
use dragnet_search::utility::UtilityTable;

use field::Field;

const SIDES: [u32; 5] = [30, 60, 100, 300, 1000];
const DENSITY: f64 = 0.01;
const SEED: u64 = 1;

fn decisions(criterion: &mut Criterion) {
    for side in SIDES {
        let fields = [
            ("fresh", Field::fresh(Shape::AllTraversable, side, DENSITY, SEED)),
            ("midway", Field::midway(side, DENSITY, SEED)),
        ];
        for (state, field) in &fields {
            let mut group = criterion.benchmark_group(format!("decision/{state}"));
            limit(&mut group, side);
            for name in PolicyName::ALL {
                group.bench_function(BenchmarkId::new(name.as_str(), side), |bencher| {
                    let mut random = stream(SEED, Purpose::Decision, 1);
                    bencher.iter(|| {
                        build(name, Parameters::default()).decide(black_box(&field.situation()), &mut random)
                    });
                });
            }
        }
    }
}

/// Keeps the whole run within a few minutes: a decision on the largest map may take a second.
fn limit(group: &mut BenchmarkGroup<'_, WallTime>, side: u32) {
    group.warm_up_time(Duration::from_millis(100)).measurement_time(Duration::from_secs(1));
    group.sample_size(if side < 300 { 20 } else { 10 });
    group.sampling_mode(if side < 300 { SamplingMode::Auto } else { SamplingMode::Flat });
}

fn parts(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("part");
    group.sample_size(10).warm_up_time(Duration::from_millis(200));
    group.measurement_time(Duration::from_millis(1500));
    group.bench_function("information table", |bencher| bencher.iter(UtilityTable::build));
    group.bench_function("belief takes one observation", |bencher| {
        let mut field = Field::fresh(Shape::AllTraversable, 30, DENSITY, SEED);
        let center = Grid::new(30, 30).unwrap().cell(Position { row: 15, column: 15 }).unwrap();
        field.enter(center);
        let readings = field.observe();
        assert_eq!(readings.len(), 61);
        bencher.iter(|| black_box(&readings).iter().for_each(|reading| field.belief.add(reading)));
    });
}

criterion_group!(benches, parts, decisions);
criterion_main!(benches);
