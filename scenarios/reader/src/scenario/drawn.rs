//! The effect of areas drawn on a map: searched cells, and closed cells.

use super::Scenario;
use crate::map_file::Purpose;

/// The effect of a search area or a no-go area.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// Its name.
    pub name: String,
    /// Its kind, as named in files.
    pub kind: &'static str,
    /// Searched cells that it covers at least in part, or closes: those are still searched, from outside.
    pub cells: usize,
    /// For a no-go area, the number of its polygons and lines that lie beyond the map.
    pub beyond: usize,
    /// Their total number.
    pub barriers: usize,
}

impl Scenario {
    /// The effect of each search area and each no-go area, in the order of their file.
    #[must_use]
    pub fn drawn(&self) -> Vec<Drawn> {
        let Some(frame) = self.georeference() else { return Vec::new() };
        let (terrain, file) = (self.terrain(), &self.source().path);
        let (grid, cell_meters) = (terrain.grid(), terrain.cell_meters());
        let mut drawn = Vec::new();
        // By which area each cell was closed last: so each is counted once for each area.
        let mut closed_by = vec![usize::MAX; grid.cell_count()];
        for (number, area) in self.areas().areas.into_iter().enumerate() {
            let cells = match area.purpose {
                Purpose::Search(_) => {
                    area.weights(file, frame, terrain).map_or(0, |weights| weights.shares.len())
                }
                Purpose::NoGo(..) => {
                    let mut cells = 0;
                    area.each_closed(frame, grid, cell_meters, |cell| {
                        let is_new = std::mem::replace(&mut closed_by[cell.index()], number) != number;
                        cells += usize::from(is_new && terrain.is_searched(cell));
                    });
                    cells
                }
                Purpose::Prior { .. }
                | Purpose::LastKnownPosition { .. }
                | Purpose::LinearFeature { .. }
                | Purpose::Start(_) => continue,
            };
            let (beyond, barriers) = area.barriers_beyond(frame, grid, cell_meters);
            drawn.push(Drawn { kind: area.purpose.word(), name: area.name, cells, beyond, barriers });
        }
        drawn
    }
}
