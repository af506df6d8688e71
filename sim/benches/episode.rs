//! Whole episodes: agents, messages and the world in one process.

#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::path::Path;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dragnet_scenario::Scenario;
use dragnet_sim::episode;
use dragnet_sim::simulation::End;

/// One object in a hundred cells; the search ends when all are found.
const SCENARIO: &str = r#"
name = "episode"

[map]
shape = "all_traversable"
rows = 30
columns = 30

[objects]
density = 0.01

[robots]
count = 1
policy = "path"

[mission]
budget_meters = 30000.0
"#;

fn episodes(criterion: &mut Criterion) {
    let scenario = Scenario::from_text(Path::new("episode.toml"), SCENARIO.to_owned()).unwrap();
    let mut group = criterion.benchmark_group("episode/path/30");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    for robots in [1, 4] {
        let scenario = scenario.with_robots(robots).unwrap();
        group.bench_function(BenchmarkId::new("robots", robots), |bencher| {
            bencher.iter(|| episode::run(&scenario, 1, End::AllFound).unwrap());
        });
    }
}

criterion_group!(benches, episodes);
criterion_main!(benches);
