//! Coordinate frames by name, and the transforms between them over time: a tree, as in ROS's `tf2`.
//!
//! Each frame but the roots has one parent, and a transform that is fixed or a history of some seconds. A transform at a time
//! between two of a history is interpolated: linearly, rotations by slerp. Nothing is extrapolated: what is asked for
//! before its transform has arrived is [`LookupError::NotYet`], and the caller asks again. A transform that would make
//! the tree another graph (a loop, a second parent) is refused, and what was known before remains.
//!
//! Times are nanoseconds of one clock, the caller's choice.

mod history;

use std::collections::BTreeMap;

use nalgebra::Isometry3;

use history::History;
pub use history::{KEPT_NS, MAX_GAP_NS};

/// The most frames of a tree that have a parent: a robot has tens.
const MAX_FRAMES: usize = 1024;

/// A transform as it is published.
#[derive(Clone, Debug, PartialEq)]
pub struct StampedTransform {
    /// The frame in which the child's pose is given.
    pub parent: String,
    /// The frame whose pose it is.
    pub child: String,
    /// The child's pose in the parent, meters.
    pub parent_from_child: Isometry3<f64>,
    /// Since when it holds.
    pub validity: Validity,
}

/// The time at which a transform holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validity {
    /// At all times: the child is fixed to its parent.
    Always,
    /// At one time, nanoseconds.
    At(i64),
}

/// What a transform has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The tree knows more.
    Added,
    /// It was known.
    Known,
    /// Its time is so long before the last one that the clock must have been set back: the history begins anew.
    Restarted,
}

/// Why a transform is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TransformError {
    /// A frame relative to itself, by way of others or not.
    #[error("a loop of frames: {}", .0.join(" -> "))]
    Loop(Vec<String>),
    /// Two nodes say where a frame is, each relative to another one.
    #[error("frame {child:?} has two parents: {first:?}, which counts, and {second:?}")]
    TwoParents {
        /// The frame.
        child: String,
        /// The one that was there first.
        first: String,
        /// The other one.
        second: String,
    },
    /// Two nodes say whether a frame moves.
    #[error("frame {child:?} is published as {first}, which counts, and as {second}")]
    TwoKinds {
        /// The frame.
        child: String,
        /// What it was first.
        first: &'static str,
        /// The other kind.
        second: &'static str,
    },
    /// More frames than a robot has.
    #[error("frame {child:?} is one too many; allowed are {MAX_FRAMES}")]
    TooMany {
        /// The frame.
        child: String,
    },
}

/// Why a transform is not known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LookupError {
    /// A frame of which nothing is known.
    #[error("no transform names the frame {0:?}")]
    NoFrame(String),
    /// Both frames are known, but nothing connects them.
    #[error("no transform connects {from:?} (its tree begins at {from_root:?}) to {to:?} (at {to_root:?})")]
    NotConnected {
        /// One frame,
        from: String,
        /// and the last one above it.
        from_root: String,
        /// The other,
        to: String,
        /// and the last one above it.
        to_root: String,
    },
    /// The newest transform is older.
    #[error(
        "the newest transform from {parent:?} to {child:?} is {seconds:.2} s older than what is asked for"
    )]
    NotYet {
        /// The frame in which the child's pose is given.
        parent: String,
        /// The frame.
        child: String,
        /// By how much.
        seconds: f64,
    },
    /// The oldest transform is newer.
    #[error(
        "the oldest transform from {parent:?} to {child:?} is {seconds:.2} s newer than what is asked for"
    )]
    Past {
        /// The frame in which the child's pose is given.
        parent: String,
        /// The frame.
        child: String,
        /// By how much.
        seconds: f64,
    },
    /// Transforms were missing around that time.
    #[error("transforms from {parent:?} to {child:?} have a gap of {seconds:.2} s")]
    Gap {
        /// The frame in which the child's pose is given.
        parent: String,
        /// The frame.
        child: String,
        /// Its length.
        seconds: f64,
    },
}

impl LookupError {
    /// The error in a word, without its numbers and names.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::NoFrame(_) => "no_frame",
            Self::NotConnected { .. } => "not_connected",
            Self::NotYet { .. } => "not_yet",
            Self::Past { .. } => "past",
            Self::Gap { .. } => "gap",
        }
    }

    /// Whether a transform that is still to arrive can help.
    #[must_use]
    pub const fn may_pass(&self) -> bool {
        matches!(self, Self::NoFrame(_) | Self::NotConnected { .. } | Self::NotYet { .. })
    }
}

/// A transform of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link<'a> {
    /// The frame in which the child's pose is given.
    pub parent: &'a str,
    /// The frame whose pose it is.
    pub child: &'a str,
    /// The time of the newest transform, nanoseconds; `None` if it is fixed.
    pub newest_ns: Option<i64>,
}

/// The frames.
#[derive(Clone, Debug, Default)]
pub struct FrameTree {
    /// By child.
    edges: BTreeMap<String, Edge>,
}

#[derive(Clone, Debug)]
struct Edge {
    parent: String,
    motion: Motion,
}

#[derive(Clone, Debug)]
enum Motion {
    Fixed(Isometry3<f64>),
    Moving(History),
}

impl FrameTree {
    /// Adds a transform. Frames are compared without a leading slash, which is from ROS 1.
    ///
    /// # Errors
    /// If there is no tree with it. What was known before remains.
    pub fn insert(&mut self, transform: &StampedTransform) -> Result<Change, TransformError> {
        let (parent, child) = (bare(&transform.parent), bare(&transform.child));
        if let Some(edge) = self.edges.get(child).filter(|edge| !edge.is_over(transform.validity)) {
            edge.check(parent, child, transform.validity)?;
        } else {
            self.check_new(parent, child)?;
            self.edges.insert(child.to_owned(), Edge::new(parent, transform));
            return Ok(Change::Added);
        }
        match (self.edges.get_mut(child).map(|edge| &mut edge.motion), transform.validity) {
            (Some(Motion::Moving(history)), Validity::At(time_ns)) => {
                Ok(history.insert(time_ns, transform.parent_from_child))
            }
            (Some(Motion::Fixed(fixed)), _) if *fixed != transform.parent_from_child => {
                *fixed = transform.parent_from_child;
                Ok(Change::Added)
            }
            _ => Ok(Change::Known),
        }
    }

    /// The pose of the frame `source` in the frame `target` at a time.
    ///
    /// # Errors
    /// If it is unknown: which transform is missing.
    pub fn transform(&self, target: &str, source: &str, time_ns: i64) -> Result<Isometry3<f64>, LookupError> {
        let (down, up) = self.branches(bare(target), bare(source))?;
        let along = |branch: &[&str]| {
            branch.iter().try_fold(Isometry3::identity(), |below, child| {
                self.edge_at(child, time_ns).map(|parent_from_child| parent_from_child * below)
            })
        };
        Ok(along(&down)?.inverse() * along(&up)?)
    }

    /// The newest time at which the pose of `source` in `target` is known, nanoseconds; `None` if it is fixed.
    ///
    /// # Errors
    /// If they are not connected.
    pub fn newest_ns(&self, target: &str, source: &str) -> Result<Option<i64>, LookupError> {
        let (down, up) = self.branches(bare(target), bare(source))?;
        let newest = |child: &&str| match self.edges.get(*child).map(|edge| &edge.motion) {
            Some(Motion::Moving(history)) => history.newest_ns(),
            Some(Motion::Fixed(_)) | None => None,
        };
        Ok(down.iter().chain(&up).filter_map(newest).min())
    }

    /// The transforms between the frames `source` and `target`, in that order.
    ///
    /// # Errors
    /// If they are not connected.
    pub fn links<'a>(&'a self, target: &'a str, source: &'a str) -> Result<Vec<Link<'a>>, LookupError> {
        let (down, up) = self.branches(bare(target), bare(source))?;
        let link = |child| {
            let edge = self.edges.get(child)?;
            let newest_ns = match &edge.motion {
                Motion::Fixed(_) => None,
                Motion::Moving(history) => history.newest_ns(),
            };
            Some(Link { parent: &edge.parent, child, newest_ns })
        };
        Ok(up.into_iter().chain(down.into_iter().rev()).filter_map(link).collect())
    }

    /// The frames below the nearest common one, from `target` and from `source` upward.
    fn branches<'a>(
        &'a self,
        target: &'a str,
        source: &'a str,
    ) -> Result<(Vec<&'a str>, Vec<&'a str>), LookupError> {
        if target == source {
            return Ok((Vec::new(), Vec::new()));
        }
        let (mut down, mut up) = (self.lineage(target)?, self.lineage(source)?);
        let (Some(to_root), Some(from_root)) = (down.last().copied(), up.last().copied()) else {
            return Ok((down, up));
        };
        if to_root != from_root {
            let [from, from_root, to, to_root] = [source, from_root, target, to_root].map(str::to_owned);
            return Err(LookupError::NotConnected { from, from_root, to, to_root });
        }
        let shared = down.iter().rev().zip(up.iter().rev()).take_while(|(one, other)| one == other).count();
        down.truncate(down.len() - shared);
        up.truncate(up.len() - shared);
        Ok((down, up))
    }

    /// A frame and all above it.
    fn lineage<'a>(&'a self, frame: &'a str) -> Result<Vec<&'a str>, LookupError> {
        if !self.edges.contains_key(frame) && self.edges.values().all(|edge| edge.parent != frame) {
            return Err(LookupError::NoFrame(frame.to_owned()));
        }
        Ok(std::iter::successors(Some(frame), |&below| self.parent(below)).collect())
    }

    fn parent(&self, child: &str) -> Option<&str> {
        self.edges.get(child).map(|edge| edge.parent.as_str())
    }

    fn edge_at(&self, child: &str, time_ns: i64) -> Result<Isometry3<f64>, LookupError> {
        let Some(edge) = self.edges.get(child) else { return Err(LookupError::NoFrame(child.to_owned())) };
        match &edge.motion {
            Motion::Fixed(transform) => Ok(*transform),
            Motion::Moving(history) => {
                history.at(time_ns).map_err(|outside| outside.between(&edge.parent, child))
            }
        }
    }

    fn check_new(&self, parent: &str, child: &str) -> Result<(), TransformError> {
        // No loop was ever inserted, so this ends.
        let above: Vec<&str> =
            std::iter::successors(Some(parent), |&frame| self.parent(frame).filter(|_| frame != child))
                .collect();
        if above.last() == Some(&child) {
            let names = std::iter::once(child).chain(above);
            return Err(TransformError::Loop(names.map(str::to_owned).collect()));
        }
        if self.edges.len() >= MAX_FRAMES && !self.edges.contains_key(child) {
            return Err(TransformError::TooMany { child: child.to_owned() });
        }
        Ok(())
    }
}

impl Edge {
    fn new(parent: &str, transform: &StampedTransform) -> Self {
        let motion = match transform.validity {
            Validity::Always => Motion::Fixed(transform.parent_from_child),
            Validity::At(time_ns) => Motion::Moving(History::new(time_ns, transform.parent_from_child)),
        };
        Self { parent: parent.to_owned(), motion }
    }

    /// Whether its publisher is gone: another one may say where the frame is now.
    fn is_over(&self, validity: Validity) -> bool {
        match (&self.motion, validity) {
            (Motion::Moving(history), Validity::At(time_ns)) => {
                history.newest_ns().is_none_or(|newest_ns| time_ns.saturating_sub(newest_ns) > KEPT_NS)
            }
            _ => false,
        }
    }

    fn check(&self, parent: &str, child: &str, validity: Validity) -> Result<(), TransformError> {
        let child = child.to_owned();
        if self.parent != parent {
            let (first, second) = (self.parent.clone(), parent.to_owned());
            return Err(TransformError::TwoParents { child, first, second });
        }
        match (&self.motion, validity) {
            (Motion::Fixed(_), Validity::At(_)) => {
                Err(TransformError::TwoKinds { child, first: "static", second: "moving" })
            }
            (Motion::Moving(_), Validity::Always) => {
                Err(TransformError::TwoKinds { child, first: "moving", second: "static" })
            }
            _ => Ok(()),
        }
    }
}

fn bare(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

#[cfg(test)]
mod tests;
