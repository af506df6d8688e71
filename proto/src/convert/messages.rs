//! Messages between participants, to the wire and back.

use std::sync::Arc;

use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, Origin, Source, Version};

use super::check::{
    Check, Columns, activity_number, digest, digest_halves, numbers, participant_numbers, robot,
};
use super::error::ConvertError;
use super::field::Place;
use crate::dragnet_msgs as wire;
use crate::message::{Detection, Heartbeat, Intent, MissionStatus, SyncReply, SyncRequest};

impl From<&Observation> for wire::Observation {
    fn from(observation: &Observation) -> Self {
        let Columns { cells, values, variances } = observation.readings.as_slice().into();
        Self {
            version: wire::OBSERVATION_VERSION,
            robot: observation.origin.source.number(),
            incarnation: observation.origin.incarnation,
            sequence: observation.sequence,
            time_ns: observation.time_ns,
            cell: observation.from.number(),
            cells,
            values,
            variances,
            positions: observation.positions.iter().map(Into::into).collect(),
        }
    }
}

impl From<&ObjectPosition> for wire::ObjectPosition {
    fn from(position: &ObjectPosition) -> Self {
        let (east_meters, north_meters) = position.meters();
        Self {
            version: wire::OBSERVATION_VERSION,
            cell: position.cell().number(),
            east_meters,
            north_meters,
            covariance_square_meters: position.covariance_square_meters(),
        }
    }
}

impl From<&Intent> for wire::Intent {
    fn from(intent: &Intent) -> Self {
        Self {
            version: wire::VERSION,
            robot: intent.robot.number(),
            incarnation: intent.incarnation,
            decision: intent.decision,
            time_ns: intent.time_ns,
            path: numbers(&intent.path),
        }
    }
}

impl From<&Heartbeat> for wire::Heartbeat {
    fn from(heartbeat: &Heartbeat) -> Self {
        Self {
            version: wire::VERSION,
            robot: heartbeat.robot.number(),
            time_ns: heartbeat.time_ns,
            activity: activity_number(heartbeat.activity),
            cell: heartbeat.cell.number(),
            path_meters: heartbeat.path_meters,
            intent: (&heartbeat.intent).into(),
            version_vector: heartbeat.versions.iter().map(Into::into).collect(),
            digest: digest_halves(heartbeat.digest),
            directive: (&heartbeat.directive).into(),
        }
    }
}

impl From<&Version> for wire::Version {
    fn from(version: &Version) -> Self {
        let Version { origin: Origin { source, incarnation }, next } = *version;
        Self { version: wire::VERSION, robot: source.number(), incarnation, next }
    }
}

impl From<&SyncRequest> for wire::SyncRequest {
    fn from(request: &SyncRequest) -> Self {
        let (from_kind, from_robot) = participant_numbers(request.from);
        Self {
            version: wire::VERSION,
            from_kind,
            from_robot,
            of_robot: request.of.source.number(),
            of_incarnation: request.of.incarnation,
            first: request.first,
        }
    }
}

impl From<&SyncReply> for wire::SyncReply {
    fn from(reply: &SyncReply) -> Self {
        let observations = reply.observations.iter().map(|observation| (&**observation).into());
        Self { version: wire::OBSERVATION_VERSION, observations: observations.collect() }
    }
}

impl From<&Detection> for wire::Detection {
    fn from(detection: &Detection) -> Self {
        Self {
            version: wire::VERSION,
            cell: detection.cell.number(),
            probability: detection.probability,
            time_ns: detection.time_ns,
        }
    }
}

impl From<&MissionStatus> for wire::MissionStatus {
    fn from(status: &MissionStatus) -> Self {
        Self {
            version: wire::VERSION,
            time_ns: status.time_ns,
            declared: status.declared.iter().map(Into::into).collect(),
            expected_remaining: status.expected_remaining,
            alive: status.alive.iter().map(|robot| robot.number()).collect(),
            observations: status.observations,
            version_vector: status.versions.iter().map(Into::into).collect(),
            digest: digest_halves(status.digest),
            directive: (&status.directive).into(),
            doubled: status.doubled.iter().map(|robot| robot.number()).collect(),
        }
    }
}

impl Check {
    pub(super) fn observation(self, wire: &wire::Observation) -> Result<Observation, ConvertError> {
        self.version(wire.version)?;
        Ok(Observation {
            origin: Origin { source: Source::numbered(wire.robot), incarnation: wire.incarnation },
            sequence: wire.sequence,
            time_ns: wire.time_ns,
            from: self.cell(self.at("cell"), wire.cell)?,
            readings: self.readings(&wire.cells, &wire.values, &wire.variances)?,
            positions: self.positions(&wire.positions)?,
        })
    }

    pub(super) fn intent(self, wire: &wire::Intent) -> Result<Intent, ConvertError> {
        self.version(wire.version)?;
        Ok(Intent {
            robot: robot(self.at("robot"), wire.robot)?,
            incarnation: wire.incarnation,
            decision: wire.decision,
            time_ns: wire.time_ns,
            path: self.path("path", &wire.path)?.into(),
        })
    }

    pub(super) fn heartbeat(self, wire: &wire::Heartbeat) -> Result<Heartbeat, ConvertError> {
        self.version(wire.version)?;
        let inner = self.within(Place::Intent);
        inner.same_robot(wire.intent.robot, wire.robot)?;
        Ok(Heartbeat {
            robot: robot(self.at("robot"), wire.robot)?,
            time_ns: wire.time_ns,
            activity: self.activity(wire.activity)?,
            cell: self.cell(self.at("cell"), wire.cell)?,
            path_meters: self.not_negative("path_meters", wire.path_meters)?,
            intent: inner.intent(&wire.intent)?,
            versions: self.versions(&wire.version_vector)?,
            digest: digest(wire.digest),
            directive: self.directive(&wire.directive)?,
        })
    }

    pub(super) fn sync_request(self, wire: &wire::SyncRequest) -> Result<SyncRequest, ConvertError> {
        self.version(wire.version)?;
        Ok(SyncRequest {
            from: self.participant(["from_kind", "from_robot"], wire.from_kind, wire.from_robot)?,
            of: Origin { source: Source::numbered(wire.of_robot), incarnation: wire.of_incarnation },
            first: wire.first,
        })
    }

    pub(super) fn sync_reply(self, wire: &wire::SyncReply) -> Result<SyncReply, ConvertError> {
        self.version(wire.version)?;
        self.at_most(SyncReply::MAX_OBSERVATIONS, "observations", wire.observations.len())?;
        for (index, pair) in wire.observations.windows(2).enumerate() {
            let [before, after] = pair else { continue };
            let check = self.within(Place::Observation(index + 1));
            check.same_robot(after.robot, before.robot)?;
            if after.incarnation != before.incarnation {
                return Err(ConvertError::Incarnation {
                    at: check.at("incarnation"),
                    found: after.incarnation,
                    expected: before.incarnation,
                });
            }
            if after.sequence <= before.sequence {
                return Err(ConvertError::Order {
                    at: check.at("sequence"),
                    found: after.sequence,
                    before: before.sequence,
                });
            }
        }
        let observations = wire.observations.iter().enumerate().map(|(index, observation)| {
            self.within(Place::Observation(index)).observation(observation).map(Arc::new)
        });
        Ok(SyncReply { observations: observations.collect::<Result<_, _>>()? })
    }

    fn detection(self, wire: &wire::Detection) -> Result<Detection, ConvertError> {
        self.version(wire.version)?;
        Ok(Detection {
            cell: self.cell(self.at("cell"), wire.cell)?,
            probability: self.probability("probability", wire.probability)?,
            time_ns: wire.time_ns,
        })
    }

    pub(super) fn mission_status(self, wire: &wire::MissionStatus) -> Result<MissionStatus, ConvertError> {
        self.version(wire.version)?;
        self.at_most(self.grid.cell_count(), "declared", wire.declared.len())?;
        let declared = wire
            .declared
            .iter()
            .enumerate()
            .map(|(index, detection)| self.within(Place::Declared(index)).detection(detection));
        Ok(MissionStatus {
            time_ns: wire.time_ns,
            declared: declared.collect::<Result<_, _>>()?,
            expected_remaining: self.not_negative("expected_remaining", wire.expected_remaining)?,
            alive: self.team("alive", &wire.alive)?,
            observations: wire.observations,
            versions: self.versions(&wire.version_vector)?,
            digest: digest(wire.digest),
            directive: self.directive(&wire.directive)?,
            doubled: self.team("doubled", &wire.doubled)?,
        })
    }
}
