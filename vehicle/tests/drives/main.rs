//! Drives past one object at a random position, with the pilot of a robot: is the object declared where it is?
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod drive;
mod recall;
