//! A robot's own side: from what its cameras detect to evidence, and from a waypoint to motion.
