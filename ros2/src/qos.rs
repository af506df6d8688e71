//! Quality of service: the settings that Dragnet uses.

use std::fmt;

/// The quality of service of a publisher or subscriber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Whether lost messages are sent again.
    pub reliability: Reliability,
    /// Whether late subscribers receive the last messages.
    pub durability: Durability,
    /// Number of messages that are kept, the last ones; at least 1.
    pub depth: usize,
}

/// Whether lost messages are sent again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reliability {
    /// Lost messages are sent again.
    Reliable,
    /// Lost messages are not sent again: the next one replaces them.
    BestEffort,
}

/// Whether late subscribers receive the last messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// Late subscribers receive new messages only.
    Volatile,
    /// Late subscribers receive the last messages, as long as the publisher exists.
    TransientLocal,
}

impl Qos {
    /// ROS's `default`: every message counts.
    pub const RELIABLE: Self =
        Self { reliability: Reliability::Reliable, durability: Durability::Volatile, depth: 10 };
    /// ROS's `sensor data`.
    pub const SENSOR: Self =
        Self { reliability: Reliability::BestEffort, durability: Durability::Volatile, depth: 5 };
    /// `tf2`'s for `/tf`: every transform counts, of several publishers.
    pub const TRANSFORMS: Self =
        Self { reliability: Reliability::Reliable, durability: Durability::Volatile, depth: 100 };
    /// `tf2`'s for `/tf_static`: each publisher keeps its last message for late subscribers.
    pub const STATIC_TRANSFORMS: Self = Self { durability: Durability::TransientLocal, ..Self::TRANSFORMS };
    /// ROS's latched topics: values that hold until they are replaced.
    pub const LATCHED: Self =
        Self { reliability: Reliability::Reliable, durability: Durability::TransientLocal, depth: 1 };
}

impl fmt::Display for Qos {
    /// As in tokens of `rmw_zenoh`: reliability, durability, history and depth, deadline, lifespan, liveliness;
    /// defaults are left empty.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reliability = match self.reliability {
            Reliability::Reliable => "",
            Reliability::BestEffort => "2",
        };
        let durability = match self.durability {
            Durability::Volatile => "",
            Durability::TransientLocal => "1",
        };
        write!(formatter, "{reliability}:{durability}:,{}:,:,:,,", self.depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quality_of_service_is_written_as_in_tokens() {
        assert_eq!(Qos::RELIABLE.to_string(), "::,10:,:,:,,");
        assert_eq!(Qos::SENSOR.to_string(), "2::,5:,:,:,,");
        assert_eq!(Qos::TRANSFORMS.to_string(), "::,100:,:,:,,");
        assert_eq!(Qos::STATIC_TRANSFORMS.to_string(), ":1:,100:,:,:,,");
        assert_eq!(Qos::LATCHED.to_string(), ":1:,1:,:,:,,");
    }
}
