//! Messages as damaged by radios, memory errors and attackers.

use dragnet_proto::dragnet_msgs::VERSION;
use dragnet_proto::message::MessageKind;
use dragnet_search::seed::Stream;
use rand::RngExt;
use rand::seq::IndexedRandom;

use crate::world::Said;

/// Header, and the version that a message begins with.
pub(crate) const BEGINNING: [u8; 5] = [0, 1, 0, 0, VERSION];

/// Extreme values of fields: lengths, numbers and floating-point numbers of 4 or 8 bytes.
const WORDS: [u64; 18] = [
    0,
    1,
    2,
    63,
    64,
    65,
    u64::MAX,
    u64::MAX - 1,
    1 << 63,
    0x7fff_ffff,
    0xffff_ffff,
    // Floating-point numbers of 4 bytes and of 8: 1, infinity, NaN, -0.
    0x3f80_0000,
    0x7f80_0000,
    0x7fc0_0000,
    0x3ff0_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    0x8000_0000,
];

/// A damaged message; `other` is an earlier one.
pub(crate) fn spoil(random: &mut Stream, said: &Said, other: &Said) -> (MessageKind, Vec<u8>) {
    if random.random_ratio(1, 16) {
        let kind = *MessageKind::ALL.choose(random).unwrap();
        return (kind, anything(random));
    }
    let mut bytes = said.bytes.clone();
    for _ in 0..*[1, 1, 1, 2, 3].choose(random).unwrap() {
        match random.random_range(0..20) {
            0..=8 => byte(random, &mut bytes),
            9..=15 => word(random, &mut bytes),
            16 => bytes.truncate(random.random_range(0..=bytes.len())),
            17 => insert(random, &mut bytes),
            18 => remove(random, &mut bytes),
            _ => splice(random, &mut bytes, &other.bytes),
        }
    }
    // A message of this kind under the key of another.
    let kind = if random.random_ratio(1, 32) { other.kind } else { said.kind };
    (kind, bytes)
}

fn anything(random: &mut Stream) -> Vec<u8> {
    let length = random.random_range(0..300);
    // Small numbers are valid lengths, robots and alternatives.
    let most = *[2, 5, 255].choose(random).unwrap();
    let body = (0..length).map(|_| random.random_range(0..=most));
    BEGINNING.into_iter().chain(body).collect()
}

fn byte(random: &mut Stream, bytes: &mut [u8]) {
    if bytes.is_empty() {
        return;
    }
    let place = random.random_range(0..bytes.len());
    bytes[place] = match random.random_range(0..3) {
        0 => random.random(),
        1 => bytes[place] ^ 1 << random.random_range(0..8),
        _ => bytes[place].wrapping_add(random.random_range(0..3)).wrapping_sub(1),
    };
}

/// Fields are aligned to their size, counted from the end of the header.
fn word(random: &mut Stream, bytes: &mut [u8]) {
    let word = WORDS.choose(random).unwrap().to_le_bytes();
    let size = *[2, 4, 8].choose(random).unwrap();
    let body = bytes.get_mut(4..).unwrap_or_default();
    if body.len() >= size {
        let place = random.random_range(0..body.len() / size) * size;
        body[place..place + size].copy_from_slice(&word[..size]);
    }
}

fn insert(random: &mut Stream, bytes: &mut Vec<u8>) {
    let place = random.random_range(0..=bytes.len());
    let length = *[1, 4, 8, 300].choose(random).unwrap();
    let fill = random.random();
    bytes.splice(place..place, vec![fill; length]);
}

fn remove(random: &mut Stream, bytes: &mut Vec<u8>) {
    let start = random.random_range(0..=bytes.len());
    let end = bytes.len().min(start + random.random_range(1..=16));
    bytes.drain(start..end);
}

/// The head of one and the tail of another.
fn splice(random: &mut Stream, bytes: &mut Vec<u8>, other: &[u8]) {
    let kept = random.random_range(0..=bytes.len());
    let from = if random.random() { kept.min(other.len()) } else { random.random_range(0..=other.len()) };
    bytes.truncate(kept);
    bytes.extend_from_slice(&other[from..]);
}
