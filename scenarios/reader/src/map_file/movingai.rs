//! Grid maps of the `MovingAI` benchmarks (Sturtevant, "Benchmarks for Grid-Based Pathfinding", 2012).
//!
//! ```text
//! type octile
//! height 2
//! width 3
//! map
//! ..@
//! .GT
//! ```
//!
//! The first row is the northern edge. `.`, `G` (ground) and `S` (swamp) are passable and open here; all
//! other characters (`@` and `O` out of bounds, `T` trees, `W` water) are blocked. The format has no length:
//! a character is a cell.

use std::path::Path;

use dragnet_search::cell::Grid;
use dragnet_search::terrain::{Ground, Terrain, TerrainError};

use super::MapFileError;

/// Lines with their numbers, from 1.
type Lines<'a> = std::iter::Enumerate<std::str::Lines<'a>>;

pub(super) fn read(file: &Path, text: &str, cell_meters: f64) -> Result<Terrain, MapFileError> {
    let mut lines = text.lines().enumerate();
    let grid = read_header(file, &mut lines)?;
    let mut rows = Vec::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        rows.push(read_row(file, index + 1, line.trim_end(), grid)?);
    }
    if rows.len() != grid.rows() as usize {
        let place = "number of map lines";
        return Err(MapFileError::value(file, place, rows.len(), format!("height {}", grid.rows())));
    }
    let ground = rows.into_iter().rev().flatten().collect();
    Terrain::new(grid, cell_meters, ground).map_err(|source| invalid(file, source))
}

fn read_header(file: &Path, lines: &mut Lines<'_>) -> Result<Grid, MapFileError> {
    expect_line(file, lines, 1, "type octile")?;
    let rows = read_size(file, lines, 2, "height")?;
    let columns = read_size(file, lines, 3, "width")?;
    expect_line(file, lines, 4, "map")?;
    Grid::new(rows, columns).map_err(|error| invalid(file, error.into()))
}

fn expect_line(file: &Path, lines: &mut Lines<'_>, number: usize, allowed: &str) -> Result<(), MapFileError> {
    let found = lines.next().map_or("", |(_, line)| line.trim());
    if found == allowed { Ok(()) } else { Err(wrong_line(file, number, found, &format!("`{allowed}`"))) }
}

fn read_size(file: &Path, lines: &mut Lines<'_>, number: usize, name: &str) -> Result<u32, MapFileError> {
    let found = lines.next().map_or("", |(_, line)| line.trim());
    found
        .strip_prefix(name)
        .and_then(|size| size.trim().parse().ok())
        .ok_or_else(|| wrong_line(file, number, found, &format!("`{name}` and a number of cells")))
}

fn read_row(file: &Path, number: usize, line: &str, grid: Grid) -> Result<Vec<Ground>, MapFileError> {
    let ground: Vec<Ground> = line
        .chars()
        .map(|character| match character {
            '.' | 'G' | 'S' => Ground::OPEN,
            _ => Ground::BLOCKED,
        })
        .collect();
    if ground.len() == grid.columns() as usize {
        Ok(ground)
    } else {
        let found = format!("{} characters long", ground.len());
        let allowed = format!("width {}", grid.columns());
        Err(MapFileError::value(file, format!("line {number}"), found, allowed))
    }
}

fn wrong_line(file: &Path, number: usize, found: &str, allowed: &str) -> MapFileError {
    let shown: String = found.chars().take(40).collect();
    MapFileError::value(file, format!("line {number}"), format!("{shown:?}"), allowed)
}

fn invalid(file: &Path, source: TerrainError) -> MapFileError {
    MapFileError::Terrain { file: file.to_owned(), source }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mentions::assert_mentions;

    fn read(text: &str) -> Result<Terrain, String> {
        super::read(Path::new("a.map"), text, 2.0).map_err(|error| error.to_string())
    }

    #[test]
    fn ground_and_swamp_are_open_and_all_else_is_blocked() {
        let terrain = read("type octile\nheight 2\nwidth 4\nmap\n.GS@\nOTW.\n").unwrap();
        assert_eq!(terrain, Terrain::from_ascii("...#\n###.", 2.0).unwrap());
    }

    #[test]
    fn a_false_header_is_rejected() {
        let check = |text: &str, message: &str| {
            let error = read(text).unwrap_err();
            assert_mentions(&error, message);
        };
        check("", "a.map .. line 1 .. \"\" .. `type octile`");
        check("type octile\nwidth 3\n", "line 2 .. \"width 3\" .. `height`");
        check("type octile\nheight 2\nwidth -3\nmap\n", "line 3 .. \"width -3\"");
        check("type octile\nheight 0\nwidth 3\nmap\n", "0 rows .. 3 columns .. 1 to");
        check("type octile\nheight 99999\nwidth 99999\nmap\n", "allowed are 1 to 16777216 cells");
        check("type octile\nheight 1\nwidth 3\nmap\n..\n", "line 5 .. 2 .. width 3");
        check("type octile\nheight 2\nwidth 2\nmap\n..\n", "map lines .. 1 .. height 2");
        check("type octile\nheight 1\nwidth 2\nmap\n..\n..\n", "map lines .. 2 .. height 1");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_rejected(
            header in "(type octile\n)?(height [0-9]{1,12}\n)?(width [0-9]{1,3}\n)?(map\n)?",
            rest in "[.@TGSW\n]{0,60}|\\PC{0,60}",
        ) {
            let _ = read(&format!("{header}{rest}"));
        }
    }
}
