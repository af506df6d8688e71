//! One named random stream for each purpose and robot, so that an additional draw from one stream changes no other.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// A random stream that is the same on every machine.
pub type Stream = ChaCha8Rng;

/// The purpose of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Positions of objects.
    Truth,
    /// Start cells of robots.
    Start,
    /// Noise of a robot's readings.
    Noise,
    /// A robot's random choices.
    Decision,
    /// Faults of the network.
    Network,
    /// Training on demonstrations.
    Training,
    /// Generated maps.
    Map,
    /// Faults injected by `soak`.
    Soak,
    /// Bootstrap samples of results.
    Bootstrap,
    /// The search for a bound.
    Bound,
}

/// The stream of a purpose and robot (0 if none) under an episode's seed.
#[must_use]
pub fn stream(seed: u64, purpose: Purpose, robot: u16) -> Stream {
    let name = match purpose {
        Purpose::Truth => "truth",
        Purpose::Start => "start",
        Purpose::Noise => "noise",
        Purpose::Decision => "decision",
        Purpose::Network => "network",
        Purpose::Training => "training",
        Purpose::Map => "map",
        Purpose::Soak => "soak",
        Purpose::Bootstrap => "bootstrap",
        Purpose::Bound => "bound",
    };
    let mut key = [0; 32];
    for (part, bytes) in (0_u16..).zip(key.chunks_exact_mut(8)) {
        let label = [name.as_bytes(), &robot.to_le_bytes(), &part.to_le_bytes()].concat();
        bytes.copy_from_slice(&xxh3_64_with_seed(&label, seed).to_le_bytes());
    }
    Stream::from_seed(key)
}

#[cfg(test)]
mod tests {
    use rand_chacha::rand_core::Rng;

    use super::*;

    #[test]
    fn each_seed_purpose_and_robot_has_its_own_stream() {
        let first = |seed, purpose, robot| stream(seed, purpose, robot).next_u64();
        let mut draws = vec![
            first(1, Purpose::Truth, 0),
            first(2, Purpose::Truth, 0),
            first(1, Purpose::Noise, 0),
            first(1, Purpose::Noise, 1),
        ];
        assert_eq!(draws[0], first(1, Purpose::Truth, 0));
        draws.sort_unstable();
        draws.dedup();
        assert_eq!(draws.len(), 4);
    }
}
