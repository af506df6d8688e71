//! The newest entry for each key, gossiped by all participants.
//!
//! Merging is commutative and idempotent: of two entries for one key the newer one counts, in any order of arrival. An
//! entry is never removed, only replaced.

use std::collections::BTreeMap;

use dragnet_scenario::time::MissionTime;

use crate::directive::MOST_AHEAD;

/// An entry with its number. The order of its fields is the order in which entries count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Numbered<V> {
    /// When it was made: nanoseconds of mission time, or one more than the number before if the coordinator's clock is
    /// behind.
    pub number: u64,
    /// The entry.
    pub value: V,
}

/// The newest entries that a participant knows, by key. The default contains none.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Newest<K, V>(BTreeMap<K, Numbered<V>>);

impl<K, V> Default for Newest<K, V> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Copy + Ord, V: Clone + Ord> Newest<K, V> {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All entries, by key.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (K, Numbered<V>)> + '_ {
        self.0.iter().map(|(&key, entry)| (key, entry.clone()))
    }

    /// The entry for a key, if there is one.
    #[must_use]
    pub fn of(&self, key: K) -> Option<V> {
        self.numbered(key).map(|entry| entry.value)
    }

    /// The same with its number.
    #[must_use]
    pub fn numbered(&self, key: K) -> Option<Numbered<V>> {
        self.0.get(&key).cloned()
    }

    /// Whether this entry, or a newer one for its key, is known.
    #[must_use]
    pub fn includes(&self, key: K, entry: &Numbered<V>) -> bool {
        self.0.get(&key).is_some_and(|known| known >= entry)
    }

    /// Whether each of these entries, or a newer one for its key, is known.
    #[must_use]
    pub fn includes_all(&self, other: &Self) -> bool {
        other.0.iter().all(|(&key, entry)| self.includes(key, entry))
    }

    /// Makes an entry for a key, as of a time in nanoseconds: it is newer than any other for this key.
    pub fn give(&mut self, time_ns: u64, key: K, value: V) {
        let known = self.0.get(&key).map_or(0, |known| known.number.saturating_add(1));
        self.0.insert(key, Numbered { number: time_ns.max(known), value });
    }

    /// Merges the entries that another participant knows; returns whether any is news. One dated too far ahead of its
    /// reception counts as dated earlier, as in [`crate::directive::Directive::merge`].
    pub fn merge(&mut self, now: MissionTime, other: &Self) -> bool {
        !self.merge_news(now, other).is_empty()
    }

    /// The same; returns what is news, each with the entry that it replaces.
    pub fn merge_news(&mut self, now: MissionTime, other: &Self) -> Vec<(Option<V>, V)> {
        let most = (now + MOST_AHEAD).0;
        let mut news = Vec::new();
        for (key, mut entry) in other.iter() {
            entry.number = entry.number.min(most);
            if !self.includes(key, &entry) {
                let value = entry.value.clone();
                news.push((self.0.insert(key, entry).map(|before| before.value), value));
            }
        }
        news
    }
}

impl<K: Ord, V> FromIterator<(K, Numbered<V>)> for Newest<K, V> {
    fn from_iter<I: IntoIterator<Item = (K, Numbered<V>)>>(entries: I) -> Self {
        Self(entries.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn newest(entries: impl IntoIterator<Item = (u8, u64, char)>) -> Newest<u8, char> {
        entries.into_iter().map(|(key, number, value)| (key, Numbered { number, value })).collect()
    }

    #[test]
    fn any_order_of_arrival_gives_the_same_entries() {
        let reported =
            [newest([(1, 5, 'b'), (2, 3, 'z')]), newest([(1, 5, 'a'), (3, 1, 'c')]), newest([(2, 4, 'a')])];
        let expected = newest([(1, 5, 'b'), (2, 4, 'a'), (3, 1, 'c')]);
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut known = Newest::default();
            for index in order {
                known.merge(MissionTime::START, &reported[index]);
            }
            assert_eq!(known, expected, "{order:?}");
            assert!(reported.iter().all(|old| !known.merge(MissionTime(9), old)), "nothing is news twice");
        }
    }

    #[test]
    fn an_entry_is_newer_than_what_is_known_whatever_the_clock_says() {
        let mut known = newest([(1, u64::MAX, 'a')]);
        let mut other = Newest::default();
        assert!(other.merge(MissionTime(3), &known), "it counts as dated earlier");
        other.give(7, 1, 'b');
        assert_eq!(other.of(1), Some('b'));
        known.give(7, 2, 'c');
        known.give(6, 2, 'd');
        assert_eq!((known.of(2), known.of(3)), (Some('d'), None));
    }
}
