//! Scenarios that continue an earlier search by an option of the command line.

use std::path::{Path, PathBuf};

use dragnet_runtime::earlier;
use dragnet_scenario::Scenario;

use super::{Failure, complain, scenario};

/// What a search begins with.
#[derive(clap::Args)]
pub(super) struct PriorFrom {
    /// Begin with what an earlier search believed in the end, from its recording (MCAP) or a belief file (.belief.json):
    /// where both search, that is the prior. Area and cells may be others, if both maps have a position on the earth
    #[arg(long, value_name = "RECORDING")]
    prior_from: Option<PathBuf>,
}

impl PriorFrom {
    /// The scenario that continues the earlier search, if the option is given.
    pub(super) fn continued(&self, scenario: Scenario) -> Result<Scenario, String> {
        let Some(file) = &self.prior_from else { return Ok(scenario) };
        earlier::continuing(&scenario, file).map_err(|reason| format!("--prior-from: {reason}"))
    }

    /// Reads a scenario, and continues the earlier search if the option is given.
    pub(super) fn load(&self, path: &Path) -> Result<Scenario, Failure> {
        self.continued(scenario::load(path)?).map_err(Failure::Input)
    }

    /// Whether the option is given.
    pub(super) const fn is_given(&self) -> bool {
        self.prior_from.is_some()
    }
}

/// What a scenario continues, in words, if anything.
pub(super) fn continues(scenario: &Scenario) -> Option<String> {
    let (earlier, share) = (scenario.earlier()?, scenario.continued_share()?);
    let (file, mission) = (earlier.file.display(), &earlier.belief.mission);
    let expected: f64 = scenario.prior().probabilities().iter().sum();
    let begins = match scenario.subjects() {
        Some(one) if one.number() == 1 => format!(
            "the subject is in the area with {expected:.4}, outside of it with {:.4}",
            one.rest_of_world()
        ),
        Some(subjects) => {
            let outside = subjects.posterior(scenario.prior()).rest_of_world();
            let number = subjects.number();
            format!(
                "of {number} subjects, {:.4} are expected in the area, {outside:.4} outside of it",
                f64::from(number) - outside
            )
        }
        None => format!("{expected:.2} objects expected"),
    };
    Some(format!(
        "continues {mission} ({file}), which covers {:.1} % of the searched cells: {begins}",
        100.0 * share
    ))
}

/// Prints what a scenario continues, if anything.
pub(super) fn tell(scenario: &Scenario) {
    if let Some(text) = continues(scenario) {
        complain("prior", &text);
    }
}
