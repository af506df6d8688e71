//! Settings of a training, and the measures of its epochs.

use dragnet_learn::shape::Shape;
use serde::{Deserialize, Serialize};

/// Settings of a training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Sizes of the network.
    pub shape: Shape,
    /// Seed of the initial weights and of the order of decisions.
    pub seed: u64,
    /// Decisions per training step.
    pub batch: usize,
    /// Maximum number of passes over the decisions.
    pub epochs: u32,
    /// Initial learning rate of Adam; it falls to 0 along half a cosine over all epochs.
    pub learning_rate: f64,
    /// Training ends after this many epochs without a better validation loss.
    pub patience: u32,
    /// Weight of the cross-entropy against the expert's choice (Eq. 5), `0..=1`; the rest is the weight of that against
    /// its scores, which distinguish near ties from mistakes.
    pub choice_weight: f64,
}

/// Measures of an epoch. Names are columns of the metrics file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// From 1.
    pub epoch: u32,
    /// Mean training loss, during the epoch.
    pub loss: f64,
    /// Measures of the validation decisions.
    pub held_out: Measured,
    /// Computing time.
    pub seconds: f64,
}

/// Measures of imitation on validation decisions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Mean loss.
    pub loss: f64,
    /// Share of decisions where the network chose what the expert chose.
    pub accuracy: f64,
    /// Mean relative loss of the expert's score by the network's choice, `0..=1`; over decisions with scores above 0.
    pub regret: f64,
}
