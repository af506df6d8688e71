//! An independent implementation, filterpy's, tracks the same bearings to the same estimates.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use dragnet_lattice::plane::bearing_radians;
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_vehicle::tracker::cubature::{BearingMeasurement, Gaussian};
use dragnet_vehicle::tracker::mixture::{Mixture, Reach};
use dragnet_vehicle::tracker::pose_error::PoseError;
use dragnet_vehicle::tracker::settings::Settings;
use nalgebra::{Matrix4, Vector2, Vector4};
use rand_distr::{Distribution, StandardNormal};
use serde_json::{Value, json};

use crate::interpreter::interpreter;

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const REACH: Reach = Reach { min_range_meters: 5.0, max_range_meters: 150.0 };
const DEVIATION_RADIANS: f64 = 0.01;
/// Of a mean by its own standard deviation, and of a covariance by both.
const TOLERANCE: f64 = 1e-9;

fn estimates_of_filterpy(scenarios: &Value) -> Value {
    let script = Path::new(WORKSPACE).join("tests/python/cubature_filter.py");
    let (stdin, stdout) = (Stdio::piped(), Stdio::piped());
    let mut child = Command::new(interpreter(Path::new(WORKSPACE)))
        .arg(script)
        .stdin(stdin)
        .stdout(stdout)
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(scenarios.to_string().as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "the script failed; its message stands above");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// An object in the west moves across the direction pi, observed from a vehicle on a winding path; uneven time steps.
fn measurements(random: &mut Stream) -> Vec<(f64, BearingMeasurement)> {
    let mut seconds = 0.0;
    let measurement = |step: u32| {
        seconds += 0.3 + 0.2 * f64::from(step % 3);
        let object = Vector2::new(-40.0 - 0.2 * seconds, 12.0 - 0.8 * seconds);
        let from_meters = Vector2::new(0.5 * seconds, 6.0 * (seconds / 4.0).sin());
        let noise: f64 = StandardNormal.sample(random);
        let bearing = bearing_radians(from_meters, object) + DEVIATION_RADIANS * noise;
        (
            seconds,
            BearingMeasurement {
                from_meters,
                bearing_radians: bearing,
                deviation_radians: DEVIATION_RADIANS,
            },
        )
    };
    (0..60).map(measurement).collect()
}

fn rows(matrix: &Matrix4<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// The largest difference, in standard deviations of filterpy's results.
fn difference(ours: &Gaussian, theirs: &Value) -> f64 {
    let mean = Vector4::from_fn(|i, _| theirs["mean"][i].as_f64().unwrap());
    let covariance = Matrix4::from_fn(|i, j| theirs["covariance"][i][j].as_f64().unwrap());
    let deviation = |i: usize| covariance[(i, i)].sqrt();
    let of_mean = (0..4).map(|i| (ours.mean[i] - mean[i]).abs() / deviation(i));
    let of_covariance = (0..16).map(|place| {
        let (i, j) = (place / 4, place % 4);
        (ours.covariance[(i, j)] - covariance[(i, j)]).abs() / (deviation(i) * deviation(j))
    });
    let all: Vec<f64> = of_mean.chain(of_covariance).collect();
    // `max` would ignore NaN.
    assert!(all.iter().all(|difference| difference.is_finite()), "{ours:?}");
    all.into_iter().fold(0.0, f64::max)
}

fn settings() -> Settings {
    Settings { velocity_std: 0.5, acceleration_density: 0.02, ..Settings::default() }
}

fn alone() -> Gaussian {
    Gaussian {
        mean: Vector4::new(-60.0, 10.0, 0.0, 0.0),
        covariance: Matrix4::from_diagonal(&Vector4::new(400.0, 100.0, 1.0, 1.0)),
    }
}

fn scenario(measurements: &[(f64, BearingMeasurement)]) -> Value {
    let (settings, alone) = (settings(), alone());
    let numbers = |(seconds, measurement): &(f64, BearingMeasurement)| {
        json!([seconds, measurement.from_meters.x, measurement.from_meters.y, measurement.bearing_radians])
    };
    json!({
        "settings": {
            "members": settings.range_hypotheses,
            "velocity_std": settings.velocity_std,
            "acceleration_density": settings.acceleration_density,
            "min_range_meters": REACH.min_range_meters,
            "max_range_meters": REACH.max_range_meters,
            "deviation_radians": DEVIATION_RADIANS,
        },
        "alone": {"mean": alone.mean.as_slice(), "covariance": rows(&alone.covariance)},
        "sights": measurements.iter().map(numbers).collect::<Vec<_>>(),
    })
}

fn check(seed: usize, measurements: &[(f64, BearingMeasurement)], theirs: &Value) {
    let (settings, mut alone) = (settings(), alone());
    let mut mixture = Mixture::born(&measurements[0].1, &PoseError::default(), REACH, &settings);
    let mut largest: f64 = 0.0;
    assert_eq!(theirs.as_array().unwrap().len(), measurements.len() - 1);
    for (pair, theirs) in measurements.windows(2).zip(theirs.as_array().unwrap()) {
        let (elapsed_seconds, measurement) = (pair[1].0 - pair[0].0, pair[1].1);
        alone.predict(elapsed_seconds, settings.acceleration_density);
        alone.update(&measurement).unwrap();
        mixture.predict(elapsed_seconds, settings.acceleration_density);
        mixture = mixture.updated(&measurement, &PoseError::default()).unwrap();
        largest = largest.max(difference(&alone, &theirs["alone"]));
        largest = largest.max(difference(&mixture.estimate(), &theirs["mixture"]));
        let weights = theirs["weights"].as_array().unwrap();
        assert_eq!(mixture.members().len(), weights.len());
        for (member, weight) in mixture.members().iter().zip(weights) {
            largest = largest.max((member.weight - weight.as_f64().unwrap()).abs());
        }
    }
    println!("seed {seed}: at most {largest:.1e} apart, {} members left", mixture.members().len());
    assert!(largest < TOLERANCE, "seed {seed}: {largest}");
    // The hard cases: members were dropped, and bearings lie on both sides of pi.
    assert!(mixture.members().len() < 6);
    assert!(measurements.iter().any(|(_, measurement)| measurement.bearing_radians > 3.0));
    assert!(measurements.iter().any(|(_, measurement)| measurement.bearing_radians < -3.0));
}

#[test]
fn filterpy_finds_the_same_estimates() {
    let measurements: Vec<_> =
        (0..5).map(|seed| measurements(&mut stream(seed, Purpose::Noise, 0))).collect();
    let scenarios: Vec<Value> = measurements.iter().map(|measurements| scenario(measurements)).collect();
    let theirs = estimates_of_filterpy(&json!(scenarios));
    for (seed, measurements) in (0..).zip(&measurements) {
        check(seed, measurements, &theirs[seed]);
    }
}
