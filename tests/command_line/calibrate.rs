//! `dragnet calibrate`: from labeled scores to the sensor of a scenario.

use super::Place;

/// Scores of a detector with symmetric errors: the square root of the model's variance.
fn observations(noise_variance: f64) -> String {
    let mut text = "distance,object,value\n".to_owned();
    for distance in 0..6_u32 {
        let variance =
            if distance == 0 { noise_variance / 5.0 } else { noise_variance * f64::from(distance.pow(2)) };
        for object in [0.0, 1.0] {
            for off in [-1.0, 1.0] {
                let row = format!("{distance},{object},{}\n", object + off * variance.sqrt());
                text += &row.repeat(10);
            }
        }
    }
    text
}

#[test]
fn the_sensor_of_labeled_scores_is_printed_and_drawn() {
    let place = Place::new();
    place.write("scores.csv", &observations(0.02));
    let reported = place.succeed(&["calibrate", "scores.csv", "--plot", "fit.svg"]);
    assert!(reported.contains("[sensor]\nnoise_variance = 0.020000 # standard error 0.0000"), "{reported}");
    assert!(reported.contains("the own cell's variance is 0.00400"), "{reported}");
    let drawn = std::fs::read_to_string(place.path("fit.svg")).unwrap();
    assert!(drawn.contains("Variance of a reading") && drawn.contains("fitted"));
    place.refuse(&["calibrate", "scores.csv", "--plot", "fit.svg"], &["fit.svg", "exists already"]);
}

#[test]
fn readings_that_cannot_be_fitted_are_rejected_by_name() {
    let place = Place::new();
    let refused = |text: &str, said: &[&str]| {
        place.write("scores.csv", text);
        place.refuse(&["calibrate", "scores.csv"], &[&["scores.csv"], said].concat());
    };
    refused("", &["0 readings"]);
    refused("distance,object,value\n1,0,0.1\n", &["1 readings", "at least 30"]);
    refused("distance,object,value\n1,2,0.1\n", &["object is 2", "0 and 1"]);
    refused("distance,object,value\n1,0,much\n", &["line: 2", "invalid float"]);
    refused("distance,object,value\n1,0,NaN\n", &["NaN", "allowed"]);
    refused("distance,value\n1,0.1\n", &["missing field `object`"]);
    place.refuse(&["calibrate", "absent.csv"], &["absent.csv", "cannot read it"]);
}
