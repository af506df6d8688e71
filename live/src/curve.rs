//! A curve over mission time with a bounded number of points.

/// The maximum number of points.
const MOST: usize = 512;

/// Points `(seconds, values)`, their times ascending.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    points: Vec<[f64; 3]>,
    /// The least time between two points, seconds; doubled whenever there are too many.
    gap_seconds: f64,
}

impl Default for Curve {
    fn default() -> Self {
        Self { points: Vec::new(), gap_seconds: 0.25 }
    }
}

impl Curve {
    /// Adds values from this time on. Of values close to each other in time the last stays.
    pub(crate) fn push(&mut self, seconds: f64, values: [f64; 2]) {
        let point = [seconds, values[0], values[1]];
        let before = self.points.len().checked_sub(2).map(|index| self.points[index][0]);
        match self.points.last_mut() {
            Some(last) if before.is_some_and(|before| last[0] - before < self.gap_seconds) => *last = point,
            _ => self.points.push(point),
        }
        if self.points.len() > MOST {
            self.gap_seconds *= 2.0;
            let mut index = 0;
            self.points.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
    }

    pub(crate) fn points(&self) -> &[[f64; 3]] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_stays_short_and_keeps_its_ends() {
        let mut curve = Curve::default();
        for second in 0..20_000 {
            curve.push(f64::from(second), [f64::from(second), 1.0]);
        }
        let points = curve.points();
        assert!((MOST / 4..=MOST).contains(&points.len()), "{}", points.len());
        assert!(points[0][0].abs() < f64::EPSILON);
        assert!(points.is_sorted_by(|a, b| a[0] < b[0]));
        assert!(points[points.len() - 1][0] > 19_800.0);
    }
}
