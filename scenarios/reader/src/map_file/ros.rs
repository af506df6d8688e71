//! Maps of the ROS 2 `map_server`: a YAML file and its image.
//!
//! Both are read as `nav2_map_server` does (`map_io.cpp`, of 2026): numbers may be quoted, `negate` is a number or any
//! word that YAML 1.1 has for yes and no, and modes are written in any case. With `shade` the brightness of a pixel in
//! 255 steps, from 0 to 1, and `occupancy = negate ? shade : 1 - shade`, both in single precision,
//! - `trinary`: from `occupied_thresh` on occupied, up to `free_thresh` free, else unknown;
//! - `scale`: the same, but those between the thresholds take `round(100 (occupancy - free) / (occupied - free))`;
//! - in both, pixels that are not fully opaque are unknown;
//! - `raw`: `255 shade`, unknown above 100; `negate`, the thresholds and opacity play no part there.
//!
//! `nav2_map_server` does not define values between free (0) and occupied (100). Here a pixel is free if its value is
//! 0, or in `raw` below `100 free_thresh`. Only free pixels are traversable and searched; unknown ones are blocked and
//! not searched, since no plan should lead through unmapped space.

use std::path::Path;

use dragnet_files::in_words;
use serde::{Deserialize, Deserializer};

use super::picture::{self, Picture, Shade};
use super::raster::{Extent, Raster};
use super::{MapFile, MapFileError, MapOrigin, read_text_at_most};

/// The maximum size of the YAML file, bytes: a hundred times the usual size.
const MAX_HEADER_BYTES: u64 = 1 << 16;

/// The YAML file. Keys that other tools add are ignored, as by `nav2_map_server`.
#[derive(Deserialize)]
struct Header {
    image: String,
    #[serde(deserialize_with = "number")]
    resolution: f64,
    origin: Vec<Scalar>,
    #[serde(deserialize_with = "flag")]
    negate: bool,
    #[serde(deserialize_with = "number")]
    occupied_thresh: f64,
    #[serde(deserialize_with = "number")]
    free_thresh: f64,
    #[serde(default, deserialize_with = "mode")]
    mode: Mode,
}

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

/// A value as read by `map_server`: quotes change nothing.
#[derive(Clone, Deserialize)]
#[serde(untagged)]
enum Scalar {
    Flag(bool),
    Integer(i64),
    Number(f64),
    Text(String),
}

impl Scalar {
    fn number(&self) -> Result<f64, String> {
        match self {
            Self::Integer(integer) => Ok(*integer as f64),
            Self::Number(number) => Ok(*number),
            Self::Flag(flag) => Err(format!("{flag} is no number")),
            Self::Text(text) => text.trim().parse().map_err(|_| format!("{text:?} is no number")),
        }
    }

    /// A whole number, or else a word of YAML 1.1: small, large, or with a large first letter.
    fn flag(&self) -> Result<bool, String> {
        let allowed = "a whole number, or yes, no, true, false, on, off, y or n";
        let text = match self {
            Self::Flag(flag) => return Ok(*flag),
            Self::Integer(integer) => return Ok(*integer != 0),
            Self::Number(number) => return Err(format!("{number} is neither; allowed is {allowed}")),
            Self::Text(text) => text.trim(),
        };
        if let Ok(integer) = text.parse::<i64>() {
            return Ok(integer != 0);
        }
        let small = text.to_lowercase();
        let is_cased =
            text.to_uppercase() == text || text.chars().skip(1).all(|letter| !letter.is_uppercase());
        match small.as_str() {
            "yes" | "true" | "on" | "y" if is_cased => Ok(true),
            "no" | "false" | "off" | "n" if is_cased => Ok(false),
            _ => Err(format!("{text:?} is neither; allowed is {allowed}")),
        }
    }
}

fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Scalar::deserialize(deserializer)?.number().map_err(serde::de::Error::custom)
}

fn flag<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    Scalar::deserialize(deserializer)?.flag().map_err(serde::de::Error::custom)
}

fn mode<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Mode, D::Error> {
    let word = String::deserialize(deserializer)?;
    match word.to_lowercase().as_str() {
        "trinary" => Ok(Mode::Trinary),
        "scale" => Ok(Mode::Scale),
        "raw" => Ok(Mode::Raw),
        _ => Err(serde::de::Error::custom(format!("{word:?}; allowed is trinary, scale or raw"))),
    }
}

pub(super) fn load(file: &Path, cell_meters: f64) -> Result<MapFile, MapFileError> {
    let (header, origin, picture) = read(file)?;
    let is_free = picture.shades.iter().map(|shade| is_free(&header, *shade)).collect();
    let terrain = Raster { extent: extent_of(&header, &picture), is_free }.terrain(file, cell_meters)?;
    Ok(MapFile { origin, ..MapFile::unplaced(terrain) })
}

/// A map as a mask: which of its pixels are occupied.
pub(super) struct Mask {
    pub(super) extent: Extent,
    pub(super) origin: MapOrigin,
    /// Shape `[rows * columns]`, row 0 south, column 0 west.
    pub(super) is_occupied: Vec<bool>,
}

pub(super) fn mask(file: &Path) -> Result<Mask, MapFileError> {
    let (header, origin, picture) = read(file)?;
    let is_occupied = picture.shades.iter().map(|shade| is_occupied(&header, *shade)).collect();
    Ok(Mask { extent: extent_of(&header, &picture), origin, is_occupied })
}

fn read(file: &Path) -> Result<(Header, MapOrigin, Picture), MapFileError> {
    let (header, origin) = read_header(file, &read_text_at_most(file, MAX_HEADER_BYTES)?)?;
    let picture =
        picture::load(&file.with_file_name(&header.image)).map_err(|error| of_image(file, &error))?;
    Ok((header, origin, picture))
}

fn extent_of(header: &Header, &Picture { columns, rows, .. }: &Picture) -> Extent {
    Extent { columns, rows, pixel_meters: header.resolution }
}

/// The size of a map, without its pixels.
pub(super) fn extent(file: &Path) -> Result<Extent, MapFileError> {
    let (header, _) = read_header(file, &read_text_at_most(file, MAX_HEADER_BYTES)?)?;
    let size = picture::size(&file.with_file_name(&header.image));
    let (columns, rows) = size.map_err(|error| of_image(file, &error))?;
    Ok(Extent { columns, rows, pixel_meters: header.resolution })
}

/// The image is at fault, or its name in this file.
fn of_image(file: &Path, error: &MapFileError) -> MapFileError {
    MapFileError::syntax(file, format!("image: {error}"))
}

fn read_header(file: &Path, text: &str) -> Result<(Header, MapOrigin), MapFileError> {
    let header: Header = serde_path_to_error::deserialize(serde_yaml_ng::Deserializer::from_str(text))
        .map_err(|error| MapFileError::syntax(file, in_words(&error.to_string())))?;
    let is_length = header.resolution.is_finite() && header.resolution > 0.0;
    if !is_length {
        let allowed = "a finite length in meters above 0";
        return Err(MapFileError::value(file, "resolution", header.resolution, allowed));
    }
    let origin: Result<Vec<f64>, String> = header.origin.iter().map(Scalar::number).collect();
    let origin = origin.map_err(|error| MapFileError::syntax(file, format!("origin: {error}")))?;
    let &[x_meters, y_meters, yaw_radians] = origin.as_slice() else {
        let found = format!("{} numbers", origin.len());
        return Err(MapFileError::value(file, "origin", found, "[x, y, yaw]"));
    };
    if origin.iter().any(|value| !value.is_finite()) {
        return Err(MapFileError::value(file, "origin", format!("{origin:?}"), "[x, y, yaw], finite"));
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
    Ok((header, MapOrigin { x_meters, y_meters, yaw_radians }))
}

#[expect(clippy::cast_possible_truncation, reason = "as map_server does")]
fn is_free(header: &Header, pixel: Shade) -> bool {
    let occupancy = occupancy(header, pixel);
    let (free, occupied) = (header.free_thresh as f32, header.occupied_thresh as f32);
    match header.mode {
        Mode::Trinary => is_opaque(pixel) && occupancy <= free,
        Mode::Scale => {
            let value = (100.0 * ((occupancy - free) / (occupied - free))).round();
            is_opaque(pixel) && (occupancy <= free || (value <= 0.0 && occupancy < occupied))
        }
        Mode::Raw => f64::from(steps(pixel.brightness)) < 100.0 * header.free_thresh,
    }
}

/// Whether `map_server` makes 100 of a pixel.
#[expect(clippy::cast_possible_truncation, reason = "as map_server does")]
fn is_occupied(header: &Header, pixel: Shade) -> bool {
    match header.mode {
        Mode::Trinary | Mode::Scale => {
            is_opaque(pixel) && occupancy(header, pixel) >= header.occupied_thresh as f32
        }
        Mode::Raw => (steps(pixel.brightness) - 100.0).abs() < 0.5,
    }
}

/// In single precision, as in `map_server`.
fn occupancy(header: &Header, pixel: Shade) -> f32 {
    let shade = steps(pixel.brightness) / 255.0;
    if header.negate { shade } else { 1.0 - shade }
}

fn is_opaque(pixel: Shade) -> bool {
    steps(pixel.alpha) >= 255.0
}

fn steps(value: f32) -> f32 {
    (255.0 * value).round()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use dragnet_search::terrain::Terrain;
    use proptest::prelude::*;

    use super::*;
    use crate::mentions::assert_mentions;

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
    fn see_through_pixels_are_unknown() {
        let folder = tempfile::tempdir().unwrap();
        let pixels = [255, 255, 255, 255, 255, 255, 255, 254];
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
    fn values_are_read_as_map_server_reads_them() {
        let image = b"P2 2 1 255  255 0";
        for no in ["no", "No", "NO", "false", "off", "n", "0", "'0'", "\"no\""] {
            check(&YAML.replace("negate: 0", &format!("negate: {no}")), image, ".#");
        }
        for yes in ["yes", "True", "ON", "y", "1", "'1'", "-7"] {
            check(&YAML.replace("negate: 0", &format!("negate: {yes}")), image, "#.");
        }
        for mode in ["Trinary", "TRINARY", "'trinary'", "Scale"] {
            check(&format!("{YAML}mode: {mode}\n"), image, ".#");
        }
        let quoted = YAML.replace("0.5", "'0.5'").replace("-2.0", "\"-2\"").replace("0.25", "'.25'");
        assert_eq!(load(&quoted, image, 0.5).unwrap(), load(YAML, image, 0.5).unwrap());
        // A threshold itself is free: 1 - 204 / 255 is 0.2 in single precision.
        check(&YAML.replace("0.25", "0.2"), b"P2 2 1 255  204 203", ".#");
    }

    #[test]
    fn a_colored_pixel_is_as_bright_as_its_luma() {
        let folder = tempfile::tempdir().unwrap();
        let image = image::RgbImage::from_raw(3, 1, vec![0, 255, 0, 255, 0, 0, 200, 200, 200]).unwrap();
        image.save(folder.path().join("a.png")).unwrap();
        let file = folder.path().join("a.yaml");
        fs::write(&file, YAML.replace("a.pgm", "a.png").replace("0.25", "0.3")).unwrap();
        let terrain = super::load(&file, 0.5).unwrap().terrain;
        assert_eq!(terrain, Terrain::from_ascii(".#.", 0.5).unwrap());
    }

    #[test]
    fn a_bad_header_names_its_key() {
        let image = b"P2 1 1 255 255";
        let check = |from: &str, to: &str, message: &str| {
            let error = load(&YAML.replace(from, to), image, 0.5).unwrap_err();
            assert_mentions(&error, &format!("a.yaml .. {message}"));
        };
        check("0.5", ".nan", "resolution .. NaN .. above 0");
        check("0.5", "-0.5", "resolution .. -0.5");
        check("0.5", "wide", "resolution: \"wide\" is no number");
        check("0.65", "0.2", "free_thresh .. 0.25 .. occupied_thresh .. 0.2 .. 0 <= free_thresh <");
        check("0.65", ".nan", "occupied_thresh .. NaN");
        check("[1.0, -2.0, 0.0]", "[1.0]", "origin .. 1 .. [x, y, yaw]");
        check("negate: 0", "negate: 0\nmode: gray", "mode .. \"gray\" .. trinary, scale or raw");
        check("negate: 0", "negate: perhaps", "negate .. \"perhaps\" .. a whole number");
        check("negate: 0", "negate: nO", "negate .. \"nO\"");
        check("-2.0", "far", "origin .. \"far\"");
        check("image: a.pgm", "picture: a.pgm", "missing .. `image`");
        check("image: a.pgm", "image: ''", "image .. empty .. PGM or PNG");
    }

    #[test]
    fn a_missing_image_and_cells_below_a_pixel_are_rejected() {
        let error = load(&YAML.replace("a.pgm", "b.pgm"), b"", 0.5).unwrap_err();
        assert!(error.contains("b.pgm: No such file"), "{error}");
        let error = load(YAML, b"P2 1 1 255 255", 0.25).unwrap_err();
        let expected = "cell edge .. 0.25 m .. 0.5 m";
        assert_mentions(&error, expected);
    }

    proptest! {
        #[test]
        fn any_header_is_read_or_rejected(
            text in "\\PC{0,60}",
            values in "(resolution: [-.0-9einfa]{1,8}\n)?(origin: [\\[\\]0-9,. ]{0,9}\n)?(negate: \\PC{0,6}\n)?",
        ) {
            let file = Path::new("a.yaml");
            let _ = read_header(file, &text);
            let _ = read_header(file, &format!("image: a\noccupied_thresh: 1\nfree_thresh: 0\n{values}"));
        }
    }
}
