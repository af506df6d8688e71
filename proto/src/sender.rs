//! The process that a message comes from, in addition to its participant: two processes may be configured with one
//! number.

/// The attachment of each message: three numbers of 64 bits, little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Envelope {
    /// Sequence number of the message in its process.
    pub number: u64,
    /// The sender.
    pub process: Process,
}

/// One process of a participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Process {
    /// Random identifier, drawn when the process starts.
    pub identity: u64,
    /// How long it has run, milliseconds; `u64::MAX` if it is to take over from all others of its number.
    pub age_ms: u64,
}

impl Envelope {
    /// Encodes the envelope.
    #[must_use]
    pub fn encode(self) -> Vec<u8> {
        [self.number, self.process.identity, self.process.age_ms]
            .iter()
            .flat_map(|it| it.to_le_bytes())
            .collect()
    }

    /// Decodes an envelope; `None` if the bytes are invalid.
    #[must_use]
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (numbers, []) = bytes.as_chunks::<8>() else { return None };
        let &[number, identity, age_ms] = numbers else { return None };
        let [number, identity, age_ms] = [number, identity, age_ms].map(u64::from_le_bytes);
        Some(Self { number, process: Process { identity, age_ms } })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_is_read_as_it_was_written_and_nothing_else_is_one() {
        let envelope = Envelope { number: 1, process: Process { identity: u64::MAX, age_ms: 258 } };
        let bytes = envelope.encode();
        assert_eq!(Envelope::decode(&bytes), Some(envelope));
        assert_eq!(bytes[16..], [2, 1, 0, 0, 0, 0, 0, 0]);
        for length in [0, 8, 16, 23] {
            assert_eq!(Envelope::decode(&bytes[..length]), None);
        }
        assert_eq!(Envelope::decode(&[bytes.as_slice(), &[0; 8]].concat()), None);
    }
}
