//! A mission that continues an earlier one: its recording becomes the prior.

use std::path::Path;

use dragnet_coordinator::Ending;
use dragnet_coordinator::playback::Playback;
use dragnet_export::belief::belief_file;
use dragnet_scenario::map_file::BeliefFile;
use dragnet_scenario::{EarlierBelief, Scenario};

/// A scenario that begins with what an earlier search believed in the end, from its recording or from a belief file
/// (`.belief.json`). Where the earlier search did not search, the scenario keeps its own prior. Of a damaged recording the
/// intact part counts, which is logged as a warning.
///
/// # Errors
/// If the file cannot be read or is neither, or as [`Scenario::continuing`]: a message that names the file.
pub fn continuing(scenario: &Scenario, file: &Path) -> Result<Scenario, String> {
    let belief = if BeliefFile::is_file(file) {
        BeliefFile::load(file).map_err(|error| error.to_string())?
    } else {
        let playback = Playback::read(file).map_err(|error| error.to_string())?;
        if playback.ending != Ending::Complete {
            let (file, ending) = (file.display(), &playback.ending);
            tracing::warn!("{file}: is {ending}; what is whole of it is the prior");
        }
        belief_file(&playback, None, None).map_err(|error| format!("{}: {error}", file.display()))?
    };
    let earlier = EarlierBelief { file: file.to_owned(), belief };
    scenario.continuing(earlier).map_err(|error| error.to_string())
}
