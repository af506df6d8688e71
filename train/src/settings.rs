//! How a training runs, and what its epochs come to.

use dragnet_learn::shape::Shape;
use serde::{Deserialize, Serialize};

/// How to learn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Sizes of the network.
    pub shape: Shape,
    /// Of the first weights and of the order of decisions.
    pub seed: u64,
    /// Decisions a step.
    pub batch: usize,
    /// Passes over the decisions, at most.
    pub epochs: u32,
    /// Of Adam at the start; it falls to 0 along half a cosine over all epochs.
    pub learning_rate: f64,
    /// Ends after so many epochs without a better held-out loss.
    pub patience: u32,
    /// Weight of the cross-entropy against the expert's choice (Eq. 5), `0..=1`; the rest goes to that against its
    /// scores, which tell near ties from mistakes.
    pub choice_weight: f64,
}

/// What an epoch came to. Names are columns of the metrics file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// From 1.
    pub epoch: u32,
    /// Over what was learned from, while it was.
    pub loss: f64,
    /// Over what was held out.
    pub held_out: Measured,
    /// Computing time.
    pub seconds: f64,
}

/// How well held-out decisions are imitated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Mean loss.
    pub loss: f64,
    /// Share of decisions where the network chose what the expert chose.
    pub accuracy: f64,
    /// Mean of what the network's choice lost of the expert's best score, `0..=1`; over decisions with scores above 0.
    pub regret: f64,
}
