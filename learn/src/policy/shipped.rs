//! The networks that are part of the program.

use std::sync::{Arc, LazyLock};

use crate::network::Network;
use crate::weights::Weights;

/// A built-in network, by its expert and the maps that it was trained on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shipped {
    /// `path`, on a mixture of generated maps of many sizes and densities.
    General,
    /// `greedy`, on the ice cream cone.
    GreedyIceCreamCone,
    /// `greedy`, on the all-traversable map.
    GreedyAllTraversable,
    /// `greedy`, on the open asterisk; for the paper's Table II only.
    GreedyOpenAsterisk,
    /// `greedy`, on the figure four; for the paper's Table II only.
    GreedyFigureFour,
    /// `path`, on the ice cream cone.
    PathIceCreamCone,
    /// `path`, on the all-traversable map.
    PathAllTraversable,
    /// `tour`, on the mixture of generated maps.
    Tour,
}

type Lazy = LazyLock<Arc<Network>>;

static GENERAL: Lazy = Lazy::new(|| read(Shipped::General));
static GREEDY_ICC: Lazy = Lazy::new(|| read(Shipped::GreedyIceCreamCone));
static GREEDY_AT: Lazy = Lazy::new(|| read(Shipped::GreedyAllTraversable));
static GREEDY_OA: Lazy = Lazy::new(|| read(Shipped::GreedyOpenAsterisk));
static GREEDY_FOUR: Lazy = Lazy::new(|| read(Shipped::GreedyFigureFour));
static PATH_ICC: Lazy = Lazy::new(|| read(Shipped::PathIceCreamCone));
static TOUR: Lazy = Lazy::new(|| read(Shipped::Tour));
static PATH_AT: Lazy = Lazy::new(|| read(Shipped::PathAllTraversable));

impl Shipped {
    /// All built-in networks.
    pub const ALL: [Self; 8] = [
        Self::General,
        Self::GreedyIceCreamCone,
        Self::GreedyAllTraversable,
        Self::GreedyOpenAsterisk,
        Self::GreedyFigureFour,
        Self::PathIceCreamCone,
        Self::PathAllTraversable,
        Self::Tour,
    ];

    /// The name used in scenarios and on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::General => "gnn",
            Self::GreedyIceCreamCone => "gnn-greedy",
            Self::GreedyAllTraversable => "gnn-greedy-at",
            Self::GreedyOpenAsterisk => "gnn-greedy-oa",
            Self::GreedyFigureFour => "gnn-greedy-four",
            Self::PathIceCreamCone => "gnn-path",
            Self::PathAllTraversable => "gnn-path-at",
            Self::Tour => "gnn-tour",
        }
    }

    /// The bytes of its weights file.
    #[must_use]
    pub const fn weights(self) -> &'static [u8] {
        match self {
            Self::General => include_bytes!("../../weights/gnn.safetensors"),
            Self::GreedyIceCreamCone => include_bytes!("../../weights/gnn-greedy.safetensors"),
            Self::GreedyAllTraversable => include_bytes!("../../weights/gnn-greedy-at.safetensors"),
            Self::GreedyOpenAsterisk => include_bytes!("../../weights/gnn-greedy-oa.safetensors"),
            Self::GreedyFigureFour => include_bytes!("../../weights/gnn-greedy-four.safetensors"),
            Self::PathIceCreamCone => include_bytes!("../../weights/gnn-path.safetensors"),
            Self::Tour => include_bytes!("../../weights/gnn-tour.safetensors"),
            Self::PathAllTraversable => include_bytes!("../../weights/gnn-path-at.safetensors"),
        }
    }

    /// The network; its weights are read once per process.
    #[must_use]
    pub fn network(self) -> Arc<Network> {
        Arc::clone(match self {
            Self::General => &GENERAL,
            Self::GreedyIceCreamCone => &GREEDY_ICC,
            Self::GreedyAllTraversable => &GREEDY_AT,
            Self::GreedyOpenAsterisk => &GREEDY_OA,
            Self::GreedyFigureFour => &GREEDY_FOUR,
            Self::PathIceCreamCone => &PATH_ICC,
            Self::PathAllTraversable => &PATH_AT,
            Self::Tour => &TOUR,
        })
    }
}

/// Weights that are checked by a test of this crate.
#[expect(clippy::expect_used, reason = "they are part of the program, and a test reads them all")]
fn read(shipped: Shipped) -> Arc<Network> {
    let weights = Weights::from_bytes(shipped.weights()).expect("weights that are part of the program");
    Arc::new(Network::new(&weights))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_network_that_is_part_of_the_program_can_be_read() {
        for shipped in Shipped::ALL {
            let _ = shipped.network();
        }
    }
}
