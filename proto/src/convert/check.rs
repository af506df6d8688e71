//! Checks of single fields. Errors name the field.

use dragnet_scenario::participant::Participant;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Origin, RobotId, Source, Version, Versions};
use dragnet_search::sensor::Sensor;

use super::error::ConvertError;
use super::field::{Field, Place};
use crate::dragnet_msgs as wire;
use crate::message::Activity;
use crate::replica::MAX_STARTS;

/// The most readings of one observation: cells within [`Sensor::MAX_RADIUS`].
pub(super) const MAX_READINGS: usize = {
    let radius = Sensor::MAX_RADIUS as usize;
    2 * radius * (radius + 1) + 1
};
/// The most incarnations in a version vector, for a large team.
pub(super) const MAX_ORIGINS: usize = 1 << 16;

/// Converts the fields of one part of a message to domain types of one map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    pub(super) grid: Grid,
    /// Robots of the team.
    pub(super) robots: u16,
    /// This program's version of the message.
    pub(super) version: u8,
    pub(super) message: &'static str,
    pub(super) place: Place,
}

impl Check {
    pub(super) const fn within(self, place: Place) -> Self {
        Self { place, ..self }
    }

    pub(super) const fn at(self, name: &'static str) -> Field {
        Field { message: self.message, place: self.place, name, index: None }
    }

    pub(super) const fn at_entry(self, name: &'static str, index: usize) -> Field {
        Field { message: self.message, place: self.place, name, index: Some(index) }
    }

    pub(super) fn version(self, found: u8) -> Result<(), ConvertError> {
        let expected = self.version;
        if found == expected {
            Ok(())
        } else {
            Err(ConvertError::Version { at: self.at("version"), found, expected })
        }
    }

    pub(super) fn cell(self, at: Field, found: u32) -> Result<Cell, ConvertError> {
        let last = self.grid.cell_count() - 1;
        self.grid.cell_numbered(found).ok_or(ConvertError::Cell { at, found, last })
    }

    pub(super) fn path(self, name: &'static str, cells: &[u32]) -> Result<Vec<Cell>, ConvertError> {
        self.at_most(self.grid.cell_count(), name, cells.len())?;
        cells.iter().enumerate().map(|(index, &cell)| self.cell(self.at_entry(name, index), cell)).collect()
    }

    pub(super) fn readings(
        self,
        cells: &[u32],
        values: &[f32],
        variances: &[f32],
    ) -> Result<Vec<Reading>, ConvertError> {
        self.at_most(MAX_READINGS, "cells", cells.len())?;
        self.same_length("values", values.len(), "cells", cells.len())?;
        self.same_length("variances", variances.len(), "cells", cells.len())?;
        let entries = cells.iter().zip(values).zip(variances).enumerate();
        entries
            .map(|(index, ((&cell, &value), &variance))| {
                let cell = self.cell(self.at_entry("cells", index), cell)?;
                let reading = Reading { cell, value, variance };
                if reading.is_valid() {
                    Ok(reading)
                } else {
                    let at = self.at_entry("values", index);
                    Err(ConvertError::Reading { at, value, variance })
                }
            })
            .collect()
    }

    /// Positions of objects, of each cell at most one.
    pub(super) fn positions(
        self,
        positions: &[wire::ObjectPosition],
    ) -> Result<Box<[ObjectPosition]>, ConvertError> {
        self.at_most(ObjectPosition::MAX_IN_OBSERVATION, "positions", positions.len())?;
        let cells: Vec<u32> = positions.iter().map(|position| position.cell).collect();
        self.ascending("positions", &cells)?;
        positions.iter().enumerate().map(|(index, position)| self.position(index, position)).collect()
    }

    fn position(self, index: usize, wire: &wire::ObjectPosition) -> Result<ObjectPosition, ConvertError> {
        let (at, expected) = (self.at_entry("positions", index), self.version);
        if wire.version != expected {
            return Err(ConvertError::Version { at, found: wire.version, expected });
        }
        let (meters, covariance) = ([wire.east_meters, wire.north_meters], wire.covariance_square_meters);
        let position = ObjectPosition::new(self.cell(at, wire.cell)?, meters, covariance);
        position.ok_or(ConvertError::Position { at, meters, covariance })
    }

    /// A version vector: no more origins than a team can have, each once and in order.
    pub(super) fn versions(self, known: &[wire::Version]) -> Result<Versions, ConvertError> {
        // The operator's marks are numbered like one more robot's observations.
        let most = (usize::from(self.robots) + 1) * MAX_STARTS;
        self.at_most(most.min(MAX_ORIGINS), "version_vector", known.len())?;
        let mut versions: Vec<Version> = Vec::with_capacity(known.len());
        for (index, wire) in known.iter().enumerate() {
            let check = self.within(Place::Known(index));
            check.version(wire.version)?;
            let origin = Origin { source: Source::numbered(wire.robot), incarnation: wire.incarnation };
            if let Some(before) = versions.last() {
                check.follows(origin, before.origin)?;
            }
            versions.push(Version { origin, next: wire.next });
        }
        Ok(versions.into())
    }

    fn follows(self, origin: Origin, before: Origin) -> Result<(), ConvertError> {
        if origin > before {
            return Ok(());
        }
        let (name, found, before) = if origin.source == before.source {
            ("incarnation", origin.incarnation, before.incarnation)
        } else {
            ("robot", origin.source.number().into(), before.source.number().into())
        };
        Err(ConvertError::Order { at: self.at(name), found, before })
    }

    pub(super) fn at_most(self, most: usize, name: &'static str, found: usize) -> Result<(), ConvertError> {
        if found <= most { Ok(()) } else { Err(ConvertError::TooMany { at: self.at(name), found, most }) }
    }

    pub(super) fn same_length(
        self,
        name: &'static str,
        found: usize,
        partner: &'static str,
        expected: usize,
    ) -> Result<(), ConvertError> {
        if found == expected {
            Ok(())
        } else {
            Err(ConvertError::Lengths { at: self.at(name), found, partner, expected })
        }
    }

    /// Each number once.
    pub(super) fn ascending<N: Copy + Ord + Into<u64>>(
        self,
        name: &'static str,
        numbers: &[N],
    ) -> Result<(), ConvertError> {
        let unordered = numbers.windows(2).position(|pair| pair[0] >= pair[1]);
        match unordered {
            Some(index) => Err(ConvertError::Order {
                at: self.at_entry(name, index + 1),
                found: numbers[index + 1].into(),
                before: numbers[index].into(),
            }),
            None => Ok(()),
        }
    }

    /// Numbers of robots of the team.
    pub(super) fn team(self, name: &'static str, found: &[u16]) -> Result<Vec<RobotId>, ConvertError> {
        self.at_most(self.robots.into(), name, found.len())?;
        found.iter().enumerate().map(|(index, &number)| robot(self.at_entry(name, index), number)).collect()
    }

    pub(super) fn same_robot(self, found: u16, expected: u16) -> Result<(), ConvertError> {
        if found == expected {
            Ok(())
        } else {
            Err(ConvertError::Robot { at: self.at("robot"), found, expected })
        }
    }

    pub(super) fn not_negative(self, name: &'static str, found: f64) -> Result<f64, ConvertError> {
        if found.is_finite() && found >= 0.0 {
            Ok(found)
        } else {
            let allowed = "finite numbers from 0";
            Err(ConvertError::Number { at: self.at(name), found, allowed })
        }
    }

    /// A duration that fits any clock: no more than the thirty years of a scenario.
    pub(super) fn seconds(self, name: &'static str, found: f64) -> Result<f64, ConvertError> {
        if (0.0..=1e9).contains(&found) {
            Ok(found)
        } else {
            Err(ConvertError::Number { at: self.at(name), found, allowed: "0 to 1000000000 seconds" })
        }
    }

    pub(super) fn probability(self, name: &'static str, found: f64) -> Result<f64, ConvertError> {
        if (0.0..=1.0).contains(&found) {
            Ok(found)
        } else {
            Err(ConvertError::Number { at: self.at(name), found, allowed: "0 to 1" })
        }
    }

    pub(super) fn activity(self, found: u8) -> Result<Activity, ConvertError> {
        match found {
            0 => Ok(Activity::Searching),
            1 => Ok(Activity::Cleared),
            2 => Ok(Activity::Spent),
            3 => Ok(Activity::Stuck),
            4 => Ok(Activity::Paused),
            5 => Ok(Activity::Waiting),
            6 => Ok(Activity::Returning),
            7 => Ok(Activity::Recalled),
            8 => Ok(Activity::Sent),
            9 => Ok(Activity::Holding),
            10 => Ok(Activity::Leaving),
            11 => Ok(Activity::GivingWay),
            _ => {
                let allowed = "0 searching, 1 cleared, 2 spent, 3 stuck, 4 paused, 5 waiting, 6 returning, 7 recalled, \
                               8 sent, 9 holding, 10 leaving, 11 giving way";
                Err(ConvertError::Alternative { at: self.at("activity"), found, allowed })
            }
        }
    }

    pub(super) fn participant(
        self,
        [kind, number]: [&'static str; 2],
        found: u8,
        robot_number: u16,
    ) -> Result<Participant, ConvertError> {
        match found {
            0 => robot(self.at(number), robot_number).map(Participant::Robot),
            1 => Ok(Participant::Coordinator),
            _ => {
                let allowed = "0 robot, 1 coordinator";
                Err(ConvertError::Alternative { at: self.at(kind), found, allowed })
            }
        }
    }
}

pub(super) fn robot(at: Field, number: u16) -> Result<RobotId, ConvertError> {
    let found = number.into();
    RobotId::new(number).ok_or(ConvertError::Number { at, found, allowed: "robots from 1" })
}

pub(super) const fn activity_number(activity: Activity) -> u8 {
    match activity {
        Activity::Searching => 0,
        Activity::Cleared => 1,
        Activity::Spent => 2,
        Activity::Stuck => 3,
        Activity::Paused => 4,
        Activity::Waiting => 5,
        Activity::Returning => 6,
        Activity::Recalled => 7,
        Activity::Sent => 8,
        Activity::Holding => 9,
        Activity::Leaving => 10,
        Activity::GivingWay => 11,
    }
}

/// Kind and robot number; the coordinator's number is 0.
pub(super) const fn participant_numbers(participant: Participant) -> (u8, u16) {
    match participant {
        Participant::Robot(robot) => (0, robot.number()),
        Participant::Coordinator => (1, 0),
    }
}

/// Upper half first.
pub(super) fn digest_halves(digest: Digest) -> [u64; 2] {
    let bytes = digest.0.to_be_bytes();
    let (upper, lower) = bytes.split_at(8);
    [upper, lower].map(|half| half.iter().fold(0, |number, &byte| number << 8 | u64::from(byte)))
}

pub(super) fn digest([upper, lower]: [u64; 2]) -> Digest {
    Digest(u128::from(upper) << 64 | u128::from(lower))
}

pub(super) fn numbers(cells: &[Cell]) -> Vec<u32> {
    cells.iter().map(|cell| cell.number()).collect()
}

/// Readings on the wire: three arrays of equal length.
pub(super) struct Columns {
    pub(super) cells: Vec<u32>,
    pub(super) values: Vec<f32>,
    pub(super) variances: Vec<f32>,
}

impl From<&[Reading]> for Columns {
    fn from(readings: &[Reading]) -> Self {
        Self {
            cells: readings.iter().map(|reading| reading.cell.number()).collect(),
            values: readings.iter().map(|reading| reading.value).collect(),
            variances: readings.iter().map(|reading| reading.variance).collect(),
        }
    }
}
