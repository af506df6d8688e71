//! Policy gradient (Williams 1992) on a network's own searches, in rounds: the searches of a round are explored with the
//! network of the last one, and a few passes are made over their decisions.
//!
//! Steps are those of Schulman et al., "Proximal Policy Optimization" (2017, Eq. 7). Departures: there is no critic to
//! learn, for advantages come from the expert's cost to go ([`dragnet_learn::reinforcement`]). And only the last two
//! layers learn, `head` and `logit`: what comes before them was computed to decide, and is kept with the choice. A step
//! through the whole network costs as much as ten decisions, and one decision tells little.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use dragnet_files::FileError;
use dragnet_learn::network::{LOGIT_SCALE, Network};
use dragnet_learn::reinforcement::{Choice, Visit, advantages, expected_cells};
use dragnet_learn::shape::{Parameter, Shape};
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::seed::{Purpose, stream};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use tch::{Device, Kind, Tensor};

use super::adam::Adam;
use super::batch::{NEVER, int};
use super::checkpoint::{self, Checkpoint};
use super::model::{tensor, values};
use super::trainer::{MOST_GRADIENT, half_cosine};

/// A choice that has become likelier or less likely by this share within a round gains nothing from more of it.
const MOST_CHANGE: f64 = 0.2;
/// The most that a decision is held to have saved or lost, in units of the round's spread: long ways round are rare, and
/// would else drown all others.
const MOST_SPREADS: f64 = 4.0;

/// Settings of a reinforcement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reinforcement {
    /// Seed of the order of decisions.
    pub seed: u64,
    /// Number of rounds.
    pub rounds: u32,
    /// Passes over the decisions of a round.
    pub passes: u32,
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
    /// The same over what `tour` expected at their beginnings.
    pub of_tour: f64,
    /// What a decision saved of what `tour` expected, cells, with all that it answers for: its mean,
    pub advantage: f64,
    /// and its mean absolute deviation.
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
    /// What does not learn comes from here.
    start: Weights,
    head: Head,
    adam: Adam,
    history: Vec<Round>,
    /// Of the round with the shortest searches held out.
    best: Weights,
    program: String,
    device: Device,
}

impl Reinforcer {
    /// Starts from a network. `program` is the version that the weights will name.
    #[must_use]
    pub fn new(start: Weights, settings: Reinforcement, device: Device, program: &str) -> Self {
        let head = Head::of(&start, device);
        let adam = Adam::new(head.tensors.iter());
        let (best, program) = (start.clone(), program.to_owned());
        Self { settings, start, head, adam, history: Vec::new(), best, program, device }
    }

    /// Resumes a reinforcement from its checkpoint.
    ///
    /// # Errors
    /// If the checkpoint cannot be read or is of another one.
    pub fn resume(
        start: Weights,
        settings: Reinforcement,
        device: Device,
        program: &str,
        path: &Path,
    ) -> Result<Self, FileError> {
        let shape = start.shape();
        let Checkpoint { weights, best, adam, history } =
            checkpoint::read(path, &settings, (shape, &Head::parameters(shape)), device)?;
        let (head, program) = (Head::of(&weights, device), program.to_owned());
        Ok(Self { settings, start, head, adam, history, best, program, device })
    }

    /// Writes a checkpoint.
    ///
    /// # Errors
    /// If it cannot be written; an older checkpoint is kept.
    pub fn checkpoint(&self, path: &Path) -> Result<(), FileError> {
        let weights = self.weights().map_err(|reason| FileError::content(path, reason))?;
        let now = checkpoint::View {
            learned: &Head::parameters(self.start.shape()),
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
        let mut choices = Vec::new();
        for visits in searches {
            let of_search = visits.iter().zip(advantages(visits, self.settings.trace));
            choices.extend(of_search.filter_map(|(visit, saved)| Some((visit.choice.as_ref()?, saved))));
        }
        if choices.is_empty() {
            return Err("no search has a choice to learn from".to_owned());
        }
        let round = Round { round: number, ..measures(searches, &choices) };
        for (_, saved) in &mut choices {
            let spreads = (*saved - round.advantage) / round.advantage_deviation.max(1e-9);
            *saved = spreads.clamp(-MOST_SPREADS, MOST_SPREADS);
        }
        let mut random = stream(self.settings.seed, Purpose::Training, u16::try_from(number).unwrap_or(0));
        let done = f64::from(number - 1) / f64::from(self.settings.rounds);
        let learning_rate = self.settings.learning_rate * half_cosine(done);
        for _ in 0..self.settings.passes {
            choices.shuffle(&mut random);
            for batch in choices.chunks(self.settings.batch) {
                self.step(batch, learning_rate);
            }
        }
        self.history.push(round);
        Ok(())
    }

    /// Takes the mean length of the searches held out before the first round, cells.
    pub fn start_measured(&mut self, held_out_cells: f64) {
        self.history.push(Round { held_out_cells: Some(held_out_cells), ..Round::default() });
    }

    /// Takes the mean length of the searches held out with the network as it is now, cells.
    ///
    /// # Errors
    /// As for [`Reinforcer::network`].
    pub fn measured(&mut self, held_out_cells: f64) -> Result<(), String> {
        let least = self.history.iter().filter_map(|it| it.held_out_cells).fold(f64::INFINITY, f64::min);
        if held_out_cells < least {
            self.best = self.weights()?;
        }
        if let Some(last) = self.history.last_mut() {
            last.held_out_cells = Some(held_out_cells);
        }
        Ok(())
    }

    /// Takes the computing time of the last round, with its searches.
    pub fn took(&mut self, time: Duration) {
        if let Some(last) = self.history.last_mut() {
            last.seconds = time.as_secs_f64();
        }
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
    ///
    /// # Errors
    /// As for [`Reinforcer::network`].
    pub fn weights(&self) -> Result<Weights, String> {
        let own_searches: usize = self.history.iter().map(|round| round.searches).sum();
        let recipe = Recipe {
            own_searches: Some(own_searches as u64),
            program: self.program.clone(),
            ..self.start.recipe().clone()
        };
        let learned = Head::parameters(self.start.shape());
        Weights::build(self.start.shape(), recipe, |name, _| {
            match learned.iter().position(|parameter| parameter.name == name) {
                Some(place) => values(&self.head.tensors[place]),
                None => self.start.get(name).to_vec(),
            }
        })
    }

    fn step(&mut self, choices: &[(&Choice, f64)], learning_rate: f64) {
        let width = self.start.shape().head_inputs();
        let batch = Batch::of(choices, width, self.device);
        let logits = self.head.logits(&batch.inputs) / self.settings.temperature + &batch.no_candidate;
        let log_policy = logits.log_softmax(1, Kind::Float).gather(1, &batch.chosen, false).squeeze_dim(1);
        let loss = losses(&(log_policy - &batch.log_before), &batch.advantage).mean(Kind::Float);
        loss.backward();
        self.adam.step(self.head.tensors.iter(), learning_rate, MOST_GRADIENT);
    }
}

/// What is measured of a round's searches and choices.
fn measures(searches: &[Vec<Visit>], choices: &[(&Choice, f64)]) -> Round {
    let count = choices.len() as f64;
    let cells: f64 = searches.iter().map(|visits| expected_cells(visits)).sum();
    let by_tour: f64 = searches.iter().filter_map(|visits| Some(visits.first()?.to_go.expected_cells)).sum();
    let advantage = choices.iter().map(|(_, saved)| saved).sum::<f64>() / count;
    Round {
        searches: searches.len(),
        decisions: choices.len(),
        expected_cells: cells / searches.len() as f64,
        of_tour: cells / by_tour.max(f64::MIN_POSITIVE),
        advantage,
        advantage_deviation: choices.iter().map(|(_, saved)| (saved - advantage).abs()).sum::<f64>() / count,
        probability: choices.iter().map(|(choice, _)| choice.log_probability.exp()).sum::<f64>() / count,
        ..Round::default()
    }
}

/// `-min(r A, clip(r) A)` with `r` the ratio of probabilities now and before (Eq. 7), shape `[decisions]`.
fn losses(log_ratio: &Tensor, advantage: &Tensor) -> Tensor {
    let ratio = log_ratio.exp();
    let kept = ratio.clamp(1.0 - MOST_CHANGE, 1.0 + MOST_CHANGE);
    -(ratio * advantage).minimum(&(kept * advantage))
}

/// The last two layers of the network.
struct Head {
    /// Those of [`Head::parameters`].
    tensors: [Tensor; 4],
}

impl Head {
    const NAMES: [&str; 4] = ["head.weight", "head.bias", "logit.weight", "logit.bias"];

    fn of(weights: &Weights, device: Device) -> Self {
        let parameters = Self::parameters(weights.shape());
        let learned = |name: &str| {
            let shape = parameters.iter().find(|parameter| parameter.name == name);
            let shape = shape.map_or(&[] as &[usize], |parameter| &parameter.shape);
            tensor(weights.get(name), shape, device).set_requires_grad(true)
        };
        Self { tensors: Self::NAMES.map(learned) }
    }

    fn parameters(shape: Shape) -> Vec<Parameter> {
        let all = shape.parameters();
        let named = |name: &&str| all.iter().find(|parameter| parameter.name == **name).cloned();
        Self::NAMES.iter().filter_map(named).collect()
    }

    /// Logits of candidates, shape `[decisions, candidates]`, from inputs `[decisions, candidates, head_inputs]`.
    fn logits(&self, inputs: &Tensor) -> Tensor {
        let [weight, bias, logit_weight, logit_bias] = &self.tensors;
        let head = inputs.linear(weight, Some(bias)).leaky_relu();
        let logits = Tensor::cat(&[&head, inputs], 2).linear(logit_weight, Some(logit_bias));
        logits.squeeze_dim(2) * f64::from(LOGIT_SCALE)
    }
}

/// Choices, padded to as many candidates.
struct Batch {
    /// Shape `[decisions, candidates, head_inputs]`.
    inputs: Tensor,
    /// 0 or [`NEVER`], shape `[decisions, candidates]`.
    no_candidate: Tensor,
    /// Shape `[decisions, 1]`.
    chosen: Tensor,
    /// `ln pi` of the choices when they were made, shape `[decisions]`.
    log_before: Tensor,
    /// Shape `[decisions]`.
    advantage: Tensor,
}

impl Batch {
    fn of(choices: &[(&Choice, f64)], width: usize, device: Device) -> Self {
        let most = choices.iter().map(|(choice, _)| choice.inputs.len()).max().unwrap_or(0);
        let candidates = most / width;
        let mut inputs = vec![0.0_f32; choices.len() * most];
        let mut no_candidate = vec![NEVER; choices.len() * candidates];
        for (place, (choice, _)) in choices.iter().enumerate() {
            inputs[place * most..][..choice.inputs.len()].copy_from_slice(&choice.inputs);
            no_candidate[place * candidates..][..choice.inputs.len() / width].fill(0.0);
        }
        let (decisions, candidates) = (int(choices.len()), int(candidates));
        let floats = |values: Vec<f64>| Tensor::from_slice(&values).to_kind(Kind::Float).to_device(device);
        let chosen: Vec<i64> = choices.iter().map(|(choice, _)| int(choice.chosen)).collect();
        Self {
            inputs: Tensor::from_slice(&inputs).view([decisions, candidates, int(width)]).to_device(device),
            no_candidate: Tensor::from_slice(&no_candidate).view([decisions, candidates]).to_device(device),
            chosen: Tensor::from_slice(&chosen).view([-1, 1]).to_device(device),
            log_before: floats(choices.iter().map(|(choice, _)| choice.log_probability).collect()),
            advantage: floats(choices.iter().map(|&(_, saved)| saved).collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_gains_by_its_advantage_until_it_has_changed_enough() {
        let slope = |ratio: f64, advantage: f64| {
            let log_ratio = Tensor::from_slice(&[ratio.ln()]).set_requires_grad(true);
            losses(&log_ratio, &Tensor::from_slice(&[advantage])).sum(Kind::Double).backward();
            log_ratio.grad().double_value(&[0])
        };
        for (ratio, advantage, expected) in [
            (1.0, 2.0, -2.0),
            (1.0, -2.0, 2.0),
            (1.1, 2.0, -2.2),
            (1.3, 2.0, 0.0),
            (1.3, -2.0, 2.6),
            (0.7, -2.0, 0.0),
            (0.7, 2.0, -1.4),
        ] {
            let slope = slope(ratio, advantage);
            assert!((slope - expected).abs() < 1e-6, "{ratio} {advantage}: {slope}");
        }
    }
}
