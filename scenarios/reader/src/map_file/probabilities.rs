//! Prior probabilities from a file: one number per cell, the northern edge first.

use std::path::Path;

use dragnet_search::cell::Grid;

use super::{MapFileError, picture, read_text};

/// The prior probability of an object, shape `[cells]` by index, from
/// - `.csv` or `.txt`: one line per row, the northern edge first, numbers from 0 to below 1 separated by commas,
///   semicolons or spaces;
/// - `.pgm` or `.png`: one pixel per cell, the northern edge first, brightness 0 to 1 times 255/256, so that white is
///   likely and not certain.
///
/// # Errors
/// If the file cannot be read, does not fit the grid, or holds a number outside `0.0..1.0`.
pub fn load_probabilities(file: &Path, grid: Grid) -> Result<Vec<f64>, MapFileError> {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("csv" | "txt") => read_numbers(file, &read_text(file)?, grid),
        Some("pgm" | "png") => {
            let picture = picture::load(file)?;
            check_size(file, picture.rows as usize, picture.columns as usize, grid)?;
            let probability = |shade: &picture::Shade| f64::from(shade.brightness) * 255.0 / 256.0;
            Ok(picture.shades.iter().map(probability).collect())
        }
        _ => Err(MapFileError::Extension {
            file: file.to_owned(),
            allowed: ".csv or .txt numbers, .pgm or .png image, .geojson or .kml regions, .belief.json of `dragnet export`",
        }),
    }
}

fn read_numbers(file: &Path, text: &str, grid: Grid) -> Result<Vec<f64>, MapFileError> {
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let row = read_row(file, index + 1, line)?;
        if row.len() != grid.columns() as usize {
            let allowed = format!("the map's {} columns", grid.columns());
            let (place, found) = (format!("line {}", index + 1), format!("{} columns", row.len()));
            return Err(MapFileError::value(file, place, found, allowed));
        }
        rows.push(row);
    }
    check_size(file, rows.len(), grid.columns() as usize, grid)?;
    Ok(rows.into_iter().rev().flatten().collect())
}

fn read_row(file: &Path, line_number: usize, line: &str) -> Result<Vec<f64>, MapFileError> {
    let is_separator = |c: char| c == ',' || c == ';' || c.is_whitespace();
    line.split(is_separator)
        .filter(|word| !word.is_empty())
        .enumerate()
        .map(|(index, word)| {
            word.parse().ok().filter(|probability| (0.0..1.0).contains(probability)).ok_or_else(|| {
                let place = format!("line {line_number}, column {}", index + 1);
                MapFileError::value(file, place, format!("{word:?}"), "a number from 0 to below 1")
            })
        })
        .collect()
}

fn check_size(file: &Path, rows: usize, columns: usize, grid: Grid) -> Result<(), MapFileError> {
    if (rows, columns) == (grid.rows() as usize, grid.columns() as usize) {
        return Ok(());
    }
    let allowed = format!("the map's {} rows and {} columns", grid.rows(), grid.columns());
    Err(MapFileError::value(file, "size", format!("{rows} rows and {columns} columns"), allowed))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mentions::assert_mentions;

    fn read(text: &str) -> Result<Vec<f64>, String> {
        let grid = Grid::new(2, 3).unwrap();
        read_numbers(Path::new("a.csv"), text, grid).map_err(|error| error.to_string())
    }

    #[test]
    fn the_first_line_is_the_northern_edge() {
        assert_eq!(read("0.1,0.2,0.3\n0.4 0.5;0\n").unwrap(), [0.4, 0.5, 0.0, 0.1, 0.2, 0.3]);
    }

    #[test]
    fn a_bad_number_names_its_place() {
        let check = |text: &str, message: &str| {
            let error = read(text).unwrap_err();
            assert_mentions(&error, message);
        };
        check("0,0,0\n0,1,0\n", "a.csv .. line 2 .. column 2 .. \"1\" .. 0 to below 1");
        check("0,0,0\n0,nan,0\n", "\"nan\"");
        check("0,0\n", "line 1 .. 2 columns .. the map's 3 columns");
        check("0,0,0\n\n0\n", "line 3 .. 1 columns .. the map's 3 columns");
        check("0,0,0\n", "1 rows and 3 columns");
    }

    #[test]
    fn a_white_pixel_is_likely_and_not_certain() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.pgm");
        std::fs::write(&file, "P2 2 1 255 0 255").unwrap();
        let probabilities = load_probabilities(&file, Grid::new(1, 2).unwrap()).unwrap();
        assert_eq!(probabilities, [0.0, 255.0 / 256.0]);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_rejected(text in "([-0-9.e, ]{0,12}\n){0,3}|\\PC{0,40}") {
            let _ = read(&text);
        }
    }
}
