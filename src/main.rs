//! The command line of Dragnet.

fn main() {}
