//! What a robot says that lies: each of its lies is one that can be told from the truth.

use std::sync::Arc;

use dragnet_proto::message::Message;
use dragnet_search::observation::Observation;

/// One observation of so many is a lie.
const ONE_OF: u64 = 5;

/// A message as a liar tells it. What it says under one name it says to all, whenever it is asked.
pub(super) fn told(message: &mut Message) {
    match message {
        Message::Observation(observation) => lie(observation),
        Message::SyncReply(reply) => reply.observations.iter_mut().for_each(lie),
        _ => {}
    }
}

/// Every kind of lie has its turn.
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
