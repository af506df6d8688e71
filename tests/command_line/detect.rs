//! `dragnet detect`: from a network and images to boxes.

#[cfg(not(feature = "eyes"))]
#[test]
fn without_a_detector_the_error_explains_how_to_get_one() {
    let said = ["--features onnx", "--features detector"];
    super::Place::new().refuse(&["detect", "--module", "a", "b.png"], &said);
}

/// As in programs for robots.
#[cfg(all(feature = "eyes", not(feature = "detector")))]
#[test]
fn without_libtorch_the_error_explains_how_to_read_modules() {
    let place = super::Place::new();
    let said = ["small.toml: a TorchScript module", "built without", "--features detector"];
    place.refuse(&["detect", "--module", "small.toml", "b.png"], &said);
}

/// What a fresh checkout can do: its own network on its own picture.
#[cfg(feature = "onnx")]
#[test]
fn the_example_network_finds_what_is_painted_in_the_example_picture() {
    let place = super::Place::new();
    let example =
        |name: &str| super::root().join("vehicle/detector/example").join(name).display().to_string();
    let (network, picture) = (example("figures.onnx"), example("field.jpg"));
    let report = place.json(&["detect", "--module", &network, &picture, "--json"]);
    let mut names: Vec<&str> = report["images"][0]["boxes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|found| found["name"].as_str().unwrap())
        .collect();
    names.sort_unstable();
    assert_eq!(names, ["barrel", "person", "person", "post"], "{report}");
}

#[cfg(all(feature = "detector", feature = "onnx"))]
mod with_networks {
    use std::fs;
    use std::process::Command;

    use image::{ImageReader, Rgb, RgbImage};
    use serde_json::Value;

    use crate::interpreter::interpreter;
    use crate::{Place, root};

    /// Faces forward; a fifth of the image is 10 degrees and more.
    const CAMERA: &str = "name = 'wide'\nwidth_pixels = 192\nheight_pixels = 128\nfield_of_view_degrees = 90\nyaw_degrees = 10\nmin_range_meters = 2\n\
                          max_range_meters = 100\n";

    /// With modules for 96 x 64 pixels, and `red.png` of 192 x 128: red upright from column 60 and row 40 on.
    fn place() -> Place {
        let place = Place::new();
        let script = root().join("tests/python/modules.py");
        let made = Command::new(interpreter(root())).arg(script).arg(place.folder.path()).output().unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        place.write("camera.toml", CAMERA);
        let is_red = |column, row| (60..80).contains(&column) && (40..80).contains(&row);
        let color = |column, row| Rgb(if is_red(column, row) { [230, 10, 10] } else { [114; 3] });
        RgbImage::from_fn(192, 128, color).save(place.path("red.png")).unwrap();
        RgbImage::from_pixel(192, 128, Rgb([114; 3])).save(place.path("gray.jpg")).unwrap();
        place
    }

    #[test]
    fn boxes_are_printed_tabulated_and_drawn() {
        for module in ["red.torchscript", "red.onnx"] {
            check_printed(module);
        }
    }

    fn check_printed(module: &str) {
        let place = place();
        let detect = ["detect", "--module", module, "red.png"];
        let files = ["--camera", "camera.toml", "--csv", "boxes.csv", "--save", "found.png"];
        let reported = place.succeed(&[&detect as &[&str], &files].concat());
        // The box's center is 26 columns left of the image's, of which 96 are 45 degrees.
        let bearing = 10.0 + (26.0_f64 / 96.0).atan().to_degrees();
        let line = reported.lines().nth(1).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(line, format!("red.png person 0.900 60.0 40.0 80.0 80.0 {bearing:.2}"), "{reported}");
        assert!(reported.contains("192 x 128 pixels, taken down to 96 x 64, shown as 96 x 64"), "{reported}");
        assert!(reported.contains("written: boxes.csv\nwritten: found.png\n"), "{reported}");
        let csv = fs::read_to_string(place.path("boxes.csv")).unwrap();
        let mut rows = csv.lines();
        let titles =
            "image,class,name,confidence,left_pixels,top_pixels,right_pixels,bottom_pixels,bearing_radians";
        assert_eq!(rows.next(), Some(titles));
        assert!(rows.next().unwrap().starts_with("red.png,0,person,0.9,60.0,40.0,80.0,80.0,0.4"), "{csv}");
        assert_eq!(rows.next(), None);
        let drawn = ImageReader::open(place.path("found.png")).unwrap().decode().unwrap().into_rgb8();
        assert_eq!((drawn.get_pixel(60, 40).0, drawn.get_pixel(79, 79).0), ([230, 159, 0], [230, 159, 0]));
        assert_eq!((drawn.get_pixel(59, 39).0, drawn.get_pixel(61, 41).0), ([114; 3], [230, 10, 10]));
        place.refuse(&[&detect as &[&str], &files].concat(), &["boxes.csv", "exists already"]);
    }

    #[test]
    fn many_images_are_reported_as_one_object() {
        let place = place();
        let detect =
            ["detect", "--module", "red.torchscript", "gray.jpg", "red.png", "--json", "--resolution"];
        let report = place.json(&[&detect as &[&str], &["full"]].concat());
        assert_eq!((&report["input_columns"], &report["classes"]), (&96.into(), &2.into()));
        let images = report["images"].as_array().unwrap();
        assert_eq!(
            (&images[0]["file"], images[0]["boxes"].as_array().unwrap().len()),
            (&"gray.jpg".into(), 0)
        );
        let boxes = images[1]["boxes"].as_array().unwrap();
        assert_eq!(
            (boxes.len(), &boxes[0]["name"], &boxes[0]["bearing_radians"]),
            (1, &"person".into(), &Value::Null)
        );
        // Scaled to half by the letterbox now, which is the same here.
        let edges = ["left_pixels", "top_pixels", "right_pixels", "bottom_pixels"];
        assert_eq!(edges.map(|edge| boxes[0][edge].to_string()), ["60.0", "40.0", "80.0", "80.0"]);
        let other = place.json(&[&detect as &[&str], &["half", "--classes", "1,boat"]].concat());
        assert_eq!(other["images"][1]["boxes"], Value::Array(Vec::new()));
        let silent = ["detect", "--module", "silent.torchscript", "--input", "96x64", "--json", "red.png"];
        assert_eq!(place.json(&silent)["images"][0]["boxes"][0]["name"], Value::Null);
    }

    #[test]
    fn unusable_modules_are_rejected() {
        let place = place();
        let refuse = |module: &str, more: &[&str], said: &[&str]| {
            place.refuse(&[&["detect", "--module", module], more].concat(), said);
        };
        refuse("absent", &["red.png"], &["absent", "cannot read it"]);
        refuse("small.toml", &["red.png"], &["small.toml", "not a TorchScript module"]);
        fs::copy(place.path("small.toml"), place.path("small.onnx")).unwrap();
        refuse("small.onnx", &["red.png"], &["small.onnx", "not an ONNX network", "damaged"]);
        refuse(
            "red.onnx",
            &["red.png", "--input", "96x96"],
            &["red.onnx", "an input of 96 x 96", "fixed, 96 x 64"],
        );
        refuse("silent.torchscript", &["red.png"], &["the size of its input", "by --input"]);
        refuse("silent.torchscript", &["red.png", "--input", "9x"], &["--input", "such as 640x384"]);
        refuse("flat.torchscript", &["red.png"], &["flat.torchscript", "shape [6, 40]"]);
        let red = |more: &[&str], said: &[&str]| refuse("red.torchscript", more, said);
        red(&["absent.png"], &["absent.png", "no image that can be read"]);
        red(&["small.toml"], &["small.toml", "no image that can be read"]);
        red(&["red.png", "--classes", "dog"], &["--classes dog", "0 to 1, or person, boat"]);
        red(&["red.png", "--classes", "2"], &["--classes 2", "0 to 1"]);
        red(&["red.png", "--confidence", "1.5"], &["confidence of 1.5", "0 to 1"]);
        red(&["red.png", "--iou", "nan"], &["IoU of NaN", "0 to 1"]);
        red(&["red.png", "gray.jpg", "--save", "a.png"], &["--save", "one image only"]);
        place.write("narrow.toml", &CAMERA.replace("90", "190"));
        red(&["red.png", "--camera", "narrow.toml"], &["narrow.toml", "field of view", "below pi"]);
        place.write("wrong.toml", &format!("{CAMERA}zoom = 4\n"));
        red(&["red.png", "--camera", "wrong.toml"], &["wrong.toml", "unknown field `zoom`"]);

        // A module that fails on an image is not a mistake in the command line.
        let failed = place.dragnet(&["detect", "--module", "raises.torchscript", "red.png"]);
        assert_eq!(failed.status.code(), Some(1));
        assert!(crate::stderr(&failed).contains("red.png: the network failed"), "{}", crate::stderr(&failed));
    }
}
