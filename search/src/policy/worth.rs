//! Whether anything is worth a look: for all policies, whatever they score.

use super::Decision;
use crate::cell::Cell;
use crate::information::InformationTable;
use crate::information_gain::{InformationGain, saturated};
use crate::intent::PlannedPrecision;
use crate::route::ShortestPathTree;
use crate::situation::Situation;

/// What looks must yield to be worth driving for, nats: where no score of a policy that scores information is above this,
/// the robot is to rest.
///
/// A look that would tell all is worth so little where its footprint holds an object with a probability of `6e-8`
/// (`H(6e-8) = 1e-6` nats). With the default sensor 2^24 cells, the largest map, are 275,000 footprints: what is left in
/// all of them is far below the default of `mission.stop_when_expected_remaining`. So it is that key which ends a search, unless it
/// is 0 or cannot be reached. What rounding adds to a score lies below the threshold too.
pub const LEAST_NATS: f64 = 1e-6;

impl Decision {
    /// The candidate of the highest score; of equal ones the nearest by path, and of these the smallest cell index.
    /// Scores have the shape `[cells]`.
    #[must_use]
    pub fn best(routes: &ShortestPathTree, scores: Vec<f64>) -> Self {
        match highest(routes, &scores, routes.candidates().iter().copied()) {
            Some(chosen) => Self { chosen, path: routes.path(chosen), scores },
            None => Self::rest(routes, scores),
        }
    }

    /// The same of scores that are information, nats; to rest if none is above [`LEAST_NATS`].
    #[must_use]
    pub fn most_informative(routes: &ShortestPathTree, scores: Vec<f64>) -> Self {
        let best = Self::best(routes, scores);
        if best.scores[best.chosen.index()] > LEAST_NATS { best } else { Self::rest(routes, best.scores) }
    }

    /// The best, by scores that are no information, of those candidates whose path yields any: the looks along it, each
    /// taken alone, add up to more than [`LEAST_NATS`]. To rest if there is none.
    #[must_use]
    pub fn best_of_informative(
        situation: &Situation<'_>,
        routes: &ShortestPathTree,
        scores: Vec<f64>,
    ) -> Self {
        let best = Self::best(routes, scores);
        // Nearly always so, and at the price of a look or two.
        if is_path_informative(situation, &best.path) {
            return best;
        }
        let information = path_information(situation, routes);
        let informative =
            routes.candidates().iter().copied().filter(|it| information[it.index()] > LEAST_NATS);
        match highest(routes, &best.scores, informative) {
            Some(chosen) => Self { chosen, path: routes.path(chosen), ..best },
            None => Self::rest(routes, best.scores),
        }
    }

    /// The decision of a policy that goes its way whatever there is to be seen; to rest if no path yields information.
    pub(super) fn unless_all_is_known(self, situation: &Situation<'_>, routes: &ShortestPathTree) -> Self {
        let is_anything_left =
            || path_information(situation, routes).iter().any(|&information| information > LEAST_NATS);
        if is_path_informative(situation, &self.path) || is_anything_left() {
            self
        } else {
            Self::rest(routes, self.scores)
        }
    }

    fn rest(routes: &ShortestPathTree, scores: Vec<f64>) -> Self {
        Self { chosen: routes.root(), path: Vec::new(), scores }
    }

    /// Whether the robot is to stay where it is.
    #[must_use]
    pub const fn is_rest(&self) -> bool {
        self.path.is_empty()
    }

    /// Whether there was anywhere to go.
    #[must_use]
    pub fn had_candidates(&self) -> bool {
        self.scores.iter().any(|&score| score > f64::NEG_INFINITY)
    }
}

/// What a policy sees that does not know of its teammates' plans.
pub(super) fn without_promises<'a>(
    situation: &Situation<'a>,
    nothing: &'a PlannedPrecision,
) -> Situation<'a> {
    Situation { promised: nothing, ..*situation }
}

/// Information of the looks along the path to each candidate, each taken alone, nats, shape `[cells]`; `-inf` for cells that
/// are no candidates. On the tree of shortest paths it is that of the cell before plus one look.
pub(super) fn path_information(situation: &Situation<'_>, routes: &ShortestPathTree) -> Vec<f64> {
    let mut information = InformationGain::new(situation).look_gains(situation, routes);
    information[routes.root().index()] = 0.0;
    for &cell in routes.candidates() {
        information[cell.index()] += information[routes.parent(cell).index()];
    }
    information[routes.root().index()] = f64::NEG_INFINITY;
    information
}

/// The same of one path, as far as is needed to know.
fn is_path_informative(situation: &Situation<'_>, path: &[Cell]) -> bool {
    let mut information = 0.0;
    path.iter().any(|&from| {
        information += look_information(situation, from);
        information > LEAST_NATS
    })
}

fn look_information(situation: &Situation<'_>, from: Cell) -> f64 {
    let (table, grid) = (InformationTable::shared(), situation.terrain.grid());
    let gain = |(cell, look_precision): (Cell, i64)| {
        let row = table.row(situation.belief.log_odds_nats(cell));
        let promised = situation.promised.precision(cell);
        let at = |precision: i64| f64::from(table.information(row, saturated(precision)));
        at(promised.saturating_add(look_precision)) - at(promised)
    };
    let seen = situation.sensor.footprint().iter();
    seen.filter_map(|look| Some((grid.step(from, look.offset)?, look.precision))).map(gain).sum()
}

fn highest(
    routes: &ShortestPathTree,
    scores: &[f64],
    candidates: impl Iterator<Item = Cell>,
) -> Option<Cell> {
    candidates.max_by(|&a, &b| {
        let by_score = scores[a.index()].total_cmp(&scores[b.index()]);
        by_score.then_with(|| routes.length(b).total_cmp(&routes.length(a))).then(b.cmp(&a))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::Belief;
    use crate::policy::{Parameters, PolicyName, build};
    use crate::route::Connectivity;
    use crate::seed::{Purpose, stream};
    use crate::sensor::{Noise, Sensor};
    use crate::situation::Place;
    use crate::terrain::Terrain;

    struct Case {
        terrain: Terrain,
        sensor: Sensor,
        belief: Belief,
        promised: PlannedPrecision,
    }

    impl Case {
        fn new(drawing: &str, log_odds_nats: &[f64]) -> Self {
            let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
            let belief = Belief::from_log_odds(&terrain, log_odds_nats.to_vec()).unwrap();
            let sensor = Sensor::new(1, 0.005, Noise::Gaussian).unwrap();
            Self { promised: PlannedPrecision::nothing(&terrain), terrain, sensor, belief }
        }

        fn decide(&self, name: PolicyName, robot: usize) -> Decision {
            let situation = Situation {
                terrain: &self.terrain,
                connectivity: Connectivity::Four,
                sensor: &self.sensor,
                belief: &self.belief,
                promised: &self.promised,
                robot: self.terrain.grid().cells().nth(robot).unwrap(),
                place: Place::ALONE,
            };
            build(name, Parameters::default()).decide(&situation, &mut stream(1, Purpose::Decision, 1))
        }
    }

    const KNOWN: f64 = -40.0;
    const INFORMED: [PolicyName; 3] = [PolicyName::Greedy, PolicyName::PathAdditive, PolicyName::Path];

    #[test]
    fn of_equal_scores_the_nearest_wins_and_then_the_smallest_index() {
        let terrain = Terrain::from_ascii(".....\n.....\n", 1.0).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let routes = ShortestPathTree::from(&terrain, Connectivity::Four, cells[2]);
        let best = |equal: &[usize]| {
            let mut scores = vec![-1.0; cells.len()];
            for &place in equal {
                scores[place] = 1.0;
            }
            Decision::best(&routes, scores).chosen.index()
        };
        assert_eq!(best(&[0, 3]), 3, "the nearer");
        assert_eq!(best(&[1, 3, 7]), 1, "the smallest of equally near ones");
        assert_eq!(best(&[0, 4, 9]), 0);
    }

    #[test]
    fn where_nothing_is_left_every_policy_rests() {
        let case = Case::new(".....", &[KNOWN; 5]);
        for name in PolicyName::ALL {
            let decision = case.decide(name, 2);
            assert!(decision.is_rest() && decision.had_candidates(), "{name}: {decision:?}");
            assert_eq!(decision.chosen.index(), 2, "{name}");
        }
    }

    #[test]
    fn a_cell_in_doubt_at_the_far_end_wakes_every_policy() {
        let case = Case::new(".........", &[KNOWN, KNOWN, KNOWN, KNOWN, KNOWN, KNOWN, KNOWN, KNOWN, -9.0]);
        for name in PolicyName::ALL {
            assert!(!case.decide(name, 0).is_rest(), "{name}");
        }
        // These go where there is something to be seen; the look reaches one cell.
        for name in INFORMED.into_iter().chain([PolicyName::Nats, PolicyName::Guts]) {
            assert!(case.decide(name, 0).chosen.index() >= 7, "{name}");
        }
    }

    #[test]
    fn what_teammates_promise_is_left_to_them_by_those_who_know_their_plans() {
        let mut case = Case::new(".....", &[KNOWN, KNOWN, KNOWN, KNOWN, -3.0]);
        let cells: Vec<Cell> = case.terrain.grid().cells().collect();
        case.promised.add_path(&case.terrain, &case.sensor, &cells[4..]);
        for name in PolicyName::ALL {
            assert_eq!(case.decide(name, 0).is_rest(), INFORMED.contains(&name), "{name}");
        }
    }
}
