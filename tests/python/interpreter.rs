//! The Python of tests that compare with another implementation. Test programs of all crates include this file.

use std::env;
use std::path::{Path, PathBuf};

/// The interpreter that `test.sh` sets up in a workspace, or the one that `DRAGNET_PYTHON` names. Without it the test
/// fails: skipping it would look like success.
pub(crate) fn interpreter(workspace: &Path) -> PathBuf {
    let given = env::var_os("DRAGNET_PYTHON").map(PathBuf::from);
    let interpreter = given.unwrap_or_else(|| workspace.join(".venv/bin/python"));
    assert!(
        interpreter.exists(),
        "{} is missing: ./test.sh makes it; or name another, with the packages of tests/python, in DRAGNET_PYTHON",
        interpreter.display()
    );
    interpreter
}
