//! The process that a message comes from, in addition to its participant: two processes may be configured with one
//! number.

/// The attachment of each message: two numbers of 64 bits, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    /// Sequence number of the message in its process.
    pub number: u64,
    /// Its process: see [`Claim::identity`].
    pub identity: u64,
}

/// What a process claims in its liveliness token. Of several processes of one robot the one with the greatest claim
/// goes on, and the others stop: no two claims are equal, and everybody who sees the tokens sees the same order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Claim {
    /// 0 when it starts; it rises while the process goes on, and never falls.
    pub seniority: u8,
    /// Drawn at random when the process starts.
    pub identity: u64,
}

impl Claim {
    /// The seniority of a process that is to take over from all others of its number.
    pub const TAKES_OVER: u8 = u8::MAX;
}

impl Envelope {
    /// Encodes the envelope.
    #[must_use]
    pub fn encode(self) -> Vec<u8> {
        [self.number, self.identity].iter().flat_map(|it| it.to_le_bytes()).collect()
    }

    /// Decodes an envelope; `None` if the bytes are invalid.
    #[must_use]
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (numbers, []) = bytes.as_chunks::<8>() else { return None };
        let &[number, identity] = numbers else { return None };
        let [number, identity] = [number, identity].map(u64::from_le_bytes);
        Some(Self { number, identity })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_is_read_as_it_was_written_and_nothing_else_is_one() {
        let envelope = Envelope { number: u64::MAX, identity: 258 };
        let bytes = envelope.encode();
        assert_eq!(Envelope::decode(&bytes), Some(envelope));
        assert_eq!(bytes[8..], [2, 1, 0, 0, 0, 0, 0, 0]);
        for length in [0, 8, 15] {
            assert_eq!(Envelope::decode(&bytes[..length]), None);
        }
        assert_eq!(Envelope::decode(&[bytes.as_slice(), &[0; 8]].concat()), None);
    }

    #[test]
    fn claims_are_ordered_by_seniority_before_identity() {
        let claim = |seniority, identity| Claim { seniority, identity };
        assert!(claim(1, 3) > claim(0, 7) && claim(1, 7) > claim(1, 3));
        assert!(claim(Claim::TAKES_OVER, 0) > claim(Claim::TAKES_OVER - 1, u64::MAX));
    }
}
