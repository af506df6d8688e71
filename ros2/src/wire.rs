//! Messages on the wire: plain structs with the fields of a ROS 2 message, in order.
//!
//! Values are not checked here but in [`crate::input`]. Their layout is given by the `.msg` files in [`crate::schema`],
//! their bytes by [`crate::cdr`].

mod bytes;
pub mod markers;
pub mod robot;
pub mod standard;
pub mod vision;
