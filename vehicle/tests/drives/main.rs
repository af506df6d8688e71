//! Drives past one object at a random place, through the pilot as a robot has it: is the object declared where it is?
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod drive;
mod recall;
