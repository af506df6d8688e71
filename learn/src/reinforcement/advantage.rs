//! Which decisions made a search shorter.

use super::Visit;

/// What each decision of a search saved, cells, compared with what `tour` expected before it: the generalized advantage
/// of Schulman et al. (ICLR 2016, Eq. 16) without discount, where the critic is the expert's cost to go, as in Sun,
/// Bagnell and Boots (ICLR 2018). With `trace` 0 a decision answers only for the path to its waypoint, which is to imitate `tour`;
/// with 1 for all of the search that followed; between them, for a share `trace` less with each decision.
#[must_use]
pub fn advantages(visits: &[Visit], trace: f64) -> Vec<f64> {
    let mut advantages = vec![0.0; visits.len()];
    let mut later = 0.0;
    for (place, visit) in visits.iter().enumerate().rev() {
        let after = visits.get(place + 1).map_or(0.0, |next| next.to_go.expected_cells);
        let saved = visit.to_go.expected_cells - cost(visits, place) - after;
        later = saved + trace * later;
        advantages[place] = later;
    }
    advantages
}

/// Expected length of a search until nothing is left, cells, by what was believed along it.
#[must_use]
pub fn expected_cells(visits: &[Visit]) -> f64 {
    (0..visits.len()).map(|place| cost(visits, place)).sum()
}

/// Expected length of the way that follows a decision, cells: that it is driven at all takes that an object is left,
/// whose probability is taken to fall evenly along the way.
fn cost(visits: &[Visit], place: usize) -> f64 {
    let visit = &visits[place];
    let after = visits.get(place + 1).map_or(0.0, |next| next.to_go.unfinished);
    visit.length_cells * 0.5 * (visit.to_go.unfinished + after)
}

#[cfg(test)]
mod tests {
    use dragnet_search::policy::CostToGo;

    use super::*;

    /// Visits of (expected rest, probability that something is left, way driven).
    fn visits(of: &[(f64, f64, f64)]) -> Vec<Visit> {
        let visit = |&(expected_cells, unfinished, length_cells): &(f64, f64, f64)| Visit {
            to_go: CostToGo { expected_cells, unfinished },
            length_cells,
            choice: None,
        };
        of.iter().map(visit).collect()
    }

    #[test]
    fn a_decision_answers_for_its_own_way_or_for_all_that_followed() {
        // The second decision drives 3 cells and brings the rest from 8 to 9: 4 cells lost; all others are as expected.
        let search = visits(&[(10.0, 1.0, 2.0), (8.0, 1.0, 3.0), (9.0, 1.0, 5.0), (4.0, 1.0, 8.0)]);
        assert_eq!(advantages(&search, 0.0), [0.0, -4.0, 0.0, 0.0]);
        assert_eq!(advantages(&search, 0.5), [-2.0, -4.0, 0.0, 0.0]);
        assert_eq!(advantages(&search, 1.0), [-4.0, -4.0, 0.0, 0.0]);
        assert!((expected_cells(&search) - 14.0).abs() < 1e-12, "the last way ends with nothing left");
    }

    #[test]
    fn with_a_whole_trace_it_is_what_was_expected_less_what_was_driven() {
        let search = visits(&[(30.0, 1.0, 4.0), (11.0, 0.6, 7.0), (2.0, 0.1, 1.0)]);
        let all = advantages(&search, 1.0);
        assert!((all[0] - (30.0 - expected_cells(&search))).abs() < 1e-12);
        let rest = 11.0 - expected_cells(&search[1..]);
        assert!((all[1] - rest).abs() < 1e-12, "{all:?}");
    }

    #[test]
    fn a_way_costs_less_the_likelier_all_is_found() {
        let cells = |unfinished| expected_cells(&visits(&[(0.0, unfinished, 10.0), (0.0, unfinished, 0.0)]));
        assert!((cells(1.0) - 10.0).abs() < 1e-12 && (cells(0.25) - 2.5).abs() < 1e-12);
        assert!(advantages(&[], 0.5).is_empty() && expected_cells(&[]) == 0.0);
    }
}
