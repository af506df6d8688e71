//! Policy gradient (Williams 1992) on a network's own searches, in rounds: the searches of a round are explored with the
//! network of the last one, and a few steps are taken on some of their decisions.
//!
//! The steps are those of Schulman et al., "Proximal Policy Optimization" (2017, Eq. 7). Departures: there is no critic
//! to learn, for advantages come from the expert's cost to go ([`dragnet_learn::reinforcement`]), and each round has one
//! pass over decisions that are drawn ([`drawn`]), since a step costs as much as the searches for it.

mod drawn;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use dragnet_files::FileError;
use dragnet_learn::graph::Graph;
use dragnet_learn::network::Network;
use dragnet_learn::reinforcement::{Choice, Visit, advantages, expected_cells};
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::seed::{Purpose, stream};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use tch::{Device, Kind, Tensor};

use super::adam::Adam;
use super::batch::{Batch, NEVER, int};
use super::checkpoint::{self, Checkpoint};
use super::model::Model;
use super::trainer::{MOST_GRADIENT, half_cosine};
use drawn::{Drawn, draw};

/// A choice that has become likelier or less likely by this share within a round gains nothing from more of it.
const MOST_CHANGE: f64 = 0.2;

/// Settings of a reinforcement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reinforcement {
    /// Seed of the order of decisions.
    pub seed: u64,
    /// Number of rounds.
    pub rounds: u32,
    /// Decisions of a round that are learned from.
    pub decisions: usize,
    /// Decisions per training step.
    pub batch: usize,
    /// Initial learning rate of Adam; it falls to 0 along half a cosine over all rounds.
    pub learning_rate: f64,
    /// Temperature at which choices are drawn.
    pub temperature: f64,
    /// How far decisions answer for what follows them, `0..=1`.
    pub trace: f64,
    /// Which seeds are searched, and which measure.
    pub seeds: String,
    /// Digest of the weights that it starts from.
    pub start: String,
}

/// Measures of a round. Names are columns of the metrics file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// From 1; 0 is the start.
    pub round: u32,
    /// Searches explored.
    pub searches: usize,
    /// Choices in them.
    pub decisions: usize,
    /// Mean expected length of the searches, cells.
    pub expected_cells: f64,
    /// What a decision saved of what `tour` expected, cells, with all that it answers for: its mean,
    pub advantage: f64,
    /// and its standard deviation.
    pub advantage_deviation: f64,
    /// Mean probability of the choices.
    pub probability: f64,
    /// Mean length of the searches held out, cells, if they were measured after this round.
    pub held_out_cells: Option<f64>,
    /// Computing time.
    pub seconds: f64,
}

/// A reinforcement under way.
pub struct Reinforcer {
    settings: Reinforcement,
    model: Model,
    adam: Adam,
    history: Vec<Round>,
    /// Of the round with the shortest searches held out.
    best: Weights,
    program: String,
}

impl Reinforcer {
    /// Starts from a network. `program` is the version that the weights will name.
    #[must_use]
    pub fn new(start: Weights, settings: Reinforcement, device: Device, program: &str) -> Self {
        let model = Model::of(&start, device);
        let adam = Adam::new(model.parameters().iter().map(|(_, tensor)| tensor));
        Self { settings, model, adam, history: Vec::new(), best: start, program: program.to_owned() }
    }

    /// Resumes a reinforcement from its checkpoint.
    ///
    /// # Errors
    /// If the checkpoint cannot be read or is of another one.
    pub fn resume(
        start: &Weights,
        settings: Reinforcement,
        device: Device,
        program: &str,
        path: &Path,
    ) -> Result<Self, FileError> {
        let Checkpoint { weights, best, adam, history } =
            checkpoint::read(path, &settings, start.shape(), device)?;
        let model = Model::of(&weights, device);
        Ok(Self { settings, model, adam, history, best, program: program.to_owned() })
    }

    /// Writes a checkpoint.
    ///
    /// # Errors
    /// If it cannot be written; an older checkpoint is kept.
    pub fn checkpoint(&self, path: &Path) -> Result<(), FileError> {
        let weights = self.weights().map_err(|reason| FileError::content(path, reason))?;
        let now = checkpoint::View {
            weights: &weights,
            best: &self.best,
            adam: &self.adam,
            history: &self.history,
        };
        checkpoint::write(path, &self.settings, &now)
    }

    /// Number of rounds done.
    #[must_use]
    pub fn rounds_done(&self) -> u32 {
        self.history.last().map_or(0, |round| round.round)
    }

    /// Whether all rounds are done.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.rounds_done() >= self.settings.rounds
    }

    /// The network as it is now.
    ///
    /// # Errors
    /// If it diverged: a parameter is no longer finite.
    pub fn network(&self) -> Result<Arc<Network>, String> {
        Ok(Arc::new(Network::new(&self.weights()?)))
    }

    /// Learns from searches that were explored with [`Reinforcer::network`]: one round.
    ///
    /// # Errors
    /// If no search has a choice to learn from.
    pub fn learn(&mut self, searches: &[Vec<Visit>]) -> Result<(), String> {
        let number = self.rounds_done() + 1;
        let mut random = stream(self.settings.seed, Purpose::Training, u16::try_from(number).unwrap_or(0));
        let mut choices = Vec::new();
        for visits in searches {
            let advantages = advantages(visits, self.settings.trace);
            choices.extend(
                visits.iter().zip(advantages).filter_map(|(visit, saved)| Some((visit.choice.as_ref()?, saved))),
            );
        }
        if choices.is_empty() {
            return Err("no search has a choice to learn from".to_owned());
        }
        let count = choices.len() as f64;
        let advantage = moments(choices.iter().map(|&(_, saved)| saved));
        let mut drawn = draw(&choices, advantage, self.settings.decisions, &mut random);
        drawn.sort_by_key(|it| it.choice.graph.topology.len());
        let mut batches: Vec<&[Drawn<'_>]> = drawn.chunks(self.settings.batch).collect();
        batches.shuffle(&mut random);
        let done = f64::from(number - 1) / f64::from(self.settings.rounds);
        let learning_rate = self.settings.learning_rate * half_cosine(done);
        for batch in batches {
            self.step(batch, learning_rate);
        }
        let cells = searches.iter().map(|visits| expected_cells(visits));
        self.history.push(Round {
            round: number,
            searches: searches.len(),
            decisions: choices.len(),
            expected_cells: cells.sum::<f64>() / searches.len() as f64,
            advantage: advantage.0,
            advantage_deviation: advantage.1,
            probability: choices.iter().map(|(choice, _)| choice.log_probability.exp()).sum::<f64>() / count,
            held_out_cells: None,
            seconds: 0.0,
        });
        Ok(())
    }

    /// Takes the mean length of the searches held out before the first round, cells.
    pub fn start_measured(&mut self, held_out_cells: f64) {
        self.history.push(Round { held_out_cells: Some(held_out_cells), ..Round::default() });
    }

    /// Takes the mean length of searches held out with the network as it is now, cells.
    ///
    /// # Errors
    /// As for [`Reinforcer::network`].
    pub fn measured(&mut self, held_out_cells: f64) -> Result<(), String> {
        let weights = self.weights()?;
        let least = self.history.iter().filter_map(|it| it.held_out_cells).fold(f64::INFINITY, f64::min);
        if held_out_cells < least {
            self.best = weights;
        }
        if let Some(last) = self.history.last_mut() {
            last.held_out_cells = Some(held_out_cells);
        }
        Ok(())
    }

    /// Takes the computing time of the last round, with its searches.
    pub fn took(&mut self, time: Duration) -> &Round {
        let last = self.history.len() - 1;
        self.history[last].seconds = time.as_secs_f64();
        &self.history[last]
    }

    /// The history: the start, and all rounds.
    #[must_use]
    pub fn history(&self) -> &[Round] {
        &self.history
    }

    /// The weights of the round with the shortest searches held out.
    #[must_use]
    pub const fn best(&self) -> &Weights {
        &self.best
    }

    /// The weights as they are now.
    fn weights(&self) -> Result<Weights, String> {
        let own_searches: usize = self.history.iter().map(|round| round.searches).sum();
        let recipe = Recipe {
            own_searches: Some(own_searches as u64),
            program: self.program.clone(),
            ..self.best.recipe().clone()
        };
        self.model.weights(recipe)
    }

    fn step(&mut self, drawn: &[Drawn<'_>], learning_rate: f64) {
        let graphs: Vec<&Graph> = drawn.iter().map(|it| &it.choice.graph).collect();
        let batch = Batch::of_graphs(&graphs, self.model.device());
        let choices = Choices::of(drawn, batch.nodes, self.model.device());
        let logits = self.model.logits(&batch) / self.settings.temperature + &choices.no_candidate;
        let log_policy = logits.log_softmax(1, Kind::Float).gather(1, &choices.chosen, false).squeeze_dim(1);
        let loss = losses(&(log_policy - &choices.log_before), &choices.advantage).mean(Kind::Float);
        loss.backward();
        self.adam.step(
            self.model.parameters().iter().map(|(_, tensor)| tensor),
            learning_rate,
            MOST_GRADIENT,
        );
    }
}

/// `-min(r A, clip(r) A)` with `r` the ratio of probabilities now and before (Eq. 7), shape `[decisions]`.
fn losses(log_ratio: &Tensor, advantage: &Tensor) -> Tensor {
    let ratio = log_ratio.exp();
    let kept = ratio.clamp(1.0 - MOST_CHANGE, 1.0 + MOST_CHANGE);
    -(ratio * advantage).minimum(&(kept * advantage))
}

/// Choices in the graphs of a batch.
struct Choices {
    /// Shape `[graphs, 1]`.
    chosen: Tensor,
    /// 0 or [`NEVER`], shape `[graphs, nodes]`.
    no_candidate: Tensor,
    /// `ln pi` of the choices when they were made, shape `[graphs]`.
    log_before: Tensor,
    /// Shape `[graphs]`.
    advantage: Tensor,
}

impl Choices {
    fn of(drawn: &[Drawn<'_>], nodes: i64, device: Device) -> Self {
        let width = usize::try_from(nodes).unwrap_or(0);
        let mut no_candidate = vec![NEVER; drawn.len() * width];
        for (row, Drawn { choice, .. }) in no_candidate.chunks_mut(width).zip(drawn) {
            for (no_candidate, &is_candidate) in row.iter_mut().zip(&choice.is_candidate) {
                *no_candidate = if is_candidate { 0.0 } else { NEVER };
            }
        }
        let of_drawn = |value: fn(&Drawn<'_>) -> f64| {
            let values: Vec<f64> = drawn.iter().map(value).collect();
            Tensor::from_slice(&values).to_kind(Kind::Float).to_device(device)
        };
        let chosen: Vec<i64> = drawn.iter().map(|it| i64::from(it.choice.chosen)).collect();
        Self {
            chosen: Tensor::from_slice(&chosen).view([-1, 1]).to_device(device),
            no_candidate: Tensor::from_slice(&no_candidate).view([int(drawn.len()), nodes]).to_device(device),
            log_before: of_drawn(|it| it.choice.log_probability),
            advantage: of_drawn(|it| it.advantage),
        }
    }
}

/// Mean and standard deviation.
fn moments(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    (mean, (values.map(|it| (it - mean).powi(2)).sum::<f64>() / count).sqrt())
}
