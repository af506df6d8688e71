//! Adam (Kingma and Ba, ICLR 2015, Algorithm 1), with a state that can be stored so that training can resume: tch does
//! not expose the state of libtorch's own.

use tch::Tensor;

const FIRST_DECAY: f64 = 0.9;
const SECOND_DECAY: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Moments of the gradients of some parameters.
#[derive(Debug)]
pub(super) struct Adam {
    /// Steps taken.
    pub(super) steps: u64,
    /// First moments, one tensor for each parameter.
    pub(super) first: Vec<Tensor>,
    /// Second moments.
    pub(super) second: Vec<Tensor>,
}

impl Adam {
    pub(super) fn new<'a>(parameters: impl Iterator<Item = &'a Tensor>) -> Self {
        let zeros: Vec<Tensor> = parameters.map(|parameter| parameter.detach().zeros_like()).collect();
        Self { steps: 0, first: zeros.iter().map(Tensor::copy).collect(), second: zeros }
    }

    /// One step against the gradients, which are scaled down to norm `max_norm` together if they are longer, and
    /// cleared.
    pub(super) fn step<'a>(
        &mut self,
        parameters: impl Iterator<Item = &'a Tensor> + Clone,
        learning_rate: f64,
        max_norm: f64,
    ) {
        self.steps += 1;
        let squares: f64 =
            parameters.clone().map(|it| it.grad().square().sum(tch::Kind::Float).double_value(&[])).sum();
        let scale = (max_norm / squares.sqrt().max(1e-12)).min(1.0);
        #[expect(clippy::cast_possible_truncation, reason = "far below 2^31 steps")]
        let (first_bias, second_bias) =
            (1.0 - FIRST_DECAY.powi(self.steps as i32), 1.0 - SECOND_DECAY.powi(self.steps as i32));
        tch::no_grad(|| {
            for ((parameter, first), second) in parameters.zip(&mut self.first).zip(&mut self.second) {
                let gradient = parameter.grad() * scale;
                *first = &*first * FIRST_DECAY + &gradient * (1.0 - FIRST_DECAY);
                *second = &*second * SECOND_DECAY + gradient.square() * (1.0 - SECOND_DECAY);
                let step =
                    (&*first / first_bias) / ((&*second / second_bias).sqrt() + EPSILON) * learning_rate;
                let mut parameter = parameter.shallow_clone();
                let _ = parameter.g_sub_(&step);
                parameter.zero_grad();
            }
        });
    }
}
