//! A rectangle of bits with fast access to runs within a row.

/// Bits by row and column, each row a whole number of words.
#[derive(Clone, Debug, Default)]
pub(super) struct Bits {
    words_per_row: usize,
    words: Vec<u64>,
}

impl Bits {
    pub(super) fn new(rows: usize, columns: usize) -> Self {
        // One more, so that a run that ends in the last word can read the next.
        let words_per_row = columns / 64 + 2;
        Self { words_per_row, words: vec![0; rows * words_per_row] }
    }

    pub(super) fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.words_per_row..][..self.words_per_row]
    }

    pub(super) fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.words_per_row..][..self.words_per_row]
    }

    #[inline]
    pub(super) fn get(&self, row: usize, column: usize) -> bool {
        self.words[row * self.words_per_row + column / 64] >> (column % 64) & 1 == 1
    }

    pub(super) fn set(&mut self, row: usize, column: usize) {
        self.words[row * self.words_per_row + column / 64] |= 1 << (column % 64);
    }

    /// Sets a bit of the first row; returns whether it was set.
    #[inline]
    pub(super) fn replace(&mut self, column: usize) -> bool {
        let bit = 1 << (column % 64);
        let word = &mut self.words[column / 64];
        std::mem::replace(word, *word | bit) & bit != 0
    }

    /// Whether a bit of `mask` is set from `column` on.
    #[inline]
    pub(super) fn any(&self, row: usize, column: usize, mask: u64) -> bool {
        let word = row * self.words_per_row + column / 64;
        let shift = column % 64;
        let bits = self.words[word] >> shift | self.words[word + 1] << 1 << (63 - shift);
        bits & mask != 0
    }

    pub(super) fn bytes(&self) -> usize {
        self.words.len() * 8
    }
}

/// `out[i] |= row[i + by]` for each bit; bits beyond the row's ends are zero.
pub(super) fn or_shifted(out: &mut [u64], row: &[u64], by: isize) {
    let (words, bits) = (by.unsigned_abs() / 64, by.unsigned_abs() % 64);
    let count = row.len();
    if by >= 0 {
        for index in 0..count.saturating_sub(words) {
            let low = row[index + words] >> bits;
            let high = row.get(index + words + 1).map_or(0, |&next| next << 1 << (63 - bits));
            out[index] |= low | high;
        }
    } else {
        for index in words..count {
            let high = row[index - words] << bits;
            let low = if index > words { row[index - words - 1] >> 1 >> (63 - bits) } else { 0 };
            out[index] |= low | high;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_shifts_cross_words() {
        let mut bits = Bits::new(2, 130);
        for column in [0, 63, 64, 129] {
            bits.set(1, column);
        }
        for column in 0..130 {
            for length in 1..=40 {
                let mask = u64::MAX >> (64 - length);
                let expected = [0, 63, 64, 129].iter().any(|set| (column..column + length).contains(set));
                assert_eq!(bits.any(1, column, mask), expected, "{column} {length}");
            }
        }
        for by in [-129_isize, -65, -64, -1, 0, 1, 63, 64, 65, 129] {
            let mut shifted = Bits::new(1, 130);
            or_shifted(shifted.row_mut(0), bits.row(1), by);
            for column in 0_isize..130 {
                let expected = [0, 63, 64, 129].contains(&(column + by));
                assert_eq!(shifted.get(0, column.unsigned_abs()), expected, "{column} {by}");
            }
        }
    }
}
