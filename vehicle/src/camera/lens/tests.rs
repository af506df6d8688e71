use super::*;

fn lens(distortion: Distortion) -> Lens {
    Lens {
        width_pixels: 640,
        height_pixels: 480,
        focal_pixels: [500.0, 510.0],
        center_pixels: [320.0, 240.0],
        distortion,
    }
}

fn plumb_bob() -> Distortion {
    Distortion::Radial { radial: [-0.28, 0.09, -0.01, 0.0, 0.0, 0.0], tangential: [0.0012, -0.0007] }
}

fn rational() -> Distortion {
    Distortion::Radial { radial: [6.5, 3.2, 0.15, 6.9, 5.1, 0.9], tangential: [0.0005, -0.0003] }
}

const FISHEYE: Distortion = Distortion::Equidistant([0.02, -0.011, 0.004, -0.0008]);

/// The direction at `z = 1` of a pixel that counts from the center of the upper left one, as OpenCV's do.
fn at_one(lens: &Lens, [column, row]: [f64; 2]) -> [f64; 2] {
    let direction = lens.direction(column + 0.5, row + 0.5).unwrap();
    [direction.x / direction.z, direction.y / direction.z]
}

/// Pixels of directions by `cv2.projectPoints` and `cv2.fisheye.projectPoints` of OpenCV 5.0.0.
#[test]
fn directions_are_those_that_opencv_projects() {
    let directions = [[0.0, 0.0], [0.3, -0.2], [-0.5, 0.4], [0.55, 0.45]];
    for (distortion, pixels) in [
        (
            plumb_bob(),
            [
                [320.0, 240.0],
                [464.584_354_5, 141.731_258_94],
                [94.531_552_5, 424.116_077_16],
                [561.981_202_781_25, 442.400_878_775_624_96],
            ],
        ),
        (
            rational(),
            [
                [320.0, 240.0],
                [463.443_611_629_886_3, 142.478_234_091_677_34],
                [97.935_496_632_338_13, 421.259_000_748_012_1],
                [558.461_455_545_174_7, 439.198_915_627_700_33],
            ],
        ),
        (
            FISHEYE,
            [
                [320.0, 240.0],
                [464.287_272_004_687_57, 141.884_655_036_812_43],
                [96.420_416_543_848_2, 422.440_940_100_219_9],
                [560.577_010_903_709_4, 440.772_450_917_822_9],
            ],
        ),
    ] {
        for (pixel, [x, y]) in pixels.into_iter().zip(directions) {
            let found = at_one(&lens(distortion), pixel);
            let off = (found[0] - x).hypot(found[1] - y);
            assert!(off < 1e-7, "{distortion:?}, {pixel:?}: {found:?} is not {:?}", [x, y]);
        }
    }
    // Nearly 90 degrees from the axis.
    for (pixel, [x, y]) in [
        ([928.798_455_425_231_9, 446.991_474_844_578_8], [3.0, 1.0]),
        ([-377.210_457_745_848_9, 240.0], [-5.0, 0.0]),
    ] {
        let found = at_one(&lens(FISHEYE), pixel);
        assert!((found[0] - x).hypot(found[1] - y) < 1e-6, "{found:?}");
    }
}

/// What is distorted and undistorted is where it was, over the whole image and beyond what a fixed point finds.
#[test]
fn distortion_is_removed_all_over_the_image() {
    for (radial, tangential) in [
        ([0.0; 6], [0.0; 2]),
        ([-0.28, 0.09, -0.01, 0.0, 0.0, 0.0], [0.0012, -0.0007]),
        ([0.5, 0.3, 0.1, 0.0, 0.0, 0.0], [-0.01, 0.02]),
        ([6.5, 3.2, 0.15, 6.9, 5.1, 0.9], [0.0005, -0.0003]),
    ] {
        let mut farthest = 0.0_f64;
        for (column, row) in (0..=20).flat_map(|column| (0..=20).map(move |row| (column, row))) {
            let point = Vector2::new(f64::from(column - 10), f64::from(row - 10)) * 0.08;
            let (image, _) = distorted(&radial, &tangential, point);
            let found = undistorted(&radial, &tangential, image).unwrap();
            assert!((found - point).norm() < 1e-8, "{radial:?}: {point} became {found}");
            farthest = farthest.max((image - point).norm());
        }
        assert!(radial[0] == 0.0 || farthest > 0.1, "it did not distort");
    }
}

/// The derivative that Newton's method uses, against differences.
#[test]
fn the_derivative_is_that_of_the_image() {
    let (radial, tangential) = ([6.5, 3.2, 0.15, 6.9, 5.1, 0.9], [0.03, -0.02]);
    let point = Vector2::new(0.4, -0.3);
    let (_, jacobian) = distorted(&radial, &tangential, point);
    for axis in 0..2 {
        let mut aside = Vector2::zeros();
        aside[axis] = 1e-6;
        let image = |point| distorted(&radial, &tangential, point).0;
        let slope = (image(point + aside) - image(point - aside)) / 2e-6;
        assert!((slope - jacobian.column(axis)).norm() < 1e-7, "{slope} {jacobian}");
    }
}

#[test]
fn a_pinhole_has_its_view_between_its_edges() {
    let lens = Lens::pinhole(1000, 600, 90.0_f64.to_radians());
    for (column, row, expected) in
        [(0.0, 300.0, [-1.0, 0.0]), (1000.0, 300.0, [1.0, 0.0]), (500.0, 600.0, [0.0, 0.6])]
    {
        let direction = lens.direction(column, row).unwrap();
        assert!((direction.x / direction.z - expected[0]).abs() < 1e-12, "{direction:?}");
        assert!((direction.y / direction.z - expected[1]).abs() < 1e-12, "{direction:?}");
    }
}

#[test]
fn where_a_model_ends_there_is_no_direction() {
    // Its image folds over at a radius of 0.385 focal lengths.
    let folded = lens(Distortion::Radial { radial: [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0], tangential: [0.0; 2] });
    assert!(folded.direction(320.5 + 180.0, 240.5).is_some());
    assert!(folded.direction(320.5 + 250.0, 240.5).is_none());
    let fisheye = lens(Distortion::Equidistant([-0.2, 0.0, 0.0, 0.0]));
    assert!(fisheye.direction(320.5 + 300.0, 240.5).is_some());
    assert!(fisheye.direction(320.5 + 900.0, 240.5).is_none());
    assert!(lens(plumb_bob()).direction(f64::NAN, 0.0).is_none());
    assert!(lens(FISHEYE).direction(f64::NAN, 0.0).is_none());
}
