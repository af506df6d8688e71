//! What comes of the areas that are drawn on a map: cells that are searched, and cells that nobody enters.

use super::Scenario;
use crate::map_file::Purpose;

/// What comes of an area that says where robots search or that they do not enter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// Its name.
    pub name: String,
    /// Its kind, as files say it.
    pub kind: &'static str,
    /// Searched cells that it covers, if only in part, or closes: those are still searched, from beside.
    pub cells: usize,
    /// Of a no-go area how many of its polygons and lines lie beyond the map.
    pub beyond: usize,
    /// Of so many.
    pub barriers: usize,
}

impl Scenario {
    /// What comes of each search area and each no-go area, in the order of their file.
    #[must_use]
    pub fn drawn(&self) -> Vec<Drawn> {
        let Some(frame) = self.georeference() else { return Vec::new() };
        let (terrain, file) = (self.terrain(), &self.source().path);
        let (grid, cell_meters) = (terrain.grid(), terrain.cell_meters());
        let mut drawn = Vec::new();
        for area in self.areas().areas {
            let cells = match area.purpose {
                Purpose::Search(_) => {
                    area.weights(file, frame, terrain).map_or(0, |weights| weights.shares.len())
                }
                Purpose::NoGo(..) => {
                    let mut is_closed = vec![false; grid.cell_count()];
                    area.mark_closed(frame, grid, cell_meters, &mut is_closed);
                    terrain.searched_cells().filter(|cell| is_closed[cell.index()]).count()
                }
                Purpose::Prior { .. } | Purpose::LastKnownPosition { .. } => continue,
            };
            let (beyond, barriers) = area.barriers_beyond(frame, grid, cell_meters);
            drawn.push(Drawn { kind: area.purpose.word(), name: area.name, cells, beyond, barriers });
        }
        drawn
    }
}
