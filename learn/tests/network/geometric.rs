//! `torch_geometric` computes the same logits from the same graphs and weights.

use std::collections::BTreeMap;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use dragnet_learn::graph::{FEATURES, Graph};
use dragnet_learn::network::{Network, Workspace};
use dragnet_learn::shape::Shape;
use dragnet_search::route::Connectivity;
use dragnet_search::seed::{Purpose, stream};
use safetensors::Dtype;
use safetensors::tensor::TensorView;
use serde::Deserialize;
use tempfile::tempdir;

use crate::interpreter::interpreter;
use crate::scene::{Scene, open, scenes};
use crate::{SHAPES, TOLERANCE, weights};

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/network/geometric.py");

/// Timed passes, of which the median is taken.
const PASSES: usize = 51;

/// The script's results for one graph.
#[derive(Deserialize)]
struct Found {
    difference: f32,
    spread: f32,
    seconds: f64,
    attention_seconds: f64,
}

fn check_with_python(folder: &Path) -> BTreeMap<String, Found> {
    let output = Command::new(interpreter(Path::new(WORKSPACE))).arg(SCRIPT).arg(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Type, shape and bytes of a tensor.
type Values = (Dtype, Vec<usize>, Vec<u8>);

/// A graph and its logits, as the script reads them.
fn write(path: &Path, graph: &Graph, logits: &[f32]) {
    let nodes = graph.topology.len();
    let edges_to = |target: usize| graph.topology.edges(target).iter().map(move |edge| (edge, target));
    let edges: Vec<_> = (0..nodes).flat_map(edges_to).collect();
    let inverse_distance: Vec<f32> = edges.iter().map(|(edge, _)| edge.inverse_distance).collect();
    let floats = |shape: &[usize], values: &[f32]| {
        (Dtype::F32, shape.to_vec(), values.iter().flat_map(|value| value.to_le_bytes()).collect())
    };
    let numbers = |values: Vec<u32>| {
        let bytes = values.iter().flat_map(|&value| u64::from(value).to_le_bytes());
        (Dtype::I64, vec![values.len()], bytes.collect())
    };
    let tensors: [(&str, Values); 7] = [
        ("features", floats(&[nodes, FEATURES], &graph.features)),
        ("logits", floats(&[nodes], logits)),
        ("inverse_distance", floats(&[edges.len()], &inverse_distance)),
        ("source", numbers(edges.iter().map(|(edge, _)| edge.node).collect())),
        ("target", numbers(edges.iter().map(|&(_, target)| u32::try_from(target).unwrap()).collect())),
        ("parent", numbers(graph.parent.clone())),
        ("root", numbers(vec![graph.root])),
    ];
    let views = tensors
        .iter()
        .map(|(name, (dtype, shape, bytes))| (*name, TensorView::new(*dtype, shape.clone(), bytes).unwrap()));
    fs::write(path, safetensors::serialize(views, None).unwrap()).unwrap();
}

fn median_seconds(network: &Network, graph: &Graph) -> f64 {
    let mut workspace = Workspace::default();
    let seconds = || {
        let start = Instant::now();
        black_box(network.logits_in(black_box(graph), &mut workspace));
        start.elapsed().as_secs_f64()
    };
    let mut seconds: Vec<f64> = std::iter::repeat_with(seconds).take(PASSES).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[PASSES / 2]
}

/// Prints how long both take, too: `cargo test --release -p dragnet-learn --test network geometric -- --nocapture`.
#[test]
fn pytorch_geometric_computes_the_same_logits() {
    let folder = tempdir().unwrap();
    let mut ours = BTreeMap::new();
    for (number, shape) in (0..).zip(SHAPES) {
        let weights = weights(shape, number);
        let network = Network::new(&weights);
        let file = folder.path().join(format!("{number}.weights.safetensors"));
        fs::write(file, weights.to_bytes().unwrap()).unwrap();
        for (place, scene) in scenes(number).into_iter().chain(scenes_to_time(shape)).enumerate() {
            let (name, graph) = (format!("{number}.{place}"), scene.graph());
            let file = folder.path().join(format!("{name}.graph.safetensors"));
            write(&file, &graph, &network.logits(&graph));
            let seconds = median_seconds(&network, &graph);
            ours.insert(name, (format!("{shape:?}, {}", scene.name), graph.topology.len(), seconds));
        }
    }
    let theirs = check_with_python(folder.path());
    assert!(theirs.keys().eq(ours.keys()));
    for (found, (name, nodes, seconds)) in theirs.values().zip(ours.values()) {
        assert!(found.difference < TOLERANCE, "{name}: {}", found.difference);
        assert!(found.spread > 1.0 || *nodes == 1, "{name}: {}", found.spread);
        println!(
            "{name}: {:.1e} apart; {:.2} ms; PyTorch Geometric {:.2} ms, {:.1} times that; {:.2} ms of it attention",
            found.difference,
            1e3 * seconds,
            1e3 * found.seconds,
            found.seconds / seconds,
            1e3 * found.attention_seconds,
        );
    }
}

/// Maps of the sizes that the paper searches, for the shape that the shipped networks have.
fn scenes_to_time(shape: Shape) -> Vec<Scene> {
    let sides: &[u32] = if shape == Shape::DEFAULT { &[30, 60] } else { &[] };
    let mut random = stream(0, Purpose::Map, 1);
    sides.iter().map(|&side| open(side, Connectivity::Four, &mut random)).collect()
}
