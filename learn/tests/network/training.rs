//! What is learned with libtorch decides the same in plain Rust.

use dragnet_learn::network::Network;
use dragnet_learn::train::Model;
use tch::Device;

use crate::scene::scenes;
use crate::{SHAPES, TOLERANCE, weights};

#[test]
fn the_network_that_learns_and_the_one_that_decides_are_one() {
    tch::set_num_threads(1);
    for (seed, shape) in (0..).zip(SHAPES) {
        let weights = weights(shape, seed);
        let (network, model) = (Network::new(&weights), Model::of(&weights, Device::Cpu));
        for scene in scenes(seed) {
            let graph = scene.graph();
            let (difference, spread) = worst(&network.logits(&graph), &model.logits_of(&graph));
            assert!(difference < TOLERANCE, "{shape:?}, {}: {difference}", scene.name);
            assert!(spread > 1.0 || graph.topology.len() == 1, "{shape:?}, {}: {spread}", scene.name);
        }
    }
}

/// The largest difference between two lists of logits, and how far apart the first's are.
fn worst(ours: &[f32], theirs: &[f32]) -> (f32, f32) {
    assert_eq!(ours.len(), theirs.len());
    let differences = ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs());
    let most = ours.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let least = ours.iter().copied().fold(f32::INFINITY, f32::min);
    (differences.fold(0.0, f32::max), most - least)
}
