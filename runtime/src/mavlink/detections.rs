//! What detectors say, as JSON: one object a datagram, with all that was detected in one image of one camera.

use dragnet_vehicle::camera::DetectionBox;
use serde::Deserialize;

use super::settings::DetectionFilter;

/// All detections in an image. An image in which nothing is detected counts as well: it shows that nothing is there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sighting {
    /// Name of the camera, as in the settings.
    pub(crate) camera: String,
    /// When the image was taken, nanoseconds since 1970; `None` for when its datagram arrives.
    pub(crate) unix_ns: Option<i64>,
    pub(crate) seen: Seen,
}

/// What is seen, of the classes and the scores that count.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Seen {
    /// Boxes, pixels.
    Boxes(Vec<DetectionBox>),
    /// Radians counterclockwise from the vehicle's heading, from the camera's position.
    Bearings(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Message {
    camera: String,
    unix_seconds: Option<f64>,
    boxes: Option<Vec<BoxEntry>>,
    bearings: Option<Vec<BearingEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxEntry {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    #[serde(default)]
    class: String,
    #[serde(default = "certain")]
    score: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BearingEntry {
    degrees: f64,
    #[serde(default)]
    class: String,
    #[serde(default = "certain")]
    score: f64,
}

const fn certain() -> f64 {
    1.0
}

/// The latest time that is one, seconds since 1970: in the year 2262.
const MAX_UNIX_SECONDS: f64 = 9.2e9;

/// Reads a datagram.
///
/// # Errors
/// If it is not such an object: what is wrong, and what is allowed.
pub(crate) fn read(datagram: &[u8], filter: &DetectionFilter) -> Result<Sighting, String> {
    let message: Message =
        serde_json::from_slice(datagram).map_err(|error| format!("no detections as JSON: {error}"))?;
    let unix_ns = message.unix_seconds.map(unix_ns).transpose()?;
    let seen = match (message.boxes, message.bearings) {
        (Some(boxes), None) => {
            let mut counted = Vec::new();
            for entry in boxes {
                if filter.counts(&entry.class, entry.score)? {
                    let BoxEntry { left, top, right, bottom, .. } = entry;
                    counted.push(DetectionBox { left, top, right, bottom });
                }
            }
            Seen::Boxes(counted)
        }
        (None, Some(bearings)) => {
            let mut counted = Vec::new();
            for entry in bearings {
                if filter.counts(&entry.class, entry.score)? {
                    // Clockwise as on a compass; the vehicle's frame counts the other way.
                    counted.push(-entry.degrees.to_radians());
                }
            }
            Seen::Bearings(counted)
        }
        (Some(_), Some(_)) | (None, None) => {
            return Err(
                "boxes and bearings: allowed is exactly one of the two, which may be empty".to_owned()
            );
        }
    };
    Ok(Sighting { camera: message.camera, unix_ns, seen })
}

#[expect(clippy::cast_possible_truncation, reason = "checked against the largest time")]
fn unix_ns(seconds: f64) -> Result<i64, String> {
    if (0.0..=MAX_UNIX_SECONDS).contains(&seconds) {
        return Ok((seconds * 1e9) as i64);
    }
    Err(format!("unix_seconds is {seconds}; allowed is 0 to {MAX_UNIX_SECONDS}"))
}

impl DetectionFilter {
    fn counts(&self, class: &str, score: f64) -> Result<bool, String> {
        if !(0.0..=1.0).contains(&score) {
            return Err(format!("score is {score}; allowed is 0 to 1"));
        }
        let is_class = self.classes.is_empty() || self.classes.iter().any(|one| one == class);
        Ok(is_class && score >= self.min_score)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;

    fn filter() -> DetectionFilter {
        DetectionFilter { classes: vec!["person".to_owned()], min_score: 0.5 }
    }

    #[test]
    fn classes_and_scores_that_count_are_read() {
        let text = r#"{"camera": "front", "unix_seconds": 1700000000.5, "boxes": [
            {"left": 1, "top": 2, "right": 3, "bottom": 4, "class": "person", "score": 0.5},
            {"left": 1, "top": 2, "right": 3, "bottom": 4, "class": "person", "score": 0.4},
            {"left": 1, "top": 2, "right": 3, "bottom": 4, "class": "dog", "score": 0.9}]}"#;
        let boxes = vec![DetectionBox { left: 1.0, top: 2.0, right: 3.0, bottom: 4.0 }];
        let sighting = Sighting {
            camera: "front".to_owned(),
            unix_ns: Some(1_700_000_000_500_000_000),
            seen: Seen::Boxes(boxes),
        };
        assert_eq!(read(text.as_bytes(), &filter()), Ok(sighting));
        let to_the_right = r#"{"camera": "front", "bearings": [{"degrees": 90, "class": "person"}]}"#;
        let sighting = read(to_the_right.as_bytes(), &filter()).unwrap();
        assert_eq!(sighting.seen, Seen::Bearings(vec![-std::f64::consts::FRAC_PI_2]));
        assert_eq!(sighting.unix_ns, None);
    }

    #[test]
    fn what_is_no_sighting_is_refused_with_the_reason() {
        let check = |text: &str, mentioned: &str| {
            assert_mentions(&read(text.as_bytes(), &filter()).unwrap_err(), mentioned);
        };
        check("", "JSON");
        check(r#"{"camera": "front"}"#, "boxes and bearings .. exactly one");
        check(r#"{"camera": "front", "boxes": [], "bearings": []}"#, "exactly one");
        check(r#"{"camera": "front", "box": []}"#, "box .. boxes");
        check(r#"{"boxes": []}"#, "camera");
        check(r#"{"camera": "front", "boxes": [], "unix_seconds": -1}"#, "unix_seconds is -1 .. 0 to");
        check(r#"{"camera": "front", "bearings": [{"degrees": 1, "score": 7}]}"#, "score is 7 .. 0 to 1");
        check(r#"{"camera": "front", "boxes": [{"left": NaN}]}"#, "JSON");
    }
}
