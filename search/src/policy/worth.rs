//! Whether any path is informative enough to drive, for all policies.

use super::Decision;
use crate::cell::Cell;
use crate::intent::PlannedPrecision;
use crate::route::ShortestPathTree;
use crate::situation::Situation;
use crate::utility::UtilityTable;
use crate::utility_gain::{UtilityGain, saturated};

/// Information above which a path is worth driving, nats: if no score of an information policy is above this, the robot
/// rests.
///
/// An observation that would reveal everything yields this little where its footprint holds an object with a
/// probability of `6e-8` (`H(6e-8) = 1e-6` nats). With the default sensor 2^24 cells, the largest map, are 275,000
/// footprints: the expected number of objects left in all of them is far below the default of
/// `mission.stop_when_expected_remaining`. So that key ends a search, unless it is 0 or cannot be reached. Rounding
/// errors of a score are below the threshold too.
pub const LEAST_NATS: f64 = 1e-6;

impl Decision {
    /// The candidate of the highest score; of equal ones the nearest by path, then the one with the smallest cell
    /// index. Scores have the shape `[cells]`.
    #[must_use]
    pub fn best(routes: &ShortestPathTree, scores: Vec<f64>) -> Self {
        match highest(routes, &scores, routes.candidates().iter().copied()) {
            Some(chosen) => Self { chosen, path: routes.path(chosen), scores },
            None => Self::rest(routes, scores),
        }
    }

    /// Like [`Decision::best`], for scores that are information, nats; the decision is to rest if none is above
    /// [`LEAST_NATS`].
    #[must_use]
    pub fn most_informative(routes: &ShortestPathTree, scores: Vec<f64>) -> Self {
        let best = Self::best(routes, scores);
        if best.scores[best.chosen.index()] > LEAST_NATS { best } else { Self::rest(routes, best.scores) }
    }

    /// The best candidate by scores that are not information, of those whose path is informative: the observations
    /// along it, each taken alone, add up to more than [`LEAST_NATS`]. The decision is to rest if there is none.
    #[must_use]
    pub fn best_of_informative(
        situation: &Situation<'_>,
        routes: &ShortestPathTree,
        scores: Vec<f64>,
    ) -> Self {
        let best = Self::best(routes, scores);
        // Nearly always so, at the cost of one or two observations.
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

    /// The decision of a policy that follows a fixed order; to rest if no path yields information.
    pub(super) fn unless_all_is_known(self, situation: &Situation<'_>, routes: &ShortestPathTree) -> Self {
        let is_anything_left =
            || path_information(situation, routes).iter().any(|&information| information > LEAST_NATS);
        if is_path_informative(situation, &self.path) || is_anything_left() {
            self
        } else {
            Self::rest(routes, self.scores)
        }
    }

    /// The decision to rest.
    pub(super) fn rest(routes: &ShortestPathTree, scores: Vec<f64>) -> Self {
        Self { chosen: routes.root(), path: Vec::new(), scores }
    }

    /// Whether the decision is to rest: the robot stays in its cell.
    #[must_use]
    pub const fn is_rest(&self) -> bool {
        self.path.is_empty()
    }

    /// Whether there was any candidate.
    #[must_use]
    pub fn had_candidates(&self) -> bool {
        self.scores.iter().any(|&score| score > f64::NEG_INFINITY)
    }
}

/// The situation without teammates' plans, for policies that do not use them.
pub(super) fn without_plans<'a>(situation: &Situation<'a>, nothing: &'a PlannedPrecision) -> Situation<'a> {
    Situation { planned_precision: nothing, ..*situation }
}

/// Information of the observations along the path to each candidate, each taken alone, nats, shape `[cells]`; `-inf`
/// for cells that are not candidates. On the tree of shortest paths it is that of the parent cell plus one observation.
pub(super) fn path_information(situation: &Situation<'_>, routes: &ShortestPathTree) -> Vec<f64> {
    let mut information = UtilityGain::information(situation).observation_gains(situation, routes);
    information[routes.root().index()] = 0.0;
    for &cell in routes.candidates() {
        information[cell.index()] += information[routes.parent(cell).index()];
    }
    information[routes.root().index()] = f64::NEG_INFINITY;
    information
}

/// The same of one path, as far as is needed to know.
pub(super) fn is_path_informative(situation: &Situation<'_>, path: &[Cell]) -> bool {
    let mut information = 0.0;
    path.iter().any(|&from| {
        information += observation_information(situation, from);
        information > LEAST_NATS
    })
}

fn observation_information(situation: &Situation<'_>, from: Cell) -> f64 {
    let table = UtilityTable::information();
    let gain = |cell: Cell, look_precision: i64| {
        let row = table.row(situation.belief.log_odds_nats(cell));
        let planned_precision = situation.planned_precision.precision(cell);
        let at = |precision: i64| f64::from(table.utility(row, saturated(precision)));
        at(planned_precision.saturating_add(look_precision)) - at(planned_precision)
    };
    let seen = situation.terrain.in_sight(situation.sensor, from);
    seen.map(|(cell, observation)| gain(cell, observation.precision)).sum()
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
    use crate::terrain::Terrain;

    struct Case {
        terrain: Terrain,
        sensor: Sensor,
        belief: Belief,
        planned_precision: PlannedPrecision,
    }

    impl Case {
        fn new(drawing: &str, log_odds_nats: &[f64]) -> Self {
            let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
            let belief = Belief::from_log_odds(&terrain, log_odds_nats.to_vec()).unwrap();
            let sensor = Sensor::new(1, 0.005, Noise::Gaussian).unwrap();
            Self { planned_precision: PlannedPrecision::nothing(&terrain), terrain, sensor, belief }
        }

        fn decide(&self, name: PolicyName, robot: usize) -> Decision {
            let situation = Situation::alone(
                &self.terrain,
                &self.sensor,
                &self.belief,
                &self.planned_precision,
                self.terrain.grid().cells().nth(robot).unwrap(),
            );
            build(name, Parameters::default()).decide(&situation, &mut stream(1, Purpose::Decision, 1))
        }
    }

    const KNOWN: f64 = -40.0;
    const INFORMED: [PolicyName; 4] =
        [PolicyName::Greedy, PolicyName::PathAdditive, PolicyName::Path, PolicyName::Tour];

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
    fn cells_in_teammates_plans_are_left_to_them_by_policies_that_use_plans() {
        let mut case = Case::new(".....", &[KNOWN, KNOWN, KNOWN, KNOWN, -3.0]);
        let cells: Vec<Cell> = case.terrain.grid().cells().collect();
        case.planned_precision.add_path(&case.terrain, &case.sensor, &cells[4..]);
        for name in PolicyName::ALL {
            assert_eq!(case.decide(name, 0).is_rest(), INFORMED.contains(&name), "{name}");
        }
    }
}
