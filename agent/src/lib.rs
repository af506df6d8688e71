//! One robot of a search team: a state machine, and its Zenoh link.
