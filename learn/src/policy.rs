//! All policies by name, including the learned ones.

mod gnn;
mod name;
mod shipped;

use std::sync::Arc;

use dragnet_search::policy::{self, Parameters, Policy, SCORED_WITHIN_CELLS, TourScores};

use crate::network::Network;

pub use gnn::Gnn;
pub(crate) use gnn::{Opinion, escape};
pub use name::{PolicyName, UnknownPolicy};
pub use shipped::Shipped;

/// Builds the policy with this name. Learned ones use `network`, if given, instead of the built-in one.
#[must_use]
pub fn build(
    name: PolicyName,
    parameters: Parameters,
    network: Option<&Arc<Network>>,
) -> Box<dyn Policy + Send> {
    match name {
        PolicyName::Exact(name) => policy::build(name, parameters),
        PolicyName::Learned(shipped) => {
            Box::new(Gnn::new(network.map_or_else(|| shipped.network(), Arc::clone)))
        }
    }
}

/// Builds a policy to learn from. It is that of [`build`], but `tour`, which decides on a whole tour, scores cells.
#[must_use]
pub fn expert(name: PolicyName, parameters: Parameters) -> Box<dyn Policy + Send> {
    match name {
        PolicyName::Exact(policy::PolicyName::Tour) => Box::new(TourScores::new(parameters)),
        name => build(name, parameters, None),
    }
}

/// The path from which on the expert of [`expert`] scores no cells, cells; `None` if it scores all.
#[must_use]
pub const fn scored_within_cells(name: PolicyName) -> Option<f32> {
    match name {
        PolicyName::Exact(policy::PolicyName::Tour) => Some(SCORED_WITHIN_CELLS),
        _ => None,
    }
}
