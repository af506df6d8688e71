//! The parts of the report, and their names.

use super::study::Study;

/// A table or figure of the paper, or what goes beyond it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Computing time of decisions.
    Table1,
    /// Clones against the greedy expert.
    Figure5,
    /// Clones on larger maps.
    Figure6,
    /// Clones with fewer objects than in training.
    Figure7,
    /// The areas under the curves of Figure 7.
    Table2,
    /// Beliefs and tracks of the two experts.
    Figure8,
    /// The path-integral expert and its clones.
    Figure9,
    /// The field test.
    Table3,
    /// What is not in the paper: planning the whole rest of the search.
    Beyond,
}

impl Part {
    /// In the order of the report.
    const ALL: [Self; 9] = [
        Self::Table1,
        Self::Figure5,
        Self::Figure6,
        Self::Figure7,
        Self::Table2,
        Self::Figure8,
        Self::Figure9,
        Self::Table3,
        Self::Beyond,
    ];

    /// As written on the command line, in links and in names of files.
    pub(super) const fn as_str(self) -> &'static str {
        match self {
            Self::Table1 => "table-1",
            Self::Figure5 => "figure-5",
            Self::Figure6 => "figure-6",
            Self::Figure7 => "figure-7",
            Self::Table2 => "table-2",
            Self::Figure8 => "figure-8",
            Self::Figure9 => "figure-9",
            Self::Table3 => "table-3",
            Self::Beyond => "beyond",
        }
    }

    /// Its heading, with a title.
    pub(super) fn heading(self, title: &str) -> String {
        format!("{}: {title}", self.in_paper())
    }

    /// Its name in the paper.
    pub(super) const fn in_paper(self) -> &'static str {
        match self {
            Self::Table1 => "Table I",
            Self::Figure5 => "Figure 5",
            Self::Figure6 => "Figure 6",
            Self::Figure7 => "Figure 7",
            Self::Table2 => "Table II",
            Self::Figure8 => "Figure 8",
            Self::Figure9 => "Figure 9",
            Self::Table3 => "Table III",
            Self::Beyond => "Beyond the paper",
        }
    }

    /// The comparison that it shows, if any.
    pub(super) const fn study(self) -> Option<Study> {
        match self {
            Self::Table1 | Self::Figure8 | Self::Table3 | Self::Beyond => None,
            Self::Figure5 => Some(Study::Imitation),
            Self::Figure6 => Some(Study::Scale),
            Self::Figure7 | Self::Table2 => Some(Study::Density),
            Self::Figure9 => Some(Study::PathExpert),
        }
    }
}

/// The requested parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Every part.
    All,
    /// One part.
    One(Part),
}

const ALL: &str = "all";

impl Choice {
    /// The name used on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::All => ALL,
            Self::One(part) => part.as_str(),
        }
    }

    pub(super) fn parts(self) -> Vec<Part> {
        match self {
            Self::All => Part::ALL.to_vec(),
            Self::One(part) => vec![part],
        }
    }

    /// Every choice: each part in the order of the report, then all of them.
    pub fn every() -> impl Iterator<Item = Self> {
        Part::ALL.into_iter().map(Self::One).chain([Self::All])
    }
}
