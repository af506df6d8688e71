//! Pictures of finds: what a robot's camera has seen of an object, for the person who decides about it.
//!
//! They are neither evidence nor part of what participants agree on: a robot keeps the best picture of each of its finds, and
//! the coordinator asks for those of declared objects, as a whole or in parts that a thin link carries. Nothing of the search
//! depends on them.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use dragnet_search::cell::{Cell, Grid};
use dragnet_search::observation::RobotId;

/// What is known of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureFacts {
    /// The robot.
    pub robot: RobotId,
    /// When it was taken, nanoseconds of mission time.
    pub time_ns: u64,
    /// The cell in which the robot has found the object.
    pub cell: Cell,
    /// The camera's name, at most [`PictureFacts::MAX_NAME_BYTES`].
    pub camera: String,
    /// The detector's class of the object, as long at most; empty if it gives none.
    pub label: String,
    /// The detector's score, 0 to 1; 1 if it gives none.
    pub score: f32,
    /// Side of the object's box, pixels, times its score; finite and at least 0. The better of two pictures has the higher one.
    pub quality: f32,
}

impl PictureFacts {
    /// A picture is replaced once the quality of another is higher by this factor: a robot that approaches an object takes a
    /// better one with every image.
    pub const BETTER: f32 = 1.25;
    /// The most bytes of a name.
    pub const MAX_NAME_BYTES: usize = 64;

    /// What the detector has seen, in words: `person, 0.91`; empty without a class.
    #[must_use]
    pub fn seen(&self) -> String {
        if self.label.is_empty() { String::new() } else { format!("{}, {:.2}", self.label, self.score) }
    }

    /// Who has taken it, in words: `robot 1's camera front (person, 0.91)`.
    #[must_use]
    pub fn source(&self) -> String {
        let seen = self.seen();
        let seen = if seen.is_empty() { seen } else { format!(" ({seen})") };
        format!("robot {}'s camera {}{seen}", self.robot, self.camera)
    }
}

/// A whole picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// What is known of it.
    pub facts: PictureFacts,
    /// A JPEG file, 1 to [`Picture::MAX_BYTES`] bytes.
    pub jpeg: Arc<[u8]>,
}

/// A part of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PicturePart {
    /// What is known of the picture.
    pub facts: PictureFacts,
    /// Bytes of the whole picture, 1 to [`Picture::MAX_BYTES`].
    pub size: usize,
    /// Offset of the data in it, at most `size`.
    pub first: usize,
    /// At most `size - first` bytes; none if only the facts were asked for.
    pub data: Vec<u8>,
}

impl Picture {
    /// The most bytes of a picture.
    pub const MAX_BYTES: usize = 20_000;

    /// At most `most` of its bytes from an offset on.
    #[must_use]
    pub fn part(&self, first: usize, most: usize) -> PicturePart {
        let first = first.min(self.jpeg.len());
        let last = first.saturating_add(most).min(self.jpeg.len());
        let (facts, size) = (self.facts.clone(), self.jpeg.len());
        PicturePart { facts, size, first, data: self.jpeg[first..last].to_vec() }
    }
}

/// A request for a part of a robot's picture of a cell, as the parameters of a query: `cell=12;first=0;most=20000`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureRequest {
    /// The cell.
    pub cell: Cell,
    /// Offset of the first byte.
    pub first: usize,
    /// The most bytes; with 0 the reply has the facts only.
    pub most: usize,
}

/// The parameters of a query are no request for a picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} asks for no picture; allowed are parameters like cell=12;first=0;most=20000")]
pub struct NoPictureRequest(String);

impl PictureRequest {
    /// The request of a query's parameters, on a mission's map.
    ///
    /// # Errors
    /// If they are none, or the cell is not on the map.
    pub fn parse(parameters: &str, grid: Grid) -> Result<Self, NoPictureRequest> {
        let number = |name: &str| {
            let mut named = parameters.split(';').filter_map(|parameter| parameter.split_once('='));
            named.find(|(key, _)| *key == name).and_then(|(_, value)| u32::from_str(value).ok())
        };
        let request = || {
            Some(Self {
                cell: grid.cell_numbered(number("cell")?)?,
                first: number("first")? as usize,
                most: number("most")? as usize,
            })
        };
        request().ok_or_else(|| NoPictureRequest(parameters.chars().take(100).collect()))
    }
}

impl fmt::Display for PictureRequest {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "cell={};first={};most={}", self.cell.number(), self.first, self.most)
    }
}

/// A picture that arrives in parts, in order.
#[derive(Clone, Debug)]
pub struct Assembly {
    facts: PictureFacts,
    size: usize,
    data: Vec<u8>,
}

impl Assembly {
    /// Nothing of a picture yet, whose facts a part states.
    #[must_use]
    pub fn of(part: &PicturePart) -> Self {
        Self { facts: part.facts.clone(), size: part.size, data: Vec::new() }
    }

    /// What is known of the picture.
    #[must_use]
    pub const fn facts(&self) -> &PictureFacts {
        &self.facts
    }

    /// The request for the next part.
    #[must_use]
    pub const fn next(&self, most: usize) -> PictureRequest {
        PictureRequest { cell: self.facts.cell, first: self.data.len(), most }
    }

    /// Adds the next part; returns whether it is one. The robot may have a better picture by now.
    pub fn add(&mut self, part: &PicturePart) -> bool {
        let is_same = part.size == self.size && part.facts.quality.to_bits() == self.facts.quality.to_bits();
        let is_next = is_same && part.first == self.data.len() && !part.data.is_empty();
        if is_next {
            self.data.extend_from_slice(&part.data);
        }
        is_next
    }

    /// The picture, once it is complete.
    #[must_use]
    pub fn whole(&self) -> Option<Picture> {
        let is_whole = self.data.len() == self.size;
        is_whole.then(|| Picture { facts: self.facts.clone(), jpeg: self.data.as_slice().into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(quality: f32) -> Picture {
        let grid = Grid::new(4, 5).unwrap();
        let facts = PictureFacts {
            robot: RobotId::new(3).unwrap(),
            time_ns: 7,
            cell: grid.cell_numbered(12).unwrap(),
            camera: "front".to_owned(),
            label: "person".to_owned(),
            score: 0.91,
            quality,
        };
        Picture { facts, jpeg: (0..=255).collect() }
    }

    #[test]
    fn a_request_is_read_as_it_is_written() {
        let grid = Grid::new(4, 5).unwrap();
        let request = PictureRequest { cell: grid.cell_numbered(12).unwrap(), first: 300, most: 0 };
        assert_eq!(PictureRequest::parse(&request.to_string(), grid), Ok(request));
        assert_eq!(PictureRequest::parse("most=0;first=300;cell=12", grid), Ok(request));
        for wrong in
            ["", "cell=12", "cell=20;first=0;most=1", "cell=12;first=-1;most=1", "cell=12,first=0,most=1"]
        {
            let error = PictureRequest::parse(wrong, grid).unwrap_err().to_string();
            assert!(error.contains(wrong) && error.contains("allowed are"), "{error}");
        }
    }

    #[test]
    fn parts_make_the_whole_and_parts_of_another_picture_do_not_count() {
        let whole = picture(50.0);
        let mut assembly = Assembly::of(&whole.part(0, 0));
        assert_eq!(assembly.whole(), None);
        for _ in 0..3 {
            let request = assembly.next(100);
            assert!(!assembly.add(&picture(60.0).part(request.first, request.most)), "a better picture");
            assert!(!assembly.add(&whole.part(request.first + 1, request.most)), "a gap");
            let part = whole.part(request.first, request.most);
            assert!(assembly.add(&part) && !assembly.add(&part), "once");
        }
        assert_eq!(assembly.whole(), Some(whole.clone()));
        assert!(whole.part(1000, 10).data.is_empty());
    }
}
