//! Lets programs that train find libtorch when cargo runs them: tests and benchmarks of all crates above this one.
//!
//! Cargo runs programs with the folders that build scripts search for libraries, but only with those within `target/`. A
//! path in the program itself would not do: a build script can set it for programs of its own package alone, and what is
//! trained with is linked into whatever a crate above happens to share an object file with.

use std::io;
use std::path::{Path, PathBuf};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    let libtorch = std::env::var_os("LIBTORCH").map(PathBuf::from);
    let out = std::env::var_os("OUT_DIR").map(PathBuf::from);
    if std::env::var_os("CARGO_FEATURE_TRAIN").is_some()
        && let (Some(libtorch), Some(out)) = (libtorch, out)
    {
        let link = out.join("libtorch");
        replace_link(&libtorch.join("lib"), &link)?;
        println!("cargo::rustc-link-search=native={}", link.display());
    }
    Ok(())
}

#[cfg(unix)]
fn replace_link(to: &Path, link: &Path) -> io::Result<()> {
    match std::fs::remove_file(link) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => std::os::unix::fs::symlink(to, link),
    }
}

/// Windows asks for libraries in `PATH`.
#[cfg(not(unix))]
fn replace_link(_: &Path, _: &Path) -> io::Result<()> {
    Ok(())
}
