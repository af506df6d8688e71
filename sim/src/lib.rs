//! The world: truth, motion, sensing, network faults and episodes.
