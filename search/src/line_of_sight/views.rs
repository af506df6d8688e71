//! What a sensor sees from the cells from which walls hide something, as bits.
//!
//! A view is a row of bits, one for each place of the square around a cell. Ascending places are in the order of the footprint,
//! so that sums over a view are the same bits as those over the footprint without what is hidden. What comes into view by a
//! move is a shift and a conjunction of words.

use std::borrow::Cow;
use std::ops::Range;

use super::{BITS, Hidden, Shadows, bit};
use crate::cell::{Cell, Grid, Offset};
use crate::sensor::{FootprintCell, Sensor};
use crate::situation::Situation;

/// The views of one sensor.
pub(crate) struct Views<'a> {
    hidden: Cow<'a, Hidden>,
    /// What is seen where nothing is hidden.
    footprint: Vec<u64>,
    /// Its words that are not 0.
    words: Range<usize>,
}

impl<'a> Views<'a> {
    /// Those of the situation's sensor, if anything is hidden from any cell.
    pub(crate) fn of(situation: &Situation<'a>) -> Option<Self> {
        let Situation { terrain, sensor, .. } = situation;
        let hidden = terrain.line_of_sight().0.as_deref()?;
        let is_wide = sensor.radius().cast_signed() <= hidden.radius;
        let widened = || hidden.widened(terrain.grid(), sensor.radius());
        let hidden = if is_wide { Cow::Borrowed(hidden) } else { Cow::Owned(widened()) };
        let mut footprint = vec![0; hidden.words];
        for place in sensor.footprint() {
            let place = bit(hidden.radius, place.offset);
            footprint[place / BITS] |= 1 << (place % BITS);
        }
        let is_used = |word: &u64| *word != 0;
        let start = footprint.iter().position(is_used).unwrap_or(0);
        let end = footprint.iter().rposition(is_used).map_or(0, |last| last + 1);
        Some(Self { hidden, footprint, words: start..end })
    }

    /// A value for each place of the footprint, by place.
    pub(crate) fn by_place<T: Clone + Default>(
        &self,
        sensor: &Sensor,
        value: impl Fn(&FootprintCell) -> T,
    ) -> Vec<T> {
        let mut values = vec![T::default(); self.hidden.words * BITS];
        for seen in sensor.footprint() {
            values[self.place(seen.offset)] = value(seen);
        }
        values
    }

    /// The place of an offset of the footprint.
    pub(crate) fn place(&self, offset: Offset) -> usize {
        bit(self.hidden.radius, offset)
    }

    /// Whether something is hidden from a cell.
    #[inline]
    pub(crate) fn is_limited(&self, from: Cell) -> bool {
        self.hidden.row[from.index()] != super::NONE
    }

    /// The cells from which something is hidden, by index, with what.
    pub(crate) fn limited(&self, grid: Grid) -> impl Iterator<Item = (Cell, Shadows<'_>)> {
        grid.cells().filter_map(|from| Some((from, self.hidden.shadows(from)?)))
    }

    /// The places that are seen from a cell, if something is hidden from it.
    #[inline]
    pub(crate) fn seen(&self, from: Cell) -> Option<impl Iterator<Item = usize>> {
        let Shadows { bits, .. } = self.hidden.shadows(from)?;
        Some(places(self.words.clone().map(move |word| (word, self.footprint[word] & !bits[word]))))
    }

    /// The places that are seen from a cell and were not seen from its neighbor before the move to it. The move is a straight one.
    pub(crate) fn coming_into_view(
        &self,
        before: Cell,
        entered: Offset,
        from: Cell,
    ) -> impl Iterator<Item = usize> {
        let view = |from| {
            let shadows = self.hidden.shadows(from);
            move |word: usize| {
                if !self.words.contains(&word) {
                    return 0;
                }
                self.footprint[word] & !shadows.map_or(0, |Shadows { bits, .. }| bits[word])
            }
        };
        let (was, is) = (view(before), view(from));
        // What is beside the square's east edge is the west edge of the next row, of which a footprint has no place.
        let shift = self.place(entered).wrapping_sub(self.place(Offset { north: 0, east: 0 }));
        places(self.words.clone().map(move |word| {
            let first = (word * BITS).wrapping_add(shift).cast_signed();
            let bits = BITS.cast_signed();
            let (at, back) = (first.div_euclid(bits), first.rem_euclid(bits));
            let low = was(at.cast_unsigned()) >> back;
            let high = if back == 0 { 0 } else { was((at + 1).cast_unsigned()) << (bits - back) };
            (word, is(word) & !(low | high))
        }))
    }
}

/// The places of the bits of some words, ascending.
#[inline]
fn places(words: impl Iterator<Item = (usize, u64)>) -> impl Iterator<Item = usize> {
    words.flat_map(|(word, mut bits)| {
        std::iter::from_fn(move || {
            let place = (bits != 0).then(|| word * BITS + bits.trailing_zeros() as usize);
            bits &= bits.wrapping_sub(1);
            place
        })
    })
}

impl Shadows<'_> {
    /// Whether a place is hidden.
    #[inline]
    pub(crate) fn hide_place(self, place: usize) -> bool {
        self.bits[place / BITS] >> (place % BITS) & 1 == 1
    }
}

impl Hidden {
    /// The same in rows of a larger radius, cells.
    fn widened(&self, grid: Grid, radius: u32) -> Self {
        let mut widened = Self::nothing(grid, radius);
        for from in grid.cells() {
            let Some(shadows) = self.shadows(from) else { continue };
            for offset in Offset::within(self.radius.unsigned_abs()).filter(|&offset| shadows.hide(offset)) {
                widened.hide(from, offset);
            }
        }
        widened
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::belief::Belief;
    use crate::intent::PlannedPrecision;
    use crate::sensor::Noise;
    use crate::terrain::{Ground, Terrain};

    proptest! {
        #[test]
        fn a_view_is_the_footprint_without_what_is_hidden_in_its_order(
            rows in 1_u32..12, columns in 1_u32..12, radius in 1_u32..9, known in 1_u32..9,
            walls in prop::collection::vec(prop::bool::weighted(0.2), 144),
        ) {
            let grid = Grid::new(rows, columns).unwrap();
            let ground = walls.iter().take(grid.cell_count());
            let ground = ground.map(|&is_wall| if is_wall { Ground::BLOCKED } else { Ground::OPEN });
            let terrain = Terrain::new(grid, 1.0, ground.collect()).unwrap().with_opaque_walls(known);
            let sensor = Sensor::new(radius, 0.005, Noise::Gaussian).unwrap();
            let belief = Belief::uniform(&terrain, 0.1).unwrap();
            let planned_precision = PlannedPrecision::nothing(&terrain);
            let robot = grid.cells().next().unwrap();
            let situation = Situation::alone(&terrain, &sensor, &belief, &planned_precision, robot);
            let Some(views) = Views::of(&situation) else { return Ok(()) };

            let offsets = views.by_place(&sensor, |seen| (seen.offset.north, seen.offset.east));
            let shown = |places: Vec<usize>| places.into_iter().map(|place| offsets[place]).collect::<Vec<_>>();
            let visible = |from: Cell| {
                let hidden = terrain.line_of_sight();
                let seen = sensor.footprint().iter().filter(move |place| !hidden.hides(from, place.offset));
                seen.map(|place| (place.offset.north, place.offset.east)).collect::<Vec<_>>()
            };
            for from in grid.cells() {
                prop_assert_eq!(views.is_limited(from), terrain.line_of_sight().shadows(from).is_some());
                if let Some(seen) = views.seen(from) {
                    prop_assert_eq!(shown(seen.collect()), visible(from));
                }
                for entered in [(0, 1), (1, 0), (0, -1), (-1, 0)] {
                    let back = Offset { north: -entered.0, east: -entered.1 };
                    let Some(before) = grid.step(from, back) else { continue };
                    let was: BTreeSet<_> =
                        visible(before).into_iter().map(|(north, east)| (north - entered.0, east - entered.1)).collect();
                    let new: Vec<_> = visible(from).into_iter().filter(|offset| !was.contains(offset)).collect();
                    let entered = Offset { north: entered.0, east: entered.1 };
                    prop_assert_eq!(shown(views.coming_into_view(before, entered, from).collect()), new);
                }
            }
        }
    }
}
