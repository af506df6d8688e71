//! SBPL's `.mprim` text: reading and writing of motion primitives.
//!
//! ```text
//! resolution_m: 0.1
//! numberofangles: 16
//! totalnumberofprimitives: 64
//! primID: 0
//! startangle_c: 0
//! endpose_c: 1 0 0
//! additionalactioncostmult: 1
//! intermediateposes: 3
//! 0 0 0
//! 0.05 0 0
//! 0.1 0 0
//! ...
//! ```
//!
//! Fields stand in this order, separated by any white space, as SBPL reads them. Heading `i` is nominally at
//! `i * 2 pi / numberofangles`; `endpose_c` may count headings backwards from 0, as SBPL's own generators do.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::primitives::{
    MAX_COST_MULTIPLIER, MAX_HEADINGS, MAX_POSES, MAX_PRIMITIVES, MAX_REACH_CELLS, Part, Primitive,
    PrimitiveSet, Unsound, check,
};
use crate::plane::Pose;

/// Where a text is invalid, and why.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct MprimError {
    /// From 1.
    pub line: usize,
    /// The problem.
    pub problem: MprimProblem,
}

/// A problem with a text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MprimProblem {
    /// Unexpected text.
    #[error("{found:?} where {expected} should stand")]
    Found {
        /// The expected text.
        expected: &'static str,
        /// The text found.
        found: String,
    },
    /// The text is too short.
    #[error("the text ends where {0} should stand")]
    Ends(&'static str),
    /// There are more primitives than were announced.
    #[error("{found:?} after the last of {announced} primitives, which `totalnumberofprimitives` announced")]
    TooMany {
        /// The announced number.
        announced: usize,
        /// The following text.
        found: String,
    },
    /// Primitives that cannot be driven.
    #[error(transparent)]
    Unsound(#[from] Unsound),
}

/// Reads a set.
///
/// # Errors
/// If a field is missing or out of its range, a count is wrong, a primitive's poses do not lead from its start to its
/// end, or a heading has no primitive: with the line.
pub fn read(text: &str) -> Result<PrimitiveSet, MprimError> {
    let mut reader = Reader::new(text);
    let resolution_meters = reader.float("resolution_m:")?;
    if !(resolution_meters.is_finite() && resolution_meters > 0.0) {
        return Err(reader.error(Unsound::Resolution(resolution_meters)));
    }
    let heading_count = reader.count("numberofangles:", MAX_HEADINGS, Unsound::HeadingCount)?;
    let announced = reader.count("totalnumberofprimitives:", MAX_PRIMITIVES, Unsound::PrimitiveCount)?;
    let mut names = BTreeSet::new();
    let mut primitives = Vec::new();
    for _ in 0..announced {
        let primitive = reader.primitive(resolution_meters, heading_count)?;
        let (number, heading) = (primitive.number, primitive.start_heading);
        if !names.insert((number, heading)) {
            return Err(reader.error(Unsound::Twice { number, heading }));
        }
        primitives.push(primitive);
    }
    if let Some((line, found)) = reader.token() {
        let problem = MprimProblem::TooMany { announced, found: found.to_owned() };
        return Err(MprimError { line, problem });
    }
    PrimitiveSet::assemble(resolution_meters, heading_count, primitives)
        .map_err(|unsound| reader.error(unsound))
}

/// Writes a set. Numbers are as short as they can be read back exactly, so that [`read`] returns the same set.
#[must_use]
pub fn write(set: &PrimitiveSet) -> String {
    let mut text = format!(
        "resolution_m: {}\nnumberofangles: {}\ntotalnumberofprimitives: {}\n",
        set.resolution_meters(),
        set.headings_radians().len(),
        set.primitives().len(),
    );
    for primitive in set.primitives() {
        let Primitive { number, start_heading, end_heading, east_cells, north_cells, cost_multiplier, poses } =
            primitive;
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "primID: {number}\nstartangle_c: {start_heading}\nendpose_c: {east_cells} {north_cells} {end_heading}\n\
             additionalactioncostmult: {cost_multiplier}\nintermediateposes: {}\n",
            poses.len()
        );
        for Pose { x_meters, y_meters, heading_radians } in poses {
            let _ = writeln!(text, "{x_meters} {y_meters} {heading_radians}");
        }
    }
    text
}

/// The words of a text with their lines.
struct Reader<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    words: std::str::SplitAsciiWhitespace<'a>,
    /// Line of the last word, from 1.
    line: usize,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Self {
        Self { lines: text.lines().enumerate(), words: "".split_ascii_whitespace(), line: 1 }
    }

    fn token(&mut self) -> Option<(usize, &'a str)> {
        loop {
            if let Some(word) = self.words.next() {
                return Some((self.line, word));
            }
            let (index, line) = self.lines.next()?;
            self.line = index + 1;
            self.words = line.split_ascii_whitespace();
        }
    }

    fn error(&self, problem: impl Into<MprimProblem>) -> MprimError {
        MprimError { line: self.line, problem: problem.into() }
    }

    fn number<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, MprimError> {
        let Some((_, word)) = self.token() else {
            return Err(self.error(MprimProblem::Ends(expected)));
        };
        word.parse().map_err(|_| self.error(MprimProblem::Found { expected, found: word.to_owned() }))
    }

    fn key(&mut self, key: &'static str) -> Result<(), MprimError> {
        match self.token() {
            Some((_, word)) if word == key => Ok(()),
            Some((_, word)) => Err(self.error(MprimProblem::Found { expected: key, found: word.to_owned() })),
            None => Err(self.error(MprimProblem::Ends(key))),
        }
    }

    fn float(&mut self, key: &'static str) -> Result<f64, MprimError> {
        self.key(key)?;
        self.number("a number")
    }

    fn integer(&mut self, key: &'static str) -> Result<i64, MprimError> {
        self.key(key)?;
        self.number("an integer")
    }

    fn count(
        &mut self,
        key: &'static str,
        most: usize,
        unsound: fn(u64) -> Unsound,
    ) -> Result<usize, MprimError> {
        self.key(key)?;
        let given: u64 = self.number("a count")?;
        let count = usize::try_from(given).ok().filter(|count| (1..=most).contains(count));
        count.ok_or_else(|| self.error(unsound(given)))
    }

    fn reach(&mut self) -> Result<i32, MprimError> {
        let given: i64 = self.number("an integer")?;
        let cells =
            i32::try_from(given).ok().filter(|cells| (-MAX_REACH_CELLS..=MAX_REACH_CELLS).contains(cells));
        cells.ok_or_else(|| self.error(Unsound::Reach { given }))
    }

    fn heading(&self, given: i64, least: i64, heading_count: usize) -> Result<usize, MprimError> {
        let heading_count = i64::try_from(heading_count).unwrap_or(i64::MAX);
        let heading = (least..heading_count).contains(&given).then(|| given.rem_euclid(heading_count));
        heading
            .and_then(|heading| usize::try_from(heading).ok())
            .ok_or_else(|| self.error(Unsound::Heading { given, least, heading_count }))
    }

    fn primitive(&mut self, resolution_meters: f64, heading_count: usize) -> Result<Primitive, MprimError> {
        self.key("primID:")?;
        let number = self.number("a number of a primitive")?;
        let number_line = self.line;
        let given = self.integer("startangle_c:")?;
        let start_heading = self.heading(given, 0, heading_count)?;
        self.key("endpose_c:")?;
        let (east_cells, north_cells) = (self.reach()?, self.reach()?);
        let given = self.number("an integer")?;
        let least = 1 - i64::try_from(heading_count).unwrap_or(i64::MAX);
        let end_heading = self.heading(given, least, heading_count)?;
        let end_line = self.line;
        let given = self.integer("additionalactioncostmult:")?;
        let cost_multiplier = u32::try_from(given)
            .ok()
            .filter(|multiplier| (1..=MAX_COST_MULTIPLIER).contains(multiplier))
            .ok_or_else(|| self.error(Unsound::CostMultiplier(given)))?;
        let pose_count = self.count("intermediateposes:", MAX_POSES, Unsound::PoseCount)?;
        if pose_count < 2 {
            return Err(self.error(Unsound::PoseCount(pose_count as u64)));
        }
        let mut poses = Vec::with_capacity(pose_count);
        let mut lines = Vec::with_capacity(pose_count);
        for _ in 0..pose_count {
            let x_meters = self.number("a number of an intermediate pose")?;
            lines.push(self.line);
            let y_meters = self.number("a number of an intermediate pose")?;
            let heading_radians = self.number("a number of an intermediate pose")?;
            poses.push(Pose { x_meters, y_meters, heading_radians });
        }
        let primitive =
            Primitive { number, start_heading, end_heading, east_cells, north_cells, cost_multiplier, poses };
        check(&primitive, resolution_meters, heading_count).map_err(|(part, unsound)| MprimError {
            line: match part {
                Part::Number => number_line,
                Part::End => end_line,
                Part::Pose(index) => lines.get(index).copied().unwrap_or(number_line),
            },
            problem: unsound.into(),
        })?;
        Ok(primitive)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mentions::assert_mentions;

    /// Four headings, one step forward each. As SBPL's generators write: headings counted backward from 0, rounded
    /// numbers.
    fn cross() -> String {
        let mut text = "resolution_m: 0.100000\nnumberofangles: 4\ntotalnumberofprimitives: 4\n".to_owned();
        for (heading, (east, north)) in [(1, 0), (0, 1), (-1, 0), (0, -1)].into_iter().enumerate() {
            let end = if heading == 3 { -1 } else { i64::try_from(heading).unwrap() };
            let radians = ["0.0000", "1.5708", "3.1416", "-1.5708"][heading];
            let _ = write!(
                text,
                "primID: 0\nstartangle_c: {heading}\nendpose_c: {east} {north} {end}\n\
                 additionalactioncostmult: 1\nintermediateposes: 2\n0.0000 0.0000 {radians}\n{:.4} {:.4} {radians}\n",
                f64::from(east) * 0.1,
                f64::from(north) * 0.1,
            );
        }
        text
    }

    #[test]
    fn a_text_as_sbpl_writes_it_is_read() {
        let set = read(&cross()).unwrap();
        assert_eq!(set.headings_radians().len(), 4);
        assert_eq!(set.primitives()[3].end_heading, 3);
        assert!((set.headings_radians()[3] - 4.7124).abs() < 1e-4);
        assert_eq!(set.nearest_heading(-1.5), 3);
        assert_eq!(read(&write(&set)), Ok(set));
    }

    #[test]
    fn a_bad_text_names_its_line_and_the_allowed_values() {
        let check = |from: &str, to: &str, message: &str| {
            let text = cross().replacen(from, to, 1);
            assert_ne!(text, cross(), "{from} is not there");
            let error = read(&text).unwrap_err().to_string();
            assert_mentions(&error, message);
        };
        check("0.100000", "0", "line 1 .. resolution .. 0 m .. above 0");
        check("0.100000", "NaN", "line 1 .. resolution .. NaN m .. above 0");
        check("angles: 4", "angles: 0", "line 2 .. 0 headings .. 1 to 256");
        check("angles: 4", "angles: 4000000000000", "line 2 .. 4000000000000 headings .. 1 to 256");
        check("angles: 4", "angles: four", "line 2 .. \"four\" .. a count");
        check(
            "angles: 4",
            "angles: 5",
            "line 23 .. start .. (0, 0, 3.1416) .. (0, 0, 2.5132741228718345) .. half a cell .. half a heading step",
        );
        check("primitives: 4", "primitives: 5", "line 31 .. the text ends .. primID:");
        check("primitives: 4", "primitives: 3", "line 25 .. \"primID:\" .. 3 .. `totalnumberofprimitives`");
        check("primitives: 4", "primitives: 0", "line 3 .. 0 primitives .. 1 to 65535");
        check("startangle_c: 0", "startangle_c: 4", "line 5 .. heading 4 .. 0 to 3");
        check("startangle_c: 0", "startangle_c: -1", "line 5 .. heading -1 .. 0 to 3");
        check("endpose_c: 1 0 0", "endpose_c: 1 0 -4", "line 6 .. heading -4 .. -3 to 3");
        check("endpose_c: 1 0 0", "endpose_c: 257 0 0", "line 6 .. 257 cells .. -256 to 256");
        check("endpose_c: 1 0 0", "endpose_c: 0 0 0", "line 6 .. ends where it starts");
        check("mult: 1", "mult: 0", "line 7 .. cost multiplier .. 0 .. 1 to 1000");
        check("poses: 2", "poses: 1", "line 8 .. 1 intermediate poses .. 2 to 1000");
        check("poses: 2", "poses: 3", "line 11 .. \"primID:\" .. intermediate pose");
        check("endpose_c: 1 0 0", "endpose_c: 2 0 0", "line 10 .. end .. (0.1, 0, 0)");
        check("endpose_c: 1 0 0", "endpose_c: 1 0 1", "line 10 .. end .. (0.1, 0, 0)");
        check("0.1000 0.0000 0.0000", "0.1 NaN 0", "line 10 .. (0.1, NaN, 0) .. finite");
        check("0.0000 0.0000 0.0000", "0.06 0 0", "line 9 .. start .. (0.06, 0, 0)");
        check("startangle_c: 1", "startangle_c: 0", "line 16 .. start");
        let last = cross().rfind("primID").unwrap();
        let error = read(&cross()[..last].replacen("primitives: 4", "primitives: 3", 1)).unwrap_err();
        assert_eq!(error.problem, Unsound::NoPrimitive(3).into());
        assert_mentions(&read("").unwrap_err().to_string(), "line 1 .. the text ends .. resolution_m:");
    }

    #[test]
    fn a_repeated_number_is_reported() {
        let first: String = cross().lines().skip(3).take(7).flat_map(|line| [line, "\n"]).collect();
        let text = cross().replacen("primitives: 4", "primitives: 5", 1) + &first;
        assert_eq!(read(&text).unwrap_err().problem, Unsound::Twice { number: 0, heading: 0 }.into());
    }

    proptest! {
        #[test]
        fn no_text_panics(text in ".*") {
            let _ = read(&text);
        }

        /// A valid text with small damage reaches more of the checks.
        #[test]
        fn no_damaged_text_panics(
            word in 0_usize..100,
            by in prop_oneof![
                Just("nan".to_owned()), Just("-1".to_owned()), Just("1e308".to_owned()),
                Just("99999999999999999999".to_owned()), Just("primID:".to_owned()), Just(String::new()),
                any::<i64>().prop_map(|number| number.to_string()), any::<f64>().prop_map(|x| x.to_string()),
            ],
        ) {
            let text = cross();
            let mut words: Vec<&str> = text.split_ascii_whitespace().collect();
            let word = word % words.len();
            words[word] = &by;
            let _ = read(&words.join("\n"));
        }
    }
}
