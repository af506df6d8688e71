//! Qualities of service, as far as they are told apart here.

use std::fmt;

/// How a topic is published or heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Whether each message is to arrive.
    pub reliability: Reliability,
    /// Whether those who come late hear what was last said.
    pub durability: Durability,
    /// So many messages are kept, the last ones; at least 1.
    pub depth: usize,
}

/// Whether each message is to arrive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reliability {
    /// It is.
    Reliable,
    /// A lost one is not missed: the next one says more.
    BestEffort,
}

/// Whether those who come late hear what was last said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// They do not.
    Volatile,
    /// They do, as long as its publisher lives.
    TransientLocal,
}

impl Qos {
    /// What ROS calls `default`: all that matters message by message.
    pub const RELIABLE: Self =
        Self { reliability: Reliability::Reliable, durability: Durability::Volatile, depth: 10 };
    /// What ROS calls `sensor data`.
    pub const SENSOR: Self =
        Self { reliability: Reliability::BestEffort, durability: Durability::Volatile, depth: 5 };
    /// What ROS calls latched: what stands until it is replaced.
    pub const LATCHED: Self =
        Self { reliability: Reliability::Reliable, durability: Durability::TransientLocal, depth: 1 };
}

impl fmt::Display for Qos {
    /// As tokens of `rmw_zenoh` hold it: reliability, durability, history and depth, deadline, lifespan, liveliness;
    /// what is usual is left out.
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
        assert_eq!(Qos::LATCHED.to_string(), ":1:,1:,:,:,,");
    }
}
