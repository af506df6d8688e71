//! Estimates as text.

/// `0.912 ± 0.004`, without unknown parts.
#[must_use]
pub fn estimate(mean: Option<f64>, sem: Option<f64>, decimals: usize) -> String {
    match (mean, sem) {
        (Some(mean), Some(sem)) => format!("{mean:.decimals$} ± {sem:.decimals$}"),
        (Some(mean), None) => format!("{mean:.decimals$}"),
        (None, _) => "-".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_prints_its_known_parts() {
        assert_eq!(estimate(Some(0.25), Some(0.001), 2), "0.25 ± 0.00");
        assert_eq!(estimate(Some(137.0), None, 1), "137.0");
        assert_eq!(estimate(None, None, 1), "-");
    }
}
