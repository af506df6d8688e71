//! Landmarks: groups of neighboring targets that are far from each other to drive.

use dragnet_scenario::Scenario;
use dragnet_search::route::ShortestPathTree;

use super::board::Board;

/// The most landmarks, and the most states of walks with them.
const MAX_COUNT: usize = 8;
const MAX_STATES: usize = 1 << 19;

/// As many as can be told apart with this many nodes of walks: each as far as possible from all before, the first from
/// the middle of the map.
pub(super) fn landmarks(scenario: &Scenario, board: &Board, nodes: usize) -> Vec<Vec<u16>> {
    let (terrain, connectivity) = (scenario.terrain(), scenario.connectivity());
    let count = (0..=MAX_COUNT).rfind(|&count| nodes << count <= MAX_STATES).unwrap_or(0);
    let lengths = |from: usize| -> Vec<f32> {
        let routes = ShortestPathTree::from(terrain, connectivity, board.positions[from]);
        // Positions that are not connected are no landmarks of each other.
        let length = |&cell| Some(routes.length(cell)).filter(|it| it.is_finite()).unwrap_or(0.0);
        board.positions.iter().map(length).collect()
    };
    let farthest = |lengths: &[f32]| {
        let length = |&at: &usize| lengths[at];
        (0..lengths.len()).max_by(|a, b| length(a).total_cmp(&length(b)).then(b.cmp(a)))
    };
    let eccentricity = |at: &usize| lengths(*at).into_iter().fold(0.0, f32::max);
    let middle = (0..board.positions.len()).min_by(|a, b| eccentricity(a).total_cmp(&eccentricity(b)));
    let Some(mut distances) = middle.map(lengths) else { return Vec::new() };
    let mut is_taken = vec![false; board.targets.len()];
    let mut landmarks = Vec::new();
    while landmarks.len() < count {
        let Some(at) = farthest(&distances) else { break };
        let near = board.near(at, scenario.widest_sensor().radius() / 2);
        landmarks.push(
            near.into_iter().filter(|&it| !std::mem::replace(&mut is_taken[usize::from(it)], true)).collect(),
        );
        let from = lengths(at);
        if landmarks.len() == 1 {
            distances = from;
        } else {
            distances.iter_mut().zip(from).for_each(|(distance, length)| *distance = distance.min(length));
        }
    }
    landmarks
}
