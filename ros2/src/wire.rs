//! Messages as they travel: plain structs whose fields, in order, are those of a ROS 2 message.
//!
//! They know no map and check nothing; [`crate::input`] does. Their layout is given by the `.msg` files that
//! [`crate::schema`] holds, their bytes by [`crate::cdr`].

pub mod robot;
pub mod standard;
pub mod vision;
