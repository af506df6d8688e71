//! The parts of the report, and how the command line names them.

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::study::Study;

/// A table or figure of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Table1,
    Figure5,
    Figure6,
    Figure7,
    Table2,
    Figure8,
    Figure9,
    Table3,
}

impl Part {
    /// In the order of the report.
    const ALL: [Self; 8] = [
        Self::Table1,
        Self::Figure5,
        Self::Figure6,
        Self::Figure7,
        Self::Table2,
        Self::Figure8,
        Self::Figure9,
        Self::Table3,
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
        }
    }

    /// As the paper calls it.
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
        }
    }

    /// The comparison that it shows, if it shows one.
    pub(super) const fn study(self) -> Option<Study> {
        match self {
            Self::Table1 | Self::Figure8 | Self::Table3 => None,
            Self::Figure5 => Some(Study::Imitation),
            Self::Figure6 => Some(Study::Scale),
            Self::Figure7 | Self::Table2 => Some(Study::Density),
            Self::Figure9 => Some(Study::PathExpert),
        }
    }
}

/// Which parts are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    All,
    One(Part),
}

const ALL: &str = "all";

impl Choice {
    pub(super) const fn as_str(self) -> &'static str {
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

    /// Reads one from the command line.
    pub(super) fn parser() -> impl TypedValueParser<Value = Self> {
        let names = Part::ALL.map(Part::as_str).into_iter().chain([ALL]);
        PossibleValuesParser::new(names).map(|name| {
            let part = Part::ALL.into_iter().find(|part| part.as_str() == name);
            part.map_or(Self::All, Self::One)
        })
    }
}
