//! The paper's four maps, from the scenarios of this repository. They are built in, so that the report can be made
//! anywhere.

use std::path::Path;

use dragnet_learn::policy::Shipped;
use dragnet_scenario::Scenario;
use dragnet_scenario::shipped::FOLDER;

use crate::ExperimentError;

/// A map of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Map {
    IceCreamCone,
    OpenAsterisk,
    FigureFour,
    AllTraversable,
}

/// Number of cells on a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Size {
    Thirty,
    Sixty,
}

impl Map {
    /// In the order of the paper's Table II.
    pub(super) const ALL: [Self; 4] =
        [Self::IceCreamCone, Self::OpenAsterisk, Self::FigureFour, Self::AllTraversable];

    /// The paper's abbreviation.
    pub(super) const fn short(self) -> &'static str {
        match self {
            Self::IceCreamCone => "ICC",
            Self::OpenAsterisk => "OA",
            Self::FigureFour => "Four",
            Self::AllTraversable => "AT",
        }
    }

    pub(super) const fn title(self) -> &'static str {
        match self {
            Self::IceCreamCone => "Ice cream cone",
            Self::OpenAsterisk => "Open asterisk",
            Self::FigureFour => "Figure four",
            Self::AllTraversable => "All traversable",
        }
    }

    /// The clone of `greedy` that was trained on this map.
    pub(super) const fn greedy_clone(self) -> Shipped {
        match self {
            Self::IceCreamCone => Shipped::GreedyIceCreamCone,
            Self::OpenAsterisk => Shipped::GreedyOpenAsterisk,
            Self::FigureFour => Shipped::GreedyFigureFour,
            Self::AllTraversable => Shipped::GreedyAllTraversable,
        }
    }

    /// Its scenario: one robot, an object in 20 % of the cells.
    pub(super) fn scenario(self, size: Size) -> Result<Scenario, ExperimentError> {
        let map = match self {
            Self::IceCreamCone => "ice_cream_cone",
            Self::OpenAsterisk => "open_asterisk",
            Self::FigureFour => "figure_four",
            Self::AllTraversable => "all_traversable",
        };
        let enlarged = match size {
            Size::Thirty => "",
            Size::Sixty => "_60",
        };
        Scenario::load(Path::new(&format!("{FOLDER}/paper/{map}{enlarged}.toml")))
            .map_err(ExperimentError::run)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_map_is_there_in_both_sizes() {
        for map in Map::ALL {
            for (size, side) in [(Size::Thirty, 30), (Size::Sixty, 60)] {
                let scenario = map.scenario(size).unwrap();
                let grid = scenario.terrain().grid();
                assert_eq!((grid.rows(), grid.columns()), (side, side), "{map:?}");
                let shape = scenario.file().map.shape.as_deref().unwrap();
                assert_eq!(shape.replace('_', " "), map.title().to_lowercase());
            }
        }
    }
}
