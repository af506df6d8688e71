//! False readings of a faulty robot, each of which validation can detect.

use std::sync::Arc;

use dragnet_proto::message::Message;
use dragnet_search::observation::Observation;

/// One of this many observations is false.
const ONE_OF: u64 = 5;

/// Falsifies a message. An observation is falsified in the same way for all receivers and at every time.
pub(super) fn reported(message: &mut Message) {
    match message {
        Message::Observation(observation) => lie(observation),
        Message::SyncReply(reply) => reply.observations.iter_mut().for_each(lie),
        _ => {}
    }
}

/// All kinds of false readings take turns.
fn lie(observation: &mut Arc<Observation>) {
    if observation.sequence % ONE_OF != ONE_OF - 1 {
        return;
    }
    let lie = Arc::make_mut(observation);
    match lie.sequence / ONE_OF % 5 {
        0 => lie.readings.iter_mut().for_each(|reading| reading.variance /= 2.0),
        1 => lie.readings.iter_mut().for_each(|reading| reading.value += 100.0),
        2 => lie.readings.extend_from_within(..1),
        3 => lie.time_ns = u64::MAX,
        _ => lie.time_ns = 0,
    }
}
