//! All policies by name, including the learned ones.

mod gnn;
mod name;
mod shipped;

use std::sync::Arc;

use dragnet_search::policy::{self, Parameters, Policy};

use crate::network::Network;

pub use gnn::Gnn;
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
