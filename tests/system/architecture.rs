//! The imports of `ARCHITECTURE.md`: an import may only follow its arrows.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{CargoOpt, DependencyKind, Metadata, MetadataCommand, Package, PackageId};

/// Each crate, and the workspace's crates that it may import.
const ARROWS: [(&str, &[&str]); 24] = [
    ("dragnet-search", &[]),
    ("dragnet-files", &[]),
    ("dragnet-learn", &["dragnet-search", "dragnet-files"]),
    ("dragnet-train", &["dragnet-search", "dragnet-files", "dragnet-learn"]),
    ("dragnet-scenario", &["dragnet-search", "dragnet-files", "dragnet-learn"]),
    ("dragnet-ros2", &["dragnet-search", "dragnet-scenario"]),
    ("dragnet-proto", &["dragnet-search", "dragnet-scenario", "dragnet-ros2"]),
    ("dragnet-keys", &["dragnet-search", "dragnet-files", "dragnet-scenario", "dragnet-proto"]),
    ("dragnet-agent", &["dragnet-search", "dragnet-learn", "dragnet-scenario", "dragnet-proto"]),
    (
        "dragnet-coordinator",
        &["dragnet-search", "dragnet-files", "dragnet-scenario", "dragnet-ros2", "dragnet-proto"],
    ),
    (
        "dragnet-sim",
        &[
            "dragnet-search",
            "dragnet-learn",
            "dragnet-scenario",
            "dragnet-proto",
            "dragnet-agent",
            "dragnet-lattice",
            "dragnet-vehicle",
        ],
    ),
    ("dragnet-lattice", &["dragnet-search"]),
    ("dragnet-vehicle", &["dragnet-search", "dragnet-lattice"]),
    ("dragnet-detector", &["dragnet-lattice", "dragnet-vehicle"]),
    ("dragnet-mavlink", &["dragnet-vehicle"]),
    ("dragnet-export", &["dragnet-search", "dragnet-scenario", "dragnet-proto", "dragnet-coordinator"]),
    (
        "dragnet-experiments",
        &[
            "dragnet-search",
            "dragnet-files",
            "dragnet-learn",
            "dragnet-scenario",
            "dragnet-proto",
            "dragnet-agent",
            "dragnet-sim",
        ],
    ),
    ("dragnet-planning", &["dragnet-search", "dragnet-files", "dragnet-scenario"]),
    (
        "dragnet-live",
        &[
            "dragnet-search",
            "dragnet-files",
            "dragnet-scenario",
            "dragnet-planning",
            "dragnet-proto",
            "dragnet-coordinator",
        ],
    ),
    (
        "dragnet-runtime",
        &[
            "dragnet-search",
            "dragnet-files",
            "dragnet-scenario",
            "dragnet-ros2",
            "dragnet-proto",
            "dragnet-agent",
            "dragnet-coordinator",
            "dragnet-export",
            "dragnet-sim",
            "dragnet-live",
            "dragnet-lattice",
            "dragnet-vehicle",
            "dragnet-mavlink",
        ],
    ),
    ("stabby", &[]),
    ("tls-listener", &[]),
    (
        "dragnet-python",
        &[
            "dragnet-search",
            "dragnet-learn",
            "dragnet-scenario",
            "dragnet-proto",
            "dragnet-coordinator",
            "dragnet-sim",
            "dragnet-experiments",
        ],
    ),
    (
        "dragnet",
        &[
            "dragnet-search",
            "dragnet-files",
            "dragnet-learn",
            "dragnet-train",
            "dragnet-scenario",
            "dragnet-ros2",
            "dragnet-proto",
            "dragnet-keys",
            "dragnet-agent",
            "dragnet-coordinator",
            "dragnet-sim",
            "dragnet-vehicle",
            "dragnet-detector",
            "dragnet-export",
            "dragnet-experiments",
            "dragnet-planning",
            "dragnet-live",
            "dragnet-runtime",
        ],
    ),
];

/// Crates that only the edges may use.
const EDGES: [(&str, &[&str]); 13] = [
    ("zenoh", &["dragnet-runtime"]),
    ("tokio", &["dragnet-runtime", "dragnet-live", "tls-listener"]),
    ("axum", &["dragnet-live"]),
    ("mcap", &["dragnet-coordinator"]),
    ("clap", &["dragnet"]),
    ("console", &["dragnet"]),
    ("indicatif", &["dragnet"]),
    ("rcgen", &["dragnet-keys"]),
    ("tch", &["dragnet-train", "dragnet-detector"]),
    ("rten", &["dragnet-detector"]),
    ("pyo3", &["dragnet-python"]),
    ("numpy", &["dragnet-python"]),
    ("mavlink", &["dragnet-mavlink"]),
];

/// libtorch and its bindings, which only training and the detector need.
const TORCH: [&str; 2] = ["tch", "torch-sys"];

fn command() -> MetadataCommand {
    let mut command = MetadataCommand::new();
    command.manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
    command
}

/// Every dependency, those of features that are off by default too.
fn everything() -> Metadata {
    command().features(CargoOpt::AllFeatures).exec().unwrap()
}

fn packages() -> BTreeMap<String, Package> {
    let metadata = command().no_deps().exec().unwrap();
    metadata.packages.into_iter().map(|package| (package.name.to_string(), package)).collect()
}

fn imports(package: &Package) -> BTreeSet<&str> {
    let is_import = |kind: DependencyKind| kind == DependencyKind::Normal;
    package
        .dependencies
        .iter()
        .filter(|dependency| is_import(dependency.kind))
        .map(|dependency| dependency.name.as_str())
        .collect()
}

#[test]
fn crates_import_only_along_the_arrows() {
    let packages = packages();
    let known: BTreeSet<&str> = ARROWS.iter().map(|(name, _)| *name).collect();
    assert_eq!(packages.keys().map(String::as_str).collect::<BTreeSet<_>>(), known);
    for (name, allowed) in ARROWS {
        for import in imports(&packages[name]).iter().filter(|import| known.contains(**import)) {
            assert!(allowed.contains(import), "{name} must not import {import}");
        }
    }
}

#[test]
fn only_the_edges_touch_network_files_terminal_and_libtorch() {
    for (name, package) in &packages() {
        for import in imports(package) {
            let edge = EDGES.iter().find(|(edge, _)| *edge == import);
            assert!(
                edge.is_none_or(|(_, users)| users.contains(&name.as_str())),
                "{name} must not use {import}"
            );
        }
    }
}

/// Names of the packages that import one of this name.
fn importers<'a>(metadata: &'a Metadata, name: &str) -> Vec<&'a str> {
    let name_of = |id: &PackageId| metadata[id].name.as_str();
    let nodes = &metadata.resolve.as_ref().unwrap().nodes;
    let imports = nodes.iter().filter(|node| node.dependencies.iter().any(|import| name_of(import) == name));
    imports.map(|node| name_of(&node.id)).collect()
}

/// Names of the packages that a package is built from, itself among them.
fn built_from<'a>(metadata: &'a Metadata, name: &str) -> BTreeSet<&'a str> {
    let nodes = &metadata.resolve.as_ref().unwrap().nodes;
    let nodes: BTreeMap<&PackageId, _> = nodes.iter().map(|node| (&node.id, node)).collect();
    let mut waiting: Vec<&PackageId> =
        metadata.packages.iter().filter(|package| *package.name == name).map(|package| &package.id).collect();
    let mut reached: BTreeSet<&PackageId> = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        if reached.insert(id) {
            waiting.extend(&nodes[id].dependencies);
        }
    }
    reached.into_iter().map(|id| metadata[id].name.as_str()).collect()
}

#[test]
fn libtorch_comes_with_the_features_train_and_detector_and_only_with_them() {
    let default = command().exec().unwrap();
    let program = built_from(&default, "dragnet");
    assert!(program.len() > 200);
    assert!(TORCH.iter().all(|torch| !program.contains(torch)), "libtorch is in the default build");
    for feature in ["train", "detector"] {
        let with = command().features(CargoOpt::SomeFeatures(vec![feature.to_owned()])).exec().unwrap();
        assert!(TORCH.iter().all(|torch| built_from(&with, "dragnet").contains(torch)), "{feature}");
    }
    // Static programs read networks without it.
    let onnx = command().features(CargoOpt::SomeFeatures(vec!["onnx".to_owned()])).exec().unwrap();
    let program = built_from(&onnx, "dragnet");
    assert!(program.contains("rten") && TORCH.iter().all(|torch| !program.contains(torch)));
    let all = everything();
    assert_eq!(importers(&all, "torch-sys"), ["tch"]);
    assert_eq!(importers(&all, "tch"), ["dragnet-detector", "dragnet-train"]);
    for name in ["dragnet-train", "dragnet-detector"] {
        assert_eq!(importers(&all, name), ["dragnet"]);
    }
}

#[test]
fn python_brings_neither_a_network_nor_libtorch() {
    let all = everything();
    let python = built_from(&all, "dragnet-python");
    assert!(python.contains("pyo3") && python.contains("dragnet-sim"));
    assert!(["zenoh", "tokio", "tch"].iter().all(|edge| !python.contains(edge)));
}

/// `cargo deny check licenses` checks this too; `deny.toml` is the one list.
#[test]
fn every_dependency_has_a_license_that_deny_toml_allows() {
    let root = env!("CARGO_MANIFEST_DIR");
    let deny: toml::Table = std::fs::read_to_string(format!("{root}/deny.toml")).unwrap().parse().unwrap();
    let licenses = deny["licenses"].as_table().unwrap();
    let list = |value: &toml::Value| -> Vec<String> {
        value.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let general = list(&licenses["allow"]);
    let metadata = everything();
    assert!(metadata.packages.len() > 200);
    for package in metadata.packages.iter().filter(|package| package.source.is_some()) {
        let mut allowed = general.clone();
        for exception in licenses["exceptions"].as_array().unwrap() {
            if exception["crate"].as_str() == Some(package.name.as_str()) {
                allowed.extend(list(&exception["allow"]));
            }
        }
        let license = package.license.as_deref().unwrap_or_default();
        let expression = spdx::Expression::parse_mode(license, spdx::ParseMode::LAX);
        let is_allowed = expression.is_ok_and(|expression| {
            expression.evaluate(|requirement| allowed.contains(&requirement.to_string()))
        });
        assert!(is_allowed, "{} {}: license {license:?}", package.name, package.version);
    }
}
