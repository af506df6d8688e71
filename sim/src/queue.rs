//! Future events, ordered by time; events of one time are ordered by insertion.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use dragnet_scenario::time::MissionTime;

/// A queue of events.
#[derive(Debug)]
pub(crate) struct Queue<E> {
    entries: BinaryHeap<Reverse<Entry<E>>>,
    planned: u64,
    /// Number of the event that was taken out last.
    taken: u64,
}

#[derive(Debug)]
struct Entry<E> {
    due: MissionTime,
    number: u64,
    event: E,
}

impl<E> Queue<E> {
    pub(crate) const fn new() -> Self {
        Self { entries: BinaryHeap::new(), planned: 0, taken: 0 }
    }

    pub(crate) fn plan(&mut self, due: MissionTime, event: E) {
        self.entries.push(Reverse(Entry { due, number: self.planned, event }));
        self.planned += 1;
    }

    /// The time of the next event.
    pub(crate) fn due(&self) -> Option<MissionTime> {
        self.entries.peek().map(|Reverse(entry)| entry.due)
    }

    pub(crate) fn next(&mut self) -> Option<(MissionTime, E)> {
        let Reverse(entry) = self.entries.pop()?;
        self.taken = entry.number;
        Some((entry.due, entry.event))
    }

    /// The next event, if it is due at this time and of a kind.
    pub(crate) fn next_if(&mut self, due: MissionTime, is_of_kind: impl Fn(&E) -> bool) -> Option<E> {
        let Reverse(entry) = self.entries.peek()?;
        if entry.due != due || !is_of_kind(&entry.event) {
            return None;
        }
        self.next().map(|(_, event)| event)
    }

    /// Puts back the rest of the event that was taken out last, before all events that were planned after it.
    pub(crate) fn put_back(&mut self, due: MissionTime, event: E) {
        self.entries.push(Reverse(Entry { due, number: self.taken, event }));
    }
}

impl<E> PartialEq for Entry<E> {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

impl<E> Eq for Entry<E> {}

impl<E> PartialOrd for Entry<E> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<E> Ord for Entry<E> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.due, self.number).cmp(&(other.due, other.number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_by_time_and_then_in_the_order_of_planning() {
        let mut queue = Queue::new();
        for (due, event) in [(5, 'c'), (1, 'a'), (5, 'd'), (1, 'b')] {
            queue.plan(MissionTime(due), event);
        }
        let order: String = std::iter::from_fn(|| queue.next()).map(|(_, event)| event).collect();
        assert_eq!(order, "abcd");
    }

    #[test]
    fn what_is_put_back_comes_before_what_was_planned_meanwhile() {
        let mut queue = Queue::new();
        for event in ["first", "second"] {
            queue.plan(MissionTime(1), event);
        }
        assert_eq!(queue.next(), Some((MissionTime(1), "first")));
        queue.plan(MissionTime(1), "third");
        queue.put_back(MissionTime(1), "rest of the first");
        let order: Vec<&str> = std::iter::from_fn(|| queue.next()).map(|(_, event)| event).collect();
        assert_eq!(order, ["rest of the first", "second", "third"]);
    }
}
