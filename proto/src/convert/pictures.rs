//! Pictures of finds to the wire and back.

use super::check::{Check, robot};
use super::error::ConvertError;
use crate::dragnet_msgs as wire;
use crate::picture::{Picture, PictureFacts, PicturePart};

impl From<&PicturePart> for wire::Picture {
    fn from(part: &PicturePart) -> Self {
        let PicturePart { facts, size, first, data } = part;
        let bytes = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        Self {
            version: wire::VERSION,
            robot: facts.robot.number(),
            time_ns: facts.time_ns,
            cell: facts.cell.number(),
            camera: facts.camera.clone(),
            label: facts.label.clone(),
            score: facts.score,
            quality: facts.quality,
            size: bytes(*size),
            first: bytes(*first),
            data: data.clone(),
        }
    }
}

impl Check {
    pub(super) fn picture(self, wire: wire::Picture) -> Result<PicturePart, ConvertError> {
        self.version(wire.version)?;
        let cell = self.cell(self.at("cell"), wire.cell)?;
        self.at_most(PictureFacts::MAX_NAME_BYTES, "camera", wire.camera.len())?;
        self.at_most(PictureFacts::MAX_NAME_BYTES, "label", wire.label.len())?;
        self.probability("score", wire.score.into())?;
        self.not_negative("quality", wire.quality.into())?;
        let [size, first] = [wire.size, wire.first].map(|count| count as usize);
        if !(1..=Picture::MAX_BYTES).contains(&size) {
            let (at, found) = (self.at("size"), wire.size.into());
            return Err(ConvertError::Number { at, found, allowed: "1 to 20000 bytes" });
        }
        self.at_most(size, "first", first)?;
        self.at_most(size - first, "data", wire.data.len())?;
        let facts = PictureFacts {
            robot: robot(self.at("robot"), wire.robot)?,
            time_ns: wire.time_ns,
            cell,
            camera: wire.camera,
            label: wire.label,
            score: wire.score,
            quality: wire.quality,
        };
        Ok(PicturePart { facts, size, first, data: wire.data })
    }
}
