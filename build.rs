//! Sets the commit of the binary, for `--version` and for recordings; if it trains or detects, the library path of
//! libtorch; and lets the linker fold functions of a release, where it can.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let commit = if is_checkout() { git(&["rev-parse", "--short=12", "HEAD"]) } else { None };
    println!("cargo::rustc-env=DRAGNET_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
    if commit.is_some() {
        watch_head();
    }
    if ["CARGO_FEATURE_TRAIN", "CARGO_FEATURE_DETECTOR"].iter().any(|name| std::env::var_os(name).is_some()) {
        point_to_libtorch();
    }
    let is = |key: &str, value: &str| std::env::var(key).is_ok_and(|it| it == value);
    if is("PROFILE", "release") && is("CARGO_CFG_TARGET_ENV", "gnu") && does_link_with(FOLD) {
        println!("cargo::rustc-link-arg-bins={FOLD}");
    }
}

/// Links functions that came out the same once, a tenth of the program; no function is promised an address of its own.
/// The linker that Rust brings for x86-64 can, that of GNU cannot.
const FOLD: &str = "-Wl,--icf=all";

/// Whether a program can be linked with an argument.
fn does_link_with(argument: &str) -> bool {
    let value = |key: &str| std::env::var_os(key).unwrap_or_default();
    let out = std::path::PathBuf::from(value("OUT_DIR"));
    let source = out.join("linked.rs");
    if std::fs::write(&source, "fn main() {}").is_err() {
        return false;
    }
    let mut rustc = Command::new(value("RUSTC"));
    rustc.arg("--target").arg(value("TARGET")).arg(format!("-Clink-arg={argument}"));
    if let Some(linker) = std::env::var_os("RUSTC_LINKER") {
        rustc.arg("-C").arg(format!("linker={}", linker.display()));
    }
    rustc.arg("--out-dir").arg(&out).arg(&source);
    rustc.output().is_ok_and(|output| output.status.success())
}

/// As in `train/build.rs`: the run-time library path is not inherited from a dependency.
fn point_to_libtorch() {
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    if let Some(libtorch) = std::env::var_os("LIBTORCH") {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}/lib", libtorch.display());
    }
}

/// Whether this folder is the root of a checkout, and not just inside another one.
fn is_checkout() -> bool {
    let here = Path::new(".").canonicalize().ok();
    let root = git(&["rev-parse", "--show-toplevel"]).and_then(|root| Path::new(&root).canonicalize().ok());
    here.is_some() && here == root
}

/// `HEAD` changes with the branch, the branch's file and the log of `HEAD` with each commit.
fn watch_head() {
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "logs/HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        // Cargo reruns always if a file is missing.
        if let Some(path) = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
