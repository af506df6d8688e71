//! Passes over the demonstrations until the validation loss no longer improves.

use std::f64::consts::PI;
use std::path::Path;
use std::time::{Duration, Instant};

use dragnet_files::FileError;
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::seed::{Purpose, stream};
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use tch::{Device, Kind};

use super::adam::Adam;
use super::batch::{Answers, Batch};
use super::checkpoint::{self, Checkpoint};
use super::data::{Data, Sample};
use super::model::{Model, values};
use super::settings::{Epoch, Measured, Settings};

/// Batches that are formed together: within them, graphs of similar size are grouped, so that there is little padding.
const BATCHES_SORTED: usize = 16;
/// Longer gradients are scaled down to this norm.
pub(super) const MOST_GRADIENT: f64 = 1.0;

/// What identifies a training.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Cloning {
    settings: Settings,
    /// Number of training decisions, which identifies the data.
    decisions: usize,
    expert: String,
}

impl Cloning {
    fn new(settings: &Settings, data: &Data) -> Self {
        Self { settings: settings.clone(), decisions: data.len(), expert: data.source().to_string() }
    }
}

/// Falls from 1 to 0 as `done` rises from 0 to 1.
pub(super) fn half_cosine(done: f64) -> f64 {
    0.5 * (1.0 + (PI * done).cos())
}

/// A training under way.
pub struct Trainer<'a> {
    data: &'a Data,
    settings: Settings,
    model: Model,
    adam: Adam,
    history: Vec<Epoch>,
    /// Of the epoch with the lowest validation loss so far.
    best: Weights,
    program: String,
}

impl<'a> Trainer<'a> {
    /// Starts a training. `program` is the version that the weights will name.
    ///
    /// # Errors
    /// If the sizes are invalid.
    pub fn new(data: &'a Data, settings: Settings, device: Device, program: &str) -> Result<Self, String> {
        let model = Model::new(settings.shape, settings.seed, device);
        let adam = Adam::new(model.parameters().iter().map(|(_, tensor)| tensor));
        let best = model.weights(Recipe::default())?;
        Ok(Self { data, settings, model, adam, history: Vec::new(), best, program: program.to_owned() })
    }

    /// Resumes a training from its checkpoint.
    ///
    /// # Errors
    /// If the checkpoint cannot be read or is of another training.
    pub fn resume(
        data: &'a Data,
        settings: Settings,
        device: Device,
        program: &str,
        path: &Path,
    ) -> Result<Self, FileError> {
        let cloning = Cloning::new(&settings, data);
        let Checkpoint { weights, best, adam, history } =
            checkpoint::read(path, &cloning, (settings.shape, &settings.shape.parameters()), device)?;
        let model = Model::of(&weights, device);
        Ok(Self { data, settings, model, adam, history, best, program: program.to_owned() })
    }

    /// Writes a checkpoint.
    ///
    /// # Errors
    /// If it cannot be written; an older checkpoint is kept.
    pub fn checkpoint(&self, path: &Path) -> Result<(), FileError> {
        let weights = self.model.weights(Recipe::default());
        let weights = weights.map_err(|reason| FileError::content(path, reason))?;
        let now = checkpoint::View {
            learned: &self.settings.shape.parameters(),
            weights: &weights,
            best: &self.best,
            adam: &self.adam,
            history: &self.history,
        };
        checkpoint::write(path, &Cloning::new(&self.settings, self.data), &now)
    }

    /// Whether all epochs are done, or none of the last ones was better.
    #[must_use]
    pub fn is_done(&self) -> bool {
        let done = u32::try_from(self.history.len()).unwrap_or(u32::MAX);
        done >= self.settings.epochs || done - self.best_epoch() >= self.settings.patience
    }

    /// One pass over the training decisions. `progress` is called with the number of decisions of each step.
    ///
    /// # Errors
    /// If the network diverged: a parameter is no longer finite.
    pub fn epoch(&mut self, mut progress: impl FnMut(usize)) -> Result<&Epoch, String> {
        let start = Instant::now();
        let batches = self.batches();
        let mut sum = 0.0;
        for (step, batch) in batches.iter().enumerate() {
            let done = self.history.len() as f64 + step as f64 / batches.len() as f64;
            let learning_rate =
                self.settings.learning_rate * half_cosine(done / f64::from(self.settings.epochs));
            sum += self.step(batch, learning_rate) * batch.len() as f64;
            progress(batch.len());
        }
        let number = u32::try_from(self.history.len() + 1).unwrap_or(u32::MAX);
        let held_out = self.measure(&self.data.held_out);
        let recipe = Recipe {
            expert: self.data.source().expert.clone(),
            scenarios: self.data.scenarios().to_vec(),
            decisions: self.data.len() as u64,
            seed: self.settings.seed,
            epochs: number,
            held_out_loss: held_out.loss,
            program: self.program.clone(),
            within_cells: self.data.source().scored_within_cells,
            own_searches: None,
        };
        let weights = self.model.weights(recipe)?;
        if self.history.iter().all(|before| held_out.loss < before.held_out.loss) {
            self.best = weights;
        }
        let seconds = Duration::as_secs_f64(&start.elapsed());
        let epoch = Epoch { epoch: number, loss: sum / self.data.len() as f64, held_out, seconds };
        self.history.push(epoch);
        Ok(&self.history[self.history.len() - 1])
    }

    /// The history of all epochs.
    #[must_use]
    pub fn history(&self) -> &[Epoch] {
        &self.history
    }

    /// The weights of the epoch with the lowest validation loss.
    #[must_use]
    pub const fn best(&self) -> &Weights {
        &self.best
    }

    /// Decisions of an epoch.
    #[must_use]
    pub const fn decisions(&self) -> usize {
        self.data.len()
    }

    fn best_epoch(&self) -> u32 {
        self.best.recipe().epochs
    }

    /// All decisions in the order of this epoch.
    fn batches(&self) -> Vec<Vec<&'a Sample>> {
        let epoch = u16::try_from(self.history.len() + 1).unwrap_or(u16::MAX);
        let mut random = stream(self.settings.seed, Purpose::Training, epoch);
        let mut samples: Vec<&Sample> = self.data.learned.iter().collect();
        samples.shuffle(&mut random);
        for window in samples.chunks_mut(self.settings.batch * BATCHES_SORTED) {
            window.sort_by_key(|sample| sample.graph.topology.len());
        }
        let mut batches: Vec<Vec<&Sample>> = samples.chunks(self.settings.batch).map(<[_]>::to_vec).collect();
        batches.shuffle(&mut random);
        batches
    }

    /// Returns the mean loss before the step.
    fn step(&mut self, samples: &[&Sample], learning_rate: f64) -> f64 {
        let graphs: Vec<_> = samples.iter().map(|sample| &sample.graph).collect();
        let batch = Batch::of_graphs(&graphs, self.model.device());
        let answers = Answers::of(samples, batch.nodes, self.model.device());
        let log_policy = answers.log_policy(&self.model.logits(&batch));
        let loss = self.losses(&log_policy, &answers).mean(Kind::Float);
        loss.backward();
        self.adam.step(
            self.model.parameters().iter().map(|(_, tensor)| tensor),
            learning_rate,
            MOST_GRADIENT,
        );
        loss.double_value(&[])
    }

    /// The loss of each graph.
    fn losses(&self, log_policy: &tch::Tensor, answers: &Answers) -> tch::Tensor {
        let of_choice = -log_policy.gather(1, &answers.chosen, false).squeeze_dim(1);
        let of_wishes =
            -(log_policy * &answers.wished).sum_dim_intlist([1_i64].as_slice(), false, Kind::Float);
        of_choice * self.settings.choice_weight + of_wishes * (1.0 - self.settings.choice_weight)
    }

    fn measure(&self, samples: &[Sample]) -> Measured {
        let (mut loss, mut same, mut regret, mut scored) = (0.0, 0.0, 0.0, 0.0);
        let mut ordered: Vec<&Sample> = samples.iter().collect();
        ordered.sort_by_key(|sample| sample.graph.topology.len());
        for samples in ordered.chunks(self.settings.batch) {
            let graphs: Vec<_> = samples.iter().map(|sample| &sample.graph).collect();
            let (losses, choices) = tch::no_grad(|| {
                let batch = Batch::of_graphs(&graphs, self.model.device());
                let answers = Answers::of(samples, batch.nodes, self.model.device());
                let log_policy = answers.log_policy(&self.model.logits(&batch));
                (values(&self.losses(&log_policy, &answers)), log_policy.argmax(1, false))
            });
            loss += losses.iter().copied().map(f64::from).sum::<f64>();
            for (place, sample) in (0..).zip(samples) {
                let choice = choices.int64_value(&[place]);
                same += f64::from(u8::from(choice == i64::from(sample.chosen)));
                let share = usize::try_from(choice).ok().and_then(|choice| sample.share_of_best.get(choice));
                if let Some(&share) = share {
                    regret += 1.0 - f64::from(share);
                    scored += 1.0;
                }
            }
        }
        let count = samples.len() as f64;
        Measured { loss: loss / count, accuracy: same / count, regret: regret / f64::max(scored, 1.0) }
    }
}
