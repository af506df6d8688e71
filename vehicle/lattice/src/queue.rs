//! OPEN: the queue of states to be expanded, the smallest key first.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A state with its cost when it was queued. If its cost has changed, the entry is outdated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) key: u64,
    pub(super) cost: u32,
    pub(super) state: u32,
}

impl Ord for Entry {
    /// The greatest entry comes first: small keys, of equal keys the one farther from the start, then the older state.
    fn cmp(&self, other: &Self) -> Ordering {
        (other.key, self.cost, other.state).cmp(&(self.key, other.cost, self.state))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Buckets of keys, of which only the lowest is kept as a heap: most entries are never sorted.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    shift: u32,
    buckets: Vec<Vec<Entry>>,
    /// The bucket whose entries are in the heap.
    current: usize,
    heap: BinaryHeap<Entry>,
}

const BUCKETS: usize = 1 << 13;

impl Queue {
    pub(super) fn new() -> Self {
        Self { shift: 0, buckets: vec![Vec::new(); BUCKETS], current: 0, heap: BinaryHeap::new() }
    }

    /// Clears the queue, for keys up to about this size: larger ones work too, only slower.
    pub(super) fn reset(&mut self, largest_key: u64) {
        self.shift = (largest_key / BUCKETS as u64 + 1).ilog2() + 1;
        self.heap.clear();
        self.buckets.iter_mut().for_each(Vec::clear);
        self.current = 0;
    }

    fn bucket(&self, key: u64) -> usize {
        usize::try_from(key >> self.shift).unwrap_or(usize::MAX).min(BUCKETS - 1)
    }

    #[inline]
    pub(super) fn push(&mut self, entry: Entry) {
        let bucket = self.bucket(entry.key);
        if bucket > self.current {
            self.buckets[bucket].push(entry);
            return;
        }
        if bucket < self.current {
            // Keys may decrease: the heap goes back to its bucket.
            let mut entries = std::mem::take(&mut self.heap).into_vec();
            std::mem::swap(&mut entries, &mut self.buckets[self.current]);
            self.heap = entries.into();
            let lower = std::mem::take(&mut self.buckets[bucket]);
            self.heap.extend(lower);
            self.current = bucket;
        }
        self.heap.push(entry);
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<Entry> {
        if self.heap.is_empty() {
            let next = (self.current + 1..BUCKETS).find(|&bucket| !self.buckets[bucket].is_empty())?;
            self.current = next;
            let entries = std::mem::take(&mut self.buckets[next]);
            let emptied = std::mem::replace(&mut self.heap, entries.into()).into_vec();
            self.buckets[next] = emptied;
        }
        self.heap.pop()
    }

    /// All entries, in no order.
    pub(super) fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.heap.iter().chain(self.buckets.iter().flatten())
    }

    pub(super) fn bytes(&self) -> usize {
        let entries = self.heap.capacity() + self.buckets.iter().map(Vec::capacity).sum::<usize>();
        entries * size_of::<Entry>()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_smallest_key_comes_first(
            largest in 0_u64..100_000,
            moves in prop::collection::vec(prop::option::weighted(0.6, 0_u64..100_000), 1..200),
        ) {
            let mut queue = Queue::new();
            queue.reset(largest);
            let mut heap = BinaryHeap::new();
            for (state, key) in (0..).zip(moves) {
                if let Some(key) = key {
                    let entry = Entry { key, cost: state % 3, state };
                    queue.push(entry);
                    heap.push(entry);
                } else {
                    prop_assert_eq!(queue.pop(), heap.pop());
                }
                prop_assert_eq!(queue.entries().count(), heap.len());
            }
        }
    }
}
