//! The network's input, on maps drawn in ASCII.

use dragnet_learn::graph::{FEATURE_NAMES, FEATURES};
use dragnet_search::cell::Position;
use dragnet_search::terrain::Terrain;

use crate::scene::{Scene, scenes};

const SOUTH_WEST: Position = Position { row: 0, column: 0 };

#[test]
fn neighbors_touch_corners_included_and_a_corner_is_farther() {
    let terrain = Terrain::from_ascii("..#\n.#.\n...\n", 30.0).unwrap();
    let graph = Scene::by_hand(terrain, SOUTH_WEST, vec![0.0; 9], &[]).graph();
    let numbers: Vec<u32> = graph.topology.cells().iter().map(|cell| cell.number()).collect();
    assert_eq!(numbers, [0, 1, 2, 3, 5, 6, 7]);
    let check = |cell: u32, expected: &[(u32, f32)]| {
        let node = numbers.iter().position(|&number| number == cell).unwrap();
        let edges = graph.topology.edges(node).iter();
        let found: Vec<_> = edges.map(|edge| (numbers[edge.node as usize], edge.inverse_distance)).collect();
        assert_eq!(found, expected, "neighbors of cell {cell}");
    };
    let corner = 0.5_f32.sqrt();
    // An edge may lead across a corner that no robot cuts.
    check(0, &[(1, 1.0), (3, 1.0)]);
    check(1, &[(0, 1.0), (2, 1.0), (3, corner), (5, corner)]);
    check(2, &[(1, 1.0), (5, 1.0)]);
    check(5, &[(1, corner), (2, 1.0), (7, corner)]);
    check(7, &[(3, corner), (5, corner), (6, 1.0)]);
}

#[test]
fn features_match_their_names() {
    let terrain = Terrain::from_ascii("......\n", 30.0).unwrap();
    let log_odds_nats = vec![0.0, 1.0, -1.0, 12.0, f64::NEG_INFINITY, -3.0];
    let plan = [terrain.grid().cell(SOUTH_WEST).unwrap()];
    let graph = Scene::by_hand(terrain, SOUTH_WEST, log_odds_nats, &plan).graph();
    let find = |name: &str| -> [f64; 6] {
        let place = FEATURE_NAMES.iter().position(|known| *known == name).unwrap();
        std::array::from_fn(|node| f64::from(graph.features[node * FEATURES + place]))
    };
    let check = |name: &str, expected: [f64; 6]| {
        let found = find(name);
        let is_close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5);
        assert!(is_close, "{name}: {found:?} instead of {expected:?}");
    };
    check("probability", [0.5, 0.731_059, 0.268_941, 0.999_994, 0.0, 0.047_426]);
    check("log_odds", [0.0, 0.125, -0.125, 1.0, -1.0, -0.375]);
    check("entropy", [1.0, 0.839_942, 0.839_942, 0.000_115, 0.0, 0.275_360]);
    let by_length = |feature: fn(f64) -> f64| [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(feature);
    check("log_path_length", by_length(|length| (1.0 + length).ln() / 4.0));
    check("log_path_weight", by_length(|length| (1.0 + length / 5.0).ln() / 3.0));
    check("robot", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    check("openness", [0.125, 0.25, 0.25, 0.25, 0.25, 0.125]);
    // 1 / v(d) of the sensor: 1000 in the cell itself, then 200 / d^2.
    check("planned_precision", [0.990_099, 0.952_381, 0.833_333, 0.689_655, 0.555_556, 0.444_444]);
    let gains = find("information_gain");
    assert!(gains[0] <= 0.0 && gains.iter().filter(|&&gain| gain >= 1.0).count() == 1, "{gains:?}");
    check("log_information_gain", gains.map(|gain| 1.0 - (gain + 1e-4).ln() / 1e-4_f64.ln()));
}

#[test]
fn a_graph_of_any_scene_is_sound() {
    for scene in (0..10).flat_map(scenes) {
        let graph = scene.graph();
        let nodes = graph.topology.len();
        assert_eq!((graph.features.len(), graph.parent.len()), (nodes * FEATURES, nodes));
        assert!(graph.features.iter().all(|feature| (-1.0..=2.0).contains(feature)), "{}", scene.name);
        assert_eq!(graph.topology.cells()[graph.root as usize], scene.robot);
        assert_eq!((graph.order[0], graph.parent[graph.root as usize]), (graph.root, graph.root));
        let routes = scene.routes();
        for (&cell, &parent) in graph.topology.cells().iter().zip(&graph.parent) {
            assert_eq!(graph.topology.cells()[parent as usize], routes.parent(cell), "{}", scene.name);
        }
        let mut seen = vec![false; nodes];
        for &node in &graph.order {
            let is_known = seen[graph.parent[node as usize] as usize];
            assert!(is_known || node == graph.root, "{}: a child before its parent", scene.name);
            assert!(!std::mem::replace(&mut seen[node as usize], true));
        }
        assert!(seen.iter().all(|&seen| seen));
        for node in 0..nodes {
            for edge in graph.topology.edges(node) {
                let back = graph.topology.edges(edge.node as usize).iter();
                assert_eq!(back.filter(|back| back.node as usize == node).count(), 1, "{}", scene.name);
            }
        }
    }
}
