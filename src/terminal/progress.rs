//! Progress bars on stderr, if that is a terminal.

use std::fmt::Write;
use std::time::Duration;

use console::Term;
use dragnet_experiments::progress::{Progress, Work};
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

/// A progress bar for a number of steps, while nothing is written to stdout.
pub(crate) fn alone(steps: u64, unit: &str) -> ProgressBar {
    let bar = ProgressBar::new(steps);
    let template = format!("{{bar:40}} {{pos}} of {{len}} {unit}, {{left}} left");
    bar.set_style(style(&template).with_key("left", |state: &ProgressState, text: &mut dyn Write| {
        let _ = match left(state.pos(), state.len().unwrap_or_default(), state.elapsed()) {
            Some(left) => write!(text, "{:#}", HumanDuration(left)),
            None => write!(text, "?"),
        };
    }));
    bar
}

/// The remaining time, if the steps to come take as long on average as those before. indicatif's own estimate follows
/// the last few steps, and jumps where steps differ.
fn left(done: u64, steps: u64, elapsed: Duration) -> Option<Duration> {
    (done > 0).then(|| elapsed.mul_f64(steps.saturating_sub(done) as f64 / done as f64))
}

/// A progress bar for each task while nothing is written to stdout.
pub(crate) struct Bars;

/// A progress bar that ends with its task.
struct Bar(ProgressBar);

impl Progress for Bars {
    fn begin(&self, steps: u64, unit: &str) -> Box<dyn Work> {
        Box::new(Bar(alone(steps, unit)))
    }
}

impl Work for Bar {
    fn advance(&self, steps: u64) {
        self.0.inc(steps);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A progress bar below lines that are written to stdout with [`ProgressBar::suspend`]; hidden if stdout is not a
/// terminal.
pub(crate) fn below_lines(steps: u64, unit: &str) -> ProgressBar {
    if !Term::stdout().is_term() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(steps);
    bar.set_style(style(&format!("{{bar:40}} {{pos}} of {{len}} {unit}  {{msg}}")));
    bar
}

/// A template that does not parse only changes the appearance.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
