//! What a recorded mission believed at a time, for the next one: the text of a belief file, which a scenario names as its prior.

use dragnet_coordinator::fold::MissionFold;
use dragnet_coordinator::playback::Playback;
use dragnet_scenario::map_file::{BeliefFile, GeoPoint};
use dragnet_scenario::time::MissionTime;
use dragnet_search::subjects::SubjectPosterior;

use crate::ExportError;
use crate::account::earth;

/// The belief of a recording at the time `until`, or at its end, with all marks and verdicts of the operator. `origin` is the
/// position of the map's south-western corner, for a recording without a position on the earth; without either, the belief
/// fits the same map only.
///
/// # Errors
/// If the recording has a position on the earth and `origin` gives another.
pub fn belief_file(
    playback: &Playback,
    origin: Option<GeoPoint>,
    until: Option<MissionTime>,
) -> Result<BeliefFile, ExportError> {
    let frame = match earth(playback, origin) {
        Ok(earth) => Some(earth.frame),
        Err(ExportError::NoOrigin) => None,
        Err(error) => return Err(error),
    };
    let mut fold = MissionFold::of(playback);
    let until = until.unwrap_or_else(|| playback.end());
    for (_, record) in playback.records.iter().take_while(|(time, _)| *time <= until) {
        fold.take(record);
    }
    let mission = playback.run.get("scenario").map_or("recording", String::as_str);
    let several = playback.subjects().filter(|subjects| subjects.number() > 1);
    let one = playback.subjects().filter(|_| several.is_none()).map(|it| it.posterior(fold.belief()));
    let probability = |cell| match &one {
        Some(subject) => subject.probability(cell),
        None => fold.belief().probability(cell),
    };
    let rest_of_world = one.as_ref().map(SubjectPosterior::rest_of_world);
    let terrain = fold.terrain();
    let file = BeliefFile::new(mission, terrain, frame.as_ref(), playback.origin, probability, rest_of_world);
    Ok(match several {
        Some(subjects) => file.of_several(subjects),
        None => file,
    })
}
