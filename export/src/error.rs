//! Why a recording cannot be exported.

/// Why a recording cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The mission's position on the earth is unknown.
    #[error(
        "the recording does not say where on earth the map lies; allowed is to give its south-western corner, such as \
         --origin 49.236,-2.24"
    )]
    NoOrigin,
    /// There are two positions.
    #[error(
        "the recording says itself where the map lies, its south-western corner at latitude {latitude_degrees}, longitude \
         {longitude_degrees}; allowed is no other origin"
    )]
    TwoOrigins {
        /// North positive.
        latitude_degrees: f64,
        /// East positive.
        longitude_degrees: f64,
    },
    /// No robot has a plan.
    #[error(
        "no robot has a plan {seconds:.1} s after the start; allowed is an earlier time, such as --at 0 for the first plans"
    )]
    NoPlan {
        /// Mission time, seconds.
        seconds: f64,
    },
}
