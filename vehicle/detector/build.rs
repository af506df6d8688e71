//! Sets the library path of libtorch for tests; programs above this crate have to set it themselves, as
//! `../../build.rs` does.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    let libtorch = std::env::var_os("CARGO_FEATURE_TORCH").and_then(|_| std::env::var_os("LIBTORCH"));
    if let Some(libtorch) = libtorch {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}/lib", libtorch.display());
    }
}
