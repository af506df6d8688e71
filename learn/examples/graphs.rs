//! Writes demonstrations as graphs, which `train/gpu/train.py` learns from:
//!
//! ```sh
//! cargo run --release -p dragnet-learn --example graphs -- DEMONSTRATIONS FILE.safetensors [WEIGHTS]
//! ```
//!
//! With weights, the logits that this program computes stand beside them.
//!
//! All decisions of a folder stand one after another in one file. A tensor over nodes or edges counts them through from
//! the first decision to the last; numbers of nodes are within their graph, and 65535 stands for none.

use std::error::Error;
use std::path::Path;

use dragnet_learn::demonstration::{Demonstration, Folder, Trajectory};
use dragnet_learn::graph::{COARSE_NEIGHBORS, Edges, Graph, Memory, NEIGHBORS};
use dragnet_learn::network::Network;
use dragnet_learn::shape::Shape;
use dragnet_learn::weights::Weights;
use dragnet_search::route::ShortestPathTree;
use safetensors::tensor::{Dtype, TensorView};

/// No node.
const NONE: u16 = u16::MAX;

/// A tensor that grows by a row at a time.
struct Column {
    name: String,
    dtype: Dtype,
    width: usize,
    bytes: Vec<u8>,
}

#[derive(Default)]
struct Table(Vec<Column>);

impl Table {
    fn column(&mut self, name: &str, dtype: Dtype, width: usize) -> &mut Vec<u8> {
        let place = self.0.iter().position(|column| column.name == name).unwrap_or_else(|| {
            self.0.push(Column { name: name.to_owned(), dtype, width, bytes: Vec::new() });
            self.0.len() - 1
        });
        &mut self.0[place].bytes
    }

    fn floats(&mut self, name: &str, width: usize, values: &[f32]) {
        self.column(name, Dtype::F32, width).extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }

    fn numbers(&mut self, name: &str, width: usize, values: impl IntoIterator<Item = u32>) {
        let values = values.into_iter().map(|value| u16::try_from(value).unwrap_or(NONE));
        self.column(name, Dtype::U16, width).extend(values.flat_map(u16::to_le_bytes));
    }

    /// Neighbors of each node, and whether they lie straight ahead.
    fn edges(&mut self, name: &str, edges: &Edges, nodes: usize, width: usize) {
        for node in 0..nodes {
            let edges = edges.of(node);
            let none = std::iter::repeat_n(u32::MAX, width - edges.len());
            self.numbers(&format!("{name}.neighbors"), width, edges.iter().map(|it| it.node).chain(none));
            let straight = edges.iter().map(|it| u8::from(it.inverse_distance > 0.9));
            let none = std::iter::repeat_n(0, width - edges.len());
            self.column(&format!("{name}.straight"), Dtype::U8, width).extend(straight.chain(none));
        }
    }

    fn decision(
        &mut self,
        trajectory: &Trajectory,
        decision: &Demonstration,
        memory: &mut Memory,
        network: Option<&Network>,
    ) -> Option<()> {
        let belief = trajectory.belief(decision)?;
        let situation = trajectory.situation(decision, &belief);
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let graph = Graph::of_shape(Shape::PLANNING, &situation, &routes, memory);
        let nodes = graph.topology.len();
        let scores: Vec<f32> =
            graph.topology.cells().iter().map(|cell| decision.scores[cell.index()]).collect();
        if nodes >= NONE as usize || !scores.iter().any(|score| score.is_finite()) {
            return None;
        }
        self.numbers("nodes", 1, [u32::try_from(nodes).ok()?]);
        if let Some(network) = network {
            self.floats("logits", 1, &network.logits(&graph));
        }
        self.numbers("root", 1, [graph.root]);
        self.floats("scores", 1, &scores);
        self.floats("features", Shape::PLANNING.features(), &graph.features);
        self.numbers("parent", 1, graph.parent.iter().copied());
        self.edges("0", graph.topology.edge_lists(), nodes, NEIGHBORS);
        for (number, level) in (1..).zip(&graph.levels) {
            self.numbers(&format!("{number}.nodes"), 1, [u32::try_from(level.len()).ok()?]);
            self.numbers(&format!("{number}.piece"), 1, level.piece.iter().copied());
            self.floats(&format!("{number}.size"), 1, &level.size);
            self.edges(&number.to_string(), &level.edges, level.len(), COARSE_NEIGHBORS);
        }
        Some(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (demonstrations, file, weights) = match arguments.as_slice() {
        [demonstrations, file] => (demonstrations, file, None),
        [demonstrations, file, weights] => (demonstrations, file, Some(weights)),
        _ => return Err("usage: graphs DEMONSTRATIONS FILE.safetensors [WEIGHTS]".into()),
    };
    let weights = weights.map(|path| Weights::load(Path::new(path))).transpose()?;
    let network = weights.as_ref().map(Network::new);
    let folder = Folder::open(Path::new(demonstrations))?;
    let mut table = Table::default();
    let mut memory = Memory::default();
    for trajectory in folder.trajectories() {
        let trajectory = trajectory?;
        for decision in &trajectory.decisions {
            let _ = table.decision(&trajectory, decision, &mut memory, network.as_ref());
        }
    }
    let views = table.0.iter().map(|column| {
        let size = match column.dtype {
            Dtype::F32 => 4,
            Dtype::U16 => 2,
            _ => 1,
        };
        let shape = vec![column.bytes.len() / size / column.width, column.width];
        Ok((column.name.as_str(), TensorView::new(column.dtype, shape, &column.bytes)?))
    });
    let views: Vec<_> = views.collect::<Result<_, safetensors::SafeTensorError>>()?;
    std::fs::write(file, safetensors::serialize(views, None)?)?;
    Ok(())
}
