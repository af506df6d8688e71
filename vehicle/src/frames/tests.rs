use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

use super::*;
use crate::mentions::assert_mentions;

const SECOND: i64 = 1_000_000_000;

fn pose(x: f64, y: f64, yaw_radians: f64) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_radians);
    Isometry3::from_parts(Translation3::new(x, y, 0.0), rotation)
}

fn stamped(edge: &str, validity: Validity, parent_from_child: Isometry3<f64>) -> StampedTransform {
    let (parent, child) = edge.split_once(" -> ").unwrap();
    StampedTransform { parent: parent.to_owned(), child: child.to_owned(), parent_from_child, validity }
}

fn moving(edge: &str, time_ns: i64, transform: Isometry3<f64>) -> StampedTransform {
    stamped(edge, Validity::At(time_ns), transform)
}

fn fixed(edge: &str, transform: Isometry3<f64>) -> StampedTransform {
    stamped(edge, Validity::Always, transform)
}

/// A tree of these transforms, all valid.
fn tree(transforms: &[StampedTransform]) -> FrameTree {
    let mut tree = FrameTree::default();
    for transform in transforms {
        tree.insert(transform).unwrap();
    }
    tree
}

fn assert_near(found: &Isometry3<f64>, expected: &Isometry3<f64>) {
    let apart = expected.inverse() * found;
    let near = apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9;
    assert!(near, "{found} is not {expected}");
}

#[test]
fn transforms_multiply_along_the_tree() {
    let tree = tree(&[
        moving("map -> odom", 0, pose(100.0, 0.0, FRAC_PI_2)),
        moving("odom -> base_link", 0, pose(10.0, 0.0, 0.0)),
        fixed("/base_link -> front", pose(1.0, 0.0, 0.0)),
        fixed("base_link -> left", pose(0.0, 1.0, FRAC_PI_2)),
    ]);
    // Odometry's x axis points north: 11 m along it.
    assert_near(&tree.transform("map", "/front", 0).unwrap(), &pose(100.0, 11.0, FRAC_PI_2));
    // What is 5 m ahead of the left camera is 6 m to the left of the vehicle.
    let ahead = tree.transform("base_link", "left", 0).unwrap() * Point3::new(5.0, 0.0, 0.0);
    assert!((ahead - Point3::new(0.0, 6.0, 0.0)).norm() < 1e-12);
    // Between branches, in both directions; only moving transforms between the two frames need a time.
    let there = tree.transform("front", "left", 99 * SECOND).unwrap();
    assert_near(&there, &pose(-1.0, 1.0, FRAC_PI_2));
    assert_near(&tree.transform("left", "front", 99 * SECOND).unwrap(), &there.inverse());
    assert_near(&tree.transform("map", "map", 0).unwrap(), &Isometry3::identity());
    let links = tree.links("map", "front").unwrap();
    let links: Vec<_> = links.iter().map(|link| (link.parent, link.child, link.newest_ns)).collect();
    assert_eq!(
        links,
        [("base_link", "front", None), ("odom", "base_link", Some(0)), ("map", "odom", Some(0))]
    );
}

/// Closed forms: at a share of the time, the share of the way and of the angle about the axis.
#[test]
fn between_two_stamps_the_way_is_linear_and_the_turn_steady() {
    let axis = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.7) * Vector3::z_axis();
    let turned = |radians: f64| UnitQuaternion::from_axis_angle(&axis, radians);
    for (from_radians, turn_radians) in [(0.3, 1.2), (3.0, 0.5), (-3.0, -1.0), (0.0, 3.0)] {
        let first = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turned(from_radians));
        let last =
            Isometry3::from_parts(Translation3::new(5.0, 0.0, 3.0), turned(from_radians + turn_radians));
        // The same rotation as the other quaternion.
        let opposite =
            Isometry3 { rotation: UnitQuaternion::new_unchecked(-last.rotation.into_inner()), ..last };
        for end in [last, opposite] {
            let tree = tree(&[moving("a -> b", 0, first), moving("a -> b", SECOND, end)]);
            for share in [0.0, 0.25, 0.5, 0.9, 1.0] {
                #[expect(clippy::cast_possible_truncation, reason = "within a second")]
                let found = tree.transform("a", "b", (share * SECOND as f64) as i64).unwrap();
                let expected = Isometry3::from_parts(
                    Translation3::new(1.0 + 4.0 * share, 2.0 - 2.0 * share, 3.0),
                    turned(from_radians + turn_radians * share),
                );
                assert_near(&found, &expected);
            }
        }
    }
}

#[test]
fn nothing_is_extrapolated_and_no_gap_is_bridged() {
    let at = |seconds: f64| {
        let tree = tree(&[
            moving("odom -> base_link", 10 * SECOND, pose(0.0, 0.0, 0.0)),
            moving("odom -> base_link", 11 * SECOND, pose(1.0, 0.0, 0.0)),
            moving("odom -> base_link", 13 * SECOND, pose(3.0, 0.0, PI)),
        ]);
        #[expect(clippy::cast_possible_truncation, reason = "a few seconds")]
        let time_ns = (seconds * SECOND as f64) as i64;
        tree.transform("odom", "base_link", time_ns)
    };
    assert!(at(10.0).is_ok() && at(10.5).is_ok() && at(13.0).is_ok());
    let refused = |seconds: f64, may_pass: bool, words: &str| {
        let error = at(seconds).unwrap_err();
        assert_eq!(error.may_pass(), may_pass, "{error}");
        assert_mentions(&error.to_string(), words);
    };
    refused(13.1, true, "newest .. \"odom\" to \"base_link\" .. 0.10 s older");
    refused(9.5, false, "oldest .. 0.50 s newer");
    refused(12.0, false, "gap of 2.00 s");
}

#[test]
fn what_is_missing_is_named() {
    let mut tree = FrameTree::default();
    let refused = |tree: &FrameTree, words: &str| {
        let error = tree.transform("map", "camera", 0).unwrap_err();
        assert!(error.may_pass());
        assert_mentions(&error.to_string(), words);
    };
    refused(&tree, "no transform names .. \"map\"");
    tree.insert(&moving("map -> odom", 0, pose(0.0, 0.0, 0.0))).unwrap();
    refused(&tree, "no transform names .. \"camera\"");
    tree.insert(&fixed("base_link -> camera", pose(0.0, 0.0, 0.0))).unwrap();
    refused(&tree, "connects \"camera\" .. \"base_link\" .. \"map\"");
    assert!(tree.newest_ns("map", "camera").is_err());
    tree.insert(&moving("odom -> base_link", 5, pose(0.0, 0.0, 0.0))).unwrap();
    assert_eq!(tree.newest_ns("map", "camera"), Ok(Some(0)));
    assert_eq!(tree.newest_ns("odom", "camera"), Ok(Some(5)));
    assert_eq!(tree.newest_ns("camera", "base_link"), Ok(None));
}

#[test]
fn loops_and_second_parents_are_refused_with_their_frames() {
    let mut tree = tree(&[
        moving("map -> odom", 0, pose(0.0, 0.0, 0.0)),
        moving("odom -> base_link", 0, pose(1.0, 0.0, 0.0)),
        fixed("base_link -> camera", pose(0.0, 0.0, 0.0)),
    ]);
    let before = tree.transform("map", "camera", 0).unwrap();
    let mut refused = |transform: &StampedTransform, words: &str| {
        assert_mentions(&tree.insert(transform).unwrap_err().to_string(), words);
    };
    let here = pose(0.0, 0.0, 0.0);
    refused(&fixed("base_link -> map", here), "loop .. map -> base_link -> odom -> map");
    refused(&fixed("a -> a", here), "loop .. a -> a");
    refused(&moving("vicon -> base_link", 0, here), "\"base_link\" .. two parents .. \"odom\" .. \"vicon\"");
    refused(&fixed("odom -> base_link", here), "\"base_link\" .. moving, which counts .. static");
    refused(&moving("base_link -> camera", 0, here), "\"camera\" .. static, which counts .. moving");
    assert_eq!(tree.transform("map", "camera", 0), Ok(before));
    // A publisher that has been silent for longer than transforms are kept has another successor.
    let later = moving("vicon -> base_link", KEPT_NS + 1, here);
    assert_eq!(tree.insert(&later), Ok(Change::Added));
    assert!(tree.transform("vicon", "camera", KEPT_NS + 1).is_ok());
}

#[test]
fn transforms_may_come_in_another_order_and_twice() {
    let mut tree = FrameTree::default();
    let mut insert =
        |time_ns: i64, x: f64| tree.insert(&moving("a -> b", time_ns, pose(x, 0.0, 0.0))).unwrap();
    assert_eq!(insert(SECOND, 1.0), Change::Added);
    assert_eq!(insert(0, 0.0), Change::Added);
    assert_eq!(insert(SECOND, 1.0), Change::Known);
    assert_near(&tree.transform("a", "b", SECOND / 4).unwrap(), &pose(0.25, 0.0, 0.0));
}

#[test]
fn a_clock_that_is_set_back_begins_a_history_anew() {
    let mut tree = tree(&[moving("a -> b", 1000 * SECOND, pose(1.0, 0.0, 0.0))]);
    for (seconds, expected) in [(998, Change::Added), (997, Change::Restarted), (10, Change::Restarted)] {
        let back = tree.insert(&moving("a -> b", seconds * SECOND, pose(2.0, 0.0, 0.0)));
        assert_eq!(back, Ok(expected), "{seconds}");
    }
    assert_eq!(tree.newest_ns("a", "b"), Ok(Some(10 * SECOND)));
    let error = tree.transform("a", "b", 1000 * SECOND).unwrap_err();
    assert!(error.may_pass(), "{error}");
}

#[test]
fn memory_is_bounded() {
    let mut tree = FrameTree::default();
    for number in 0..5000 {
        // 10 000 a second.
        tree.insert(&moving("a -> b", number * 100_000, pose(0.0, 0.0, 0.0))).unwrap();
    }
    assert!(tree.transform("a", "b", 100_000).is_err());
    assert!(tree.transform("a", "b", 4000 * 100_000).is_ok());
    let frames = (0..2000)
        .filter(|number| tree.insert(&fixed(&format!("a -> c{number}"), pose(0.0, 0.0, 0.0))).is_ok());
    assert_eq!(frames.count(), MAX_FRAMES - 1);
}
