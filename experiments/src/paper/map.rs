//! The paper's four maps, from the scenarios of this repository. They are built in, so that the report can be made
//! anywhere.

use std::path::Path;

use dragnet_learn::policy::Shipped;
use dragnet_scenario::Scenario;

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
        let text = self.text(size).to_owned();
        Scenario::from_text(Path::new("scenarios/paper"), text).map_err(ExperimentError::run)
    }

    const fn text(self, size: Size) -> &'static str {
        match (self, size) {
            (Self::IceCreamCone, Size::Thirty) => {
                include_str!("../../../scenarios/paper/ice_cream_cone.toml")
            }
            (Self::OpenAsterisk, Size::Thirty) => include_str!("../../../scenarios/paper/open_asterisk.toml"),
            (Self::FigureFour, Size::Thirty) => include_str!("../../../scenarios/paper/figure_four.toml"),
            (Self::AllTraversable, Size::Thirty) => {
                include_str!("../../../scenarios/paper/all_traversable.toml")
            }
            (Self::IceCreamCone, Size::Sixty) => {
                include_str!("../../../scenarios/paper/ice_cream_cone_60.toml")
            }
            (Self::OpenAsterisk, Size::Sixty) => {
                include_str!("../../../scenarios/paper/open_asterisk_60.toml")
            }
            (Self::FigureFour, Size::Sixty) => include_str!("../../../scenarios/paper/figure_four_60.toml"),
            (Self::AllTraversable, Size::Sixty) => {
                include_str!("../../../scenarios/paper/all_traversable_60.toml")
            }
        }
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
