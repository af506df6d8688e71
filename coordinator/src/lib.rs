//! The mission seen from outside: declarations, liveness and recording.
