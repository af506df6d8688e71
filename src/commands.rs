//! The subcommands, one file each, and their errors.

mod agent;
mod benchmark;
mod calibrate;
mod check;
mod compare;
mod comparison;
mod completions;
mod coordinator;
mod demonstrate;
mod detect;
mod doctor;
mod dry_run;
mod earlier;
mod export;
mod eyes;
mod forecast;
mod foxglove;
mod inspect;
mod keys;
mod live;
mod merge;
mod output;
mod paper;
mod plan;
mod recover;
mod reinforce;
mod relay;
mod replay;
mod run;
mod scenario;
mod scenarios;
mod schema;
mod search;
mod segments;
mod settings;
mod sim;
mod soak;
mod train;
#[cfg(feature = "train")]
mod training;

use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;

use dragnet_experiments::ExperimentError;
use dragnet_runtime::RuntimeError;

/// The subcommands.
#[derive(clap::Subcommand)]
pub(crate) enum Command {
    Run(run::Arguments),
    Plan(plan::Arguments),
    Forecast(forecast::Arguments),
    Compare(compare::Arguments),
    Benchmark(benchmark::Arguments),
    Demonstrate(demonstrate::Arguments),
    Train(train::Arguments),
    Reinforce(reinforce::Arguments),
    Merge(merge::Arguments),
    Paper(paper::Arguments),
    Scenarios(scenarios::Arguments),
    Check(check::Arguments),
    Schema(schema::Arguments),
    Inspect(inspect::Arguments),
    Recover(recover::Arguments),
    Export(export::Arguments),
    Calibrate(calibrate::Arguments),
    Detect(detect::Arguments),
    Replay(replay::Arguments),
    Agent(agent::Arguments),
    Doctor(doctor::Arguments),
    Coordinator(coordinator::Arguments),
    Sim(sim::Arguments),
    Relay(relay::Arguments),
    Keys(keys::Arguments),
    Soak(soak::Arguments),
    Completions(completions::Arguments),
}

impl Command {
    /// Whether this is a process of a mission that runs until it is stopped.
    pub(crate) const fn serves(&self) -> bool {
        matches!(self, Self::Agent(_) | Self::Coordinator(_) | Self::Sim(_) | Self::Relay(_))
    }
}

/// Runs a subcommand.
pub(crate) fn execute(command: Command) -> Result<(), Failure> {
    match command {
        Command::Run(arguments) => run::execute(&arguments),
        Command::Plan(arguments) => plan::execute(&arguments),
        Command::Forecast(arguments) => forecast::execute(&arguments),
        Command::Compare(arguments) => compare::execute(&arguments),
        Command::Benchmark(arguments) => benchmark::execute(&arguments),
        Command::Demonstrate(arguments) => demonstrate::execute(&arguments),
        Command::Train(arguments) => train::execute(&arguments),
        Command::Reinforce(arguments) => reinforce::execute(&arguments),
        Command::Merge(arguments) => merge::execute(&arguments),
        Command::Paper(arguments) => paper::execute(&arguments),
        Command::Scenarios(arguments) => scenarios::execute(&arguments),
        Command::Check(arguments) => check::execute(&arguments),
        Command::Schema(arguments) => schema::execute(&arguments),
        Command::Inspect(arguments) => inspect::execute(&arguments),
        Command::Recover(arguments) => recover::execute(&arguments),
        Command::Export(arguments) => export::execute(&arguments),
        Command::Calibrate(arguments) => calibrate::execute(&arguments),
        Command::Detect(arguments) => detect::execute(&arguments),
        Command::Replay(arguments) => replay::execute(&arguments),
        Command::Agent(arguments) => agent::execute(&arguments),
        Command::Doctor(arguments) => doctor::execute(&arguments),
        Command::Coordinator(arguments) => coordinator::execute(&arguments),
        Command::Sim(arguments) => sim::execute(&arguments),
        Command::Relay(arguments) => relay::execute(&arguments),
        Command::Keys(arguments) => keys::execute(&arguments),
        Command::Soak(arguments) => soak::execute(&arguments),
        Command::Completions(arguments) => completions::execute(&arguments),
    }
}

/// Why a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The request is invalid: exit code 2.
    Input(String),
    /// The request is valid and its execution failed: exit code 1.
    Run(String),
    /// The reader of the output has closed it, as `head` does: not a failure.
    NobodyListens,
}

impl Failure {
    fn input(message: impl fmt::Display) -> Self {
        Self::Input(message.to_string())
    }

    fn run(message: impl fmt::Display) -> Self {
        Self::Run(message.to_string())
    }

    /// Prints the failure on stderr and returns the exit code of the program.
    pub(crate) fn report(self) -> ExitCode {
        let (message, code) = match self {
            Self::Input(message) => (message, ExitCode::from(2)),
            Self::Run(message) => (message, ExitCode::FAILURE),
            Self::NobodyListens => return ExitCode::SUCCESS,
        };
        complain("error", &message);
        code
    }
}

/// Of writing to stdout, the only operation that fails with a bare [`io::Error`] here.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            Self::NobodyListens
        } else {
            Self::Run(format!("cannot write to standard output: {error}"))
        }
    }
}

impl From<RuntimeError> for Failure {
    fn from(error: RuntimeError) -> Self {
        if error.is_bad_input() { Self::input(error) } else { Self::run(error) }
    }
}

impl From<ExperimentError> for Failure {
    fn from(error: ExperimentError) -> Self {
        match error {
            ExperimentError::Input(message) => Self::Input(message),
            ExperimentError::Run(message) => Self::Run(message),
            ExperimentError::Cancelled => Self::run(error),
        }
    }
}

/// Prints a line on stderr. If that is closed the message is dropped.
fn complain(what: &str, message: &str) {
    let _ = writeln!(io::stderr(), "{what}: {message}");
}
