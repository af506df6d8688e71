//! The states of a search: memory is allocated only where it has been.

use dragnet_search::cell::Position;

/// Edge of a tile, in cells, as a power of two.
const EDGE_BITS: u32 = 3;
const NO_TILE: u32 = u32::MAX;

/// One state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    /// Cost from the start, in units; `u32::MAX` without a path.
    pub(super) cost: u32,
    /// The last primitive of that path.
    pub(super) primitive: u16,
    /// The search in which it was last expanded; 0 for none.
    pub(super) closed: u8,
}

const FRESH: Record = Record { cost: u32::MAX, primitive: 0, closed: 0 };

/// States in tiles of 8 x 8 cells with all their headings, in order of first visit. A state's name consists of its
/// tile, its cell in the tile and its heading as bits.
#[derive(Clone, Debug, Default)]
pub(super) struct States {
    heading_bits: u32,
    tiles_per_row: usize,
    /// The number of each tile of the map, or [`NO_TILE`].
    table: Vec<u32>,
    tiles: Vec<Box<[Record]>>,
    /// South-western corner of each tile.
    corners: Vec<Position>,
}

impl States {
    /// Forgets all states; keeps their memory if the lattice has the same shape.
    pub(super) fn reset(&mut self, rows: usize, columns: usize, heading_count: usize) {
        let heading_bits = heading_count.next_power_of_two().ilog2();
        if heading_bits != self.heading_bits {
            self.tiles.clear();
        }
        self.heading_bits = heading_bits;
        self.tiles_per_row = columns.div_ceil(1 << EDGE_BITS);
        self.table.clear();
        self.table.resize(rows.div_ceil(1 << EDGE_BITS) * self.tiles_per_row, NO_TILE);
        self.corners.clear();
    }

    const fn tile_bits(&self) -> u32 {
        2 * EDGE_BITS + self.heading_bits
    }

    #[inline]
    const fn entry(&self, at: Position) -> usize {
        (at.row >> EDGE_BITS) as usize * self.tiles_per_row + (at.column >> EDGE_BITS) as usize
    }

    #[inline]
    const fn name(&self, tile: u32, at: Position, heading: u8) -> u32 {
        const MASK: u32 = (1 << EDGE_BITS) - 1;
        let cell = (at.row & MASK) << EDGE_BITS | at.column & MASK;
        tile << self.tile_bits() | cell << self.heading_bits | heading as u32
    }

    /// Cost from the start of a state, without allocating it.
    #[inline]
    pub(super) fn cost_at(&self, at: Position, heading: u8) -> u32 {
        match self.table[self.entry(at)] {
            NO_TILE => u32::MAX,
            tile => self.record(self.name(tile, at, heading)).cost,
        }
    }

    /// The name of an allocated state.
    pub(super) fn name_at(&self, at: Position, heading: u8) -> u32 {
        self.name(self.table[self.entry(at)], at, heading)
    }

    /// The name of a state on the map.
    #[inline]
    pub(super) fn make(&mut self, at: Position, heading: u8) -> u32 {
        let entry = self.entry(at);
        if self.table[entry] == NO_TILE {
            self.table[entry] = self.add_tile(at);
        }
        self.name(self.table[entry], at, heading)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a map has fewer tiles than cells")]
    fn add_tile(&mut self, at: Position) -> u32 {
        let number = self.corners.len();
        let clear = !((1 << EDGE_BITS) - 1);
        self.corners.push(Position { row: at.row & clear, column: at.column & clear });
        match self.tiles.get_mut(number) {
            Some(tile) => tile.fill(FRESH),
            None => self.tiles.push(vec![FRESH; 1 << self.tile_bits()].into_boxed_slice()),
        }
        number as u32
    }

    /// Cell and heading of a state.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "headings fit 8 bits")]
    pub(super) fn place(&self, state: u32) -> (Position, u8) {
        const MASK: u32 = (1 << EDGE_BITS) - 1;
        let corner = self.corners[(state >> self.tile_bits()) as usize];
        let cell = state >> self.heading_bits;
        let at =
            Position { row: corner.row + (cell >> EDGE_BITS & MASK), column: corner.column + (cell & MASK) };
        (at, (state & ((1 << self.heading_bits) - 1)) as u8)
    }

    #[inline]
    pub(super) fn record(&self, state: u32) -> &Record {
        let bits = self.tile_bits();
        &self.tiles[(state >> bits) as usize][(state & ((1 << bits) - 1)) as usize]
    }

    #[inline]
    pub(super) fn record_mut(&mut self, state: u32) -> &mut Record {
        let bits = self.tile_bits();
        &mut self.tiles[(state >> bits) as usize][(state & ((1 << bits) - 1)) as usize]
    }

    pub(super) fn bytes(&self) -> usize {
        self.table.len() * 4 + (self.tiles.len() << self.tile_bits()) * size_of::<Record>()
    }
}
