//! Where a vehicle is and is to go, and how far it may.

/// Length of a degree of latitude, meters: for distances of a few kilometers, within 0.6 %.
const METERS_PER_DEGREE: f64 = 111_320.0;
/// Distance that a target keeps from a limit, meters: autopilots stop a little beyond their targets.
const MARGIN_METERS: f64 = 2.0;

/// A place, as the vehicle is localized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// On the earth, degrees.
    Global {
        /// Latitude, degrees, -90 to 90.
        latitude_degrees: f64,
        /// Longitude, degrees, -180 to 180.
        longitude_degrees: f64,
    },
    /// From the origin of the autopilot's local frame, meters.
    Local {
        /// To the north, meters.
        north_meters: f64,
        /// To the east, meters.
        east_meters: f64,
    },
}

impl Place {
    /// The distance to another place, meters; infinite between places of different kinds.
    #[must_use]
    pub fn meters_to(&self, other: &Self) -> f64 {
        match (*self, *other) {
            (
                Self::Global { latitude_degrees: north, longitude_degrees: east },
                Self::Global { latitude_degrees: other_north, longitude_degrees: other_east },
            ) => {
                let shrink = f64::midpoint(north, other_north).to_radians().cos();
                (north - other_north).hypot((east - other_east) * shrink) * METERS_PER_DEGREE
            }
            (
                Self::Local { north_meters: north, east_meters: east },
                Self::Local { north_meters: other_north, east_meters: other_east },
            ) => (north - other_north).hypot(east - other_east),
            _ => f64::INFINITY,
        }
    }
}

/// Where a vehicle is to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The place.
    pub place: Place,
    /// The heading there, radians clockwise from north. Rovers and boats ignore it.
    pub yaw_radians: f64,
}

/// The position of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Nanoseconds of the caller's time: when it was there, not when the message came.
    pub time_ns: u64,
    /// The place.
    pub place: Place,
    /// Height above home, meters.
    pub altitude_meters: f64,
    /// Heading, radians clockwise from north.
    pub yaw_radians: f64,
    /// Roll, radians, right side down; 0 if unknown.
    pub roll_radians: f64,
    /// Pitch, radians, nose up; 0 if unknown.
    pub pitch_radians: f64,
    /// Standard deviation of the place along each axis, meters.
    pub std_meters: f64,
}

/// How far from home, and how high, targets may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Distance from home, meters; infinite without a limit.
    pub max_distance_meters: f64,
    /// Lowest height above home of a copter, meters.
    pub min_altitude_meters: f64,
    /// Highest height above home of a copter, meters.
    pub max_altitude_meters: f64,
}

impl Limits {
    /// The narrower of both.
    #[must_use]
    pub fn within(self, other: Self) -> Self {
        Self {
            max_distance_meters: self.max_distance_meters.min(other.max_distance_meters),
            min_altitude_meters: self.min_altitude_meters.max(other.min_altitude_meters),
            max_altitude_meters: self.max_altitude_meters.min(other.max_altitude_meters),
        }
    }

    /// No limit.
    pub const NONE: Self = Self {
        max_distance_meters: f64::INFINITY,
        min_altitude_meters: f64::NEG_INFINITY,
        max_altitude_meters: f64::INFINITY,
    };

    /// Checks a target; `altitude_meters` is that of a copter.
    ///
    /// # Errors
    /// If it lies outside, or home is unknown and there is a limit around it: what, and what is allowed.
    pub fn check(
        &self,
        target: &Place,
        home: Option<&Place>,
        altitude_meters: Option<f64>,
    ) -> Result<(), String> {
        if let Some(altitude) = altitude_meters {
            let (lowest, highest) = (self.min_altitude_meters, self.max_altitude_meters - MARGIN_METERS);
            // NaN is in no range.
            if !(lowest..=highest).contains(&altitude) {
                return Err(format!(
                    "a target {altitude:.1} m above home; allowed is from {lowest:.1} to {highest:.1} m"
                ));
            }
        }
        if self.max_distance_meters.is_infinite() {
            return Ok(());
        }
        let Some(home) = home else {
            return Err("home is unknown, around which there is a fence; no target is allowed".to_owned());
        };
        let (meters, allowed) = (home.meters_to(target), self.max_distance_meters - MARGIN_METERS);
        if meters <= allowed {
            return Ok(());
        }
        Err(format!("a target {meters:.0} m from home; allowed are {allowed:.0} m"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;

    #[test]
    fn targets_beyond_a_limit_are_refused() {
        let local = |north_meters, east_meters| Place::Local { north_meters, east_meters };
        let limits =
            Limits { max_distance_meters: 102.0, min_altitude_meters: 5.0, max_altitude_meters: 32.0 };
        let check = |place, altitude, result: Result<(), &str>| match (
            limits.check(&place, Some(&local(10.0, 0.0)), altitude),
            result,
        ) {
            (Err(error), Err(mentioned)) => assert_mentions(&error, mentioned),
            (found, expected) => assert_eq!(found.is_ok(), expected.is_ok(), "{place:?} {altitude:?}"),
        };
        check(local(110.0, 0.0), Some(30.0), Ok(()));
        check(local(-91.0, 0.0), None, Err("101 m .. 100 m"));
        check(local(0.0, f64::NAN), None, Err("NaN m from home"));
        check(local(0.0, 0.0), Some(30.5), Err("30.5 m above .. 5.0 to 30.0"));
        check(local(0.0, 0.0), Some(4.0), Err("4.0 m above"));
        check(local(0.0, 0.0), Some(f64::NAN), Err("NaN m above"));
        let global = Place::Global { latitude_degrees: 0.0, longitude_degrees: 0.0 };
        check(global, None, Err("inf m"));
        assert_mentions(&limits.check(&global, None, None).unwrap_err(), "home is unknown");
        assert_eq!(Limits::NONE.check(&global, None, Some(1e4)), Ok(()));
        assert_eq!(Limits::NONE.within(limits), limits);
    }

    #[test]
    fn distances_on_the_earth_shrink_with_the_latitude() {
        let at = |latitude_degrees, longitude_degrees| Place::Global { latitude_degrees, longitude_degrees };
        assert!((at(60.0, 10.0).meters_to(&at(60.0, 10.01)) - 556.6).abs() < 0.1);
        assert!((at(60.0, 10.0).meters_to(&at(60.01, 10.0)) - 1113.2).abs() < 0.1);
    }
}
