//! A bucket queue for Dijkstra with whole numbers, without a heap.

/// A cell, and the step by which its path enters it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    pub(super) cell: u32,
    pub(super) entered: u8,
}

/// Cells by their distance, in buckets no wider than the shortest edge: within a bucket no cell can shorten the path to
/// another, so that any order among them is right (Dinitz 1978). The buckets form a ring longer than the longest edge.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    shift: u32,
    buckets: Vec<Vec<Waiting>>,
    current: usize,
    waiting: usize,
}

impl Ring {
    /// Prepares the queue for edges of these lengths, above 0.
    pub(super) fn reset(&mut self, shortest: u32, longest: u32) {
        self.shift = shortest.max(1).ilog2();
        let count = ((longest >> self.shift) as usize + 2).next_power_of_two();
        self.buckets.iter_mut().for_each(Vec::clear);
        self.buckets.resize(count, Vec::new());
        self.current = 0;
        self.waiting = 0;
    }

    #[inline]
    pub(super) fn push(&mut self, distance: u32, cell: Waiting) {
        let count = self.buckets.len();
        self.buckets[(distance >> self.shift) as usize & (count - 1)].push(cell);
        self.waiting += 1;
    }

    /// The next cell. A cell that was pushed repeatedly comes repeatedly, first with its smallest distance.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<Waiting> {
        if self.waiting == 0 {
            return None;
        }
        let count = self.buckets.len();
        loop {
            if let Some(cell) = self.buckets[self.current & (count - 1)].pop() {
                self.waiting -= 1;
                return Some(cell);
            }
            self.current += 1;
        }
    }

    /// A lower bound on the distance of all queued cells.
    #[inline]
    pub(super) fn least(&self) -> u32 {
        u32::try_from(self.current << self.shift).unwrap_or(u32::MAX)
    }
}
