//! Maps of the ROS 2 `map_server`: a YAML file and its image.
//!
//! Pixels become occupancy exactly as `nav2_map_server` reads them (`map_io.cpp`, `loadMapFromFile`): with
//! `shade` the mean of red, green and blue from 0 to 1 (in mode `trinary` of an image with alpha, the mean of
//! the three and of the opacity) and `occupancy = negate ? shade : 1 - shade`,
//! - `trinary`: above `occupied_thresh` occupied, below `free_thresh` free, else unknown;
//! - `scale`: the same, but pixels that are not fully opaque are unknown and those between the thresholds
//!   take
//!   `round(100 (occupancy - free) / (occupied - free))`;
//! - `raw`: `round(255 shade)`, unknown above 100; `negate` and the thresholds play no part there.
//!
//! `nav2_map_server` leaves it to others what a value between free (0) and occupied (100) means. Here a pixel
//! is free if its value is 0, or in `raw` below `100 free_thresh`. Only free pixels are crossed and searched;
//! unknown ones are blocked and not searched: no plan should lead through what nobody has seen.

use std::path::Path;

use serde::Deserialize;

use super::picture::{self, Picture, Shade};
use super::raster::Raster;
use super::{MapFile, MapFileError, MapOrigin, read_text};

/// The YAML file. Keys that other tools add are ignored, as by `nav2_map_server`.
#[derive(Deserialize)]
struct Header {
    image: String,
    resolution: f64,
    origin: Vec<f64>,
    negate: Negate,
    occupied_thresh: f64,
    free_thresh: f64,
    #[serde(default)]
    mode: Mode,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

/// `map_server` takes a number or a boolean.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
enum Negate {
    Number(i64),
    Flag(bool),
}

impl Negate {
    const fn is_set(self) -> bool {
        matches!(self, Self::Flag(true)) || matches!(self, Self::Number(number) if number != 0)
    }
}

pub(super) fn load(file: &Path, cell_meters: f64) -> Result<MapFile, MapFileError> {
    let header = read_header(file, &read_text(file)?)?;
    let picture = picture::load(&file.with_file_name(&header.image))?;
    let terrain = raster(&header, &picture).terrain(file, cell_meters)?;
    let origin =
        MapOrigin { x_meters: header.origin[0], y_meters: header.origin[1], yaw_radians: header.origin[2] };
    Ok(MapFile { origin, ..MapFile::unplaced(terrain) })
}

fn read_header(file: &Path, text: &str) -> Result<Header, MapFileError> {
    let header: Header = serde_path_to_error::deserialize(serde_yaml_ng::Deserializer::from_str(text))
        .map_err(|error| MapFileError::syntax(file, error))?;
    let is_length = header.resolution.is_finite() && header.resolution > 0.0;
    if !is_length {
        let allowed = "a finite length in metres above 0";
        return Err(MapFileError::value(file, "resolution", header.resolution, allowed));
    }
    if header.origin.len() != 3 || header.origin.iter().any(|value| !value.is_finite()) {
        let found = format!("{:?}", header.origin);
        return Err(MapFileError::value(file, "origin", found, "[x, y, yaw], finite"));
    }
    // Written so that NaN fails as well.
    if !(0.0 <= header.free_thresh
        && header.free_thresh < header.occupied_thresh
        && header.occupied_thresh <= 1.0)
    {
        let found = format!("{} and occupied_thresh {}", header.free_thresh, header.occupied_thresh);
        let allowed = "0 <= free_thresh < occupied_thresh <= 1";
        return Err(MapFileError::value(file, "free_thresh", found, allowed));
    }
    if header.image.is_empty() {
        return Err(MapFileError::value(file, "image", "empty", "the path of a PGM or PNG image"));
    }
    Ok(header)
}

fn raster(header: &Header, picture: &Picture) -> Raster {
    let averages_alpha = picture.has_alpha && matches!(header.mode, Mode::Trinary);
    let is_free = |shade: &Shade| {
        let brightness = f64::from(shade.brightness);
        let alpha = f64::from(shade.alpha);
        let shade = if averages_alpha { (3.0 * brightness + alpha) / 4.0 } else { brightness };
        is_free(header, shade, alpha)
    };
    Raster {
        columns: picture.columns,
        rows: picture.rows,
        pixel_meters: header.resolution,
        is_free: picture.shades.iter().map(is_free).collect(),
    }
}

fn is_free(header: &Header, shade: f64, alpha: f64) -> bool {
    let occupancy = if header.negate.is_set() { shade } else { 1.0 - shade };
    match header.mode {
        Mode::Trinary => occupancy < header.free_thresh,
        Mode::Scale => {
            let span = header.occupied_thresh - header.free_thresh;
            let value = (100.0 * (occupancy - header.free_thresh) / span).round_ties_even();
            alpha >= 1.0 && (occupancy < header.free_thresh || value <= 0.0)
        }
        Mode::Raw => (shade * 255.0).round() < 100.0 * header.free_thresh,
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use dragnet_search::terrain::Terrain;
    use proptest::prelude::*;

    use super::*;

    const YAML: &str = "image: a.pgm\nresolution: 0.5\norigin: [1.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";

    fn load(yaml: &str, image: &[u8], cell_meters: f64) -> Result<MapFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.yaml");
        fs::write(&file, yaml).unwrap();
        fs::write(folder.path().join("a.pgm"), image).unwrap();
        super::load(&file, cell_meters).map_err(|error| error.to_string())
    }

    fn check(yaml: &str, image: &[u8], expected: &str) {
        let map = load(yaml, image, 0.5).unwrap();
        assert_eq!(map.terrain, Terrain::from_ascii(expected, 0.5).unwrap(), "{yaml}");
    }

    #[test]
    fn only_free_pixels_are_open() {
        // Occupancy 0, 0.196, 0.251, 0.6, 1: free, free, unknown, unknown, occupied.
        let image = b"P2 5 1 255  255 205 191 102 0";
        check(YAML, image, "..###");
        check(&YAML.replace("negate: 0", "negate: true"), image, "####.");
        check(&format!("{YAML}mode: scale\n"), image, "...##");
        check(&format!("{YAML}mode: raw\n"), b"P2 5 1 255  0 24 25 100 255", "..###");
    }

    #[test]
    fn the_first_line_of_the_image_is_the_northern_edge() {
        check(YAML, b"P2 2 2 255  255 0  0 0", ".#\n##");
    }

    #[test]
    fn the_origin_is_kept() {
        let origin = load(&YAML.replace("0.0]", "0.5]"), b"P2 1 1 255 255", 0.5).unwrap().origin;
        assert_eq!(origin, MapOrigin { x_meters: 1.0, y_meters: -2.0, yaw_radians: 0.5 });
    }

    #[test]
    fn see_through_pixels_are_unknown_in_scale_and_darker_in_trinary() {
        let folder = tempfile::tempdir().unwrap();
        let pixels = [255, 255, 255, 255, 255, 255, 255, 0];
        let image = image::RgbaImage::from_raw(2, 1, pixels.to_vec()).unwrap();
        image.save(folder.path().join("a.png")).unwrap();
        let file = folder.path().join("a.yaml");
        for mode in ["trinary", "scale"] {
            fs::write(&file, format!("{}mode: {mode}\n", YAML.replace("a.pgm", "a.png"))).unwrap();
            let terrain = super::load(&file, 0.5).unwrap().terrain;
            assert_eq!(terrain, Terrain::from_ascii(".#", 0.5).unwrap(), "{mode}");
        }
    }

    #[test]
    fn a_bad_header_names_its_key() {
        let image = b"P2 1 1 255 255";
        let check = |from: &str, to: &str, message: &str| {
            let error = load(&YAML.replace(from, to), image, 0.5).unwrap_err();
            assert!(error.contains("a.yaml: ") && error.contains(message), "{error}");
        };
        check("0.5", ".nan", "resolution is NaN; allowed is a finite length in metres above 0");
        check("0.5", "-0.5", "resolution is -0.5");
        check("0.5", "wide", "resolution: invalid type: string \"wide\", expected f64 at line 2");
        check("0.65", "0.2", "free_thresh is 0.25 and occupied_thresh 0.2; allowed is 0 <= free_thresh <");
        check("0.65", ".nan", "occupied_thresh NaN");
        check("[1.0, -2.0, 0.0]", "[1.0]", "origin is [1.0]; allowed is [x, y, yaw], finite");
        check("negate: 0", "negate: 0\nmode: grey", "unknown variant `grey`, expected one of `trinary`");
        check("image: a.pgm", "picture: a.pgm", "missing field `image`");
        check("image: a.pgm", "image: ''", "image is empty; allowed is the path of a PGM or PNG");
    }

    #[test]
    fn a_missing_image_and_cells_below_a_pixel_are_refused() {
        let error = load(&YAML.replace("a.pgm", "b.pgm"), b"", 0.5).unwrap_err();
        assert!(error.contains("b.pgm: No such file"), "{error}");
        let error = load(YAML, b"P2 1 1 255 255", 0.25).unwrap_err();
        let expected = "cell edge is 0.25 m; allowed is at least the map's pixel of 0.5 m";
        assert!(error.contains(expected), "{error}");
    }

    proptest! {
        #[test]
        fn whatever_the_header_it_is_read_or_refused(
            text in "\\PC{0,60}",
            values in "(resolution: [-.0-9einfa]{1,8}\n)?(origin: [\\[\\]0-9,. ]{0,9}\n)?(negate: \\PC{0,6}\n)?",
        ) {
            let file = Path::new("a.yaml");
            let _ = read_header(file, &text);
            let _ = read_header(file, &format!("image: a\noccupied_thresh: 1\nfree_thresh: 0\n{values}"));
        }
    }
}
