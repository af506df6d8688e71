//! What `train` and `reinforce` share: the files beside the weights, checks of options, and the process that
//! libtorch runs in.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Failure, output};

/// Settings of glibc's allocator that keep freed tensors in the heap. Without them every large tensor costs a mapping and
/// its page faults, and a step takes three times as long.
const ALLOCATOR: [(&str, &str); 3] =
    [("MALLOC_MMAP_MAX_", "0"), ("MALLOC_TRIM_THRESHOLD_", "-1"), ("MALLOC_TOP_PAD_", "67108864")];

/// Files beside the weights.
pub(super) struct Files {
    pub(super) checkpoint: PathBuf,
    pub(super) metrics: PathBuf,
    pub(super) curves: PathBuf,
}

impl Files {
    pub(super) fn beside(out: &Path) -> Result<Self, Failure> {
        let out = output::free("--out", out, "no weights are")?;
        let with = |ending: &str| {
            let mut name = OsString::from(&out);
            name.push(ending);
            PathBuf::from(name)
        };
        Ok(Self { checkpoint: with(".checkpoint"), metrics: with(".metrics.csv"), curves: with(".svg") })
    }

    /// Writes the progress so far, as a table and as a plot.
    pub(super) fn write_curves(
        &self,
        table: Result<Vec<u8>, String>,
        drawing: Result<String, String>,
    ) -> Result<(), Failure> {
        output::write(&self.metrics, &table.map_err(|error| failure(&self.metrics, &error))?)?;
        let drawing = drawing.map_err(|error| failure(&self.curves, &error))?;
        Ok(output::write(&self.curves, drawing.as_bytes())?)
    }
}

fn failure(path: &Path, error: &impl ToString) -> Failure {
    Failure::Run(format!("{}: cannot write: {}", path.display(), error.to_string()))
}

/// Checks that a learning rate is above 0 and at most 1.
pub(super) fn check_learning_rate(rate: f64) -> Result<(), Failure> {
    let is_allowed = rate > 0.0 && rate <= 1.0;
    check("learning-rate", rate, is_allowed, "a number above 0 and up to 1")
}

/// Checks that an option is a finite number above 0.
pub(super) fn check_positive(flag: &str, value: f64) -> Result<(), Failure> {
    check(flag, value, value > 0.0 && value.is_finite(), "a number above 0")
}

/// Checks that an option is a share.
pub(super) fn check_share(flag: &str, value: f64) -> Result<(), Failure> {
    check(flag, value, (0.0..=1.0).contains(&value), "a share from 0 to 1")
}

/// Rejects an option's value unless it is allowed.
pub(super) fn check(flag: &str, value: f64, is_allowed: bool, allowed: &str) -> Result<(), Failure> {
    let wrong = || Failure::Input(format!("--{flag} {value}: allowed is {allowed}"));
    if is_allowed { Ok(()) } else { Err(wrong()) }
}

/// Restarts this process with the allocator configured: glibc reads the settings once, when a process starts.
pub(super) fn start_anew_with_allocator() {
    if std::env::var_os(ALLOCATOR[0].0).is_some() {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        // If that fails the training is slower, and otherwise the same.
        let _ = Command::new(program).args(std::env::args_os().skip(1)).envs(ALLOCATOR).exec();
    }
}
