//! The house stands as `ARCHITECTURE.md` draws it: an import may only follow its arrows.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, MetadataCommand, Package};

/// Each crate, and the crates of ours that it may import.
const ARROWS: [(&str, &[&str]); 7] = [
    ("dragnet-search", &[]),
    ("dragnet-proto", &["dragnet-search"]),
    ("dragnet-agent", &["dragnet-search", "dragnet-proto"]),
    ("dragnet-coordinator", &["dragnet-search", "dragnet-proto"]),
    ("dragnet-sim", &["dragnet-search", "dragnet-proto", "dragnet-agent"]),
    (
        "dragnet-link",
        &["dragnet-search", "dragnet-proto", "dragnet-agent", "dragnet-coordinator", "dragnet-sim"],
    ),
    (
        "dragnet",
        &[
            "dragnet-search",
            "dragnet-proto",
            "dragnet-agent",
            "dragnet-coordinator",
            "dragnet-sim",
            "dragnet-link",
        ],
    ),
];

/// Crates that only the edges may use.
const EDGES: [(&str, &[&str]); 4] = [
    ("zenoh", &["dragnet-link"]),
    ("tokio", &["dragnet-link"]),
    ("mcap", &["dragnet-coordinator"]),
    ("clap", &["dragnet"]),
];

fn packages() -> BTreeMap<String, Package> {
    let metadata = MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .no_deps()
        .exec()
        .unwrap();
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
fn only_the_edges_touch_network_files_and_terminal() {
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

/// What `cargo deny check licenses` asks for too, without that tool: `deny.toml` is the one list.
#[test]
fn every_dependency_has_a_licence_that_deny_toml_allows() {
    let root = env!("CARGO_MANIFEST_DIR");
    let deny: toml::Table = std::fs::read_to_string(format!("{root}/deny.toml")).unwrap().parse().unwrap();
    let licenses = deny["licenses"].as_table().unwrap();
    let list = |value: &toml::Value| -> Vec<String> {
        value.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let general = list(&licenses["allow"]);
    let metadata = MetadataCommand::new().manifest_path(format!("{root}/Cargo.toml")).exec().unwrap();
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
        assert!(is_allowed, "{} {}: licence {license:?}", package.name, package.version);
    }
}
