//! Messages on the wire: plain structs with the fields of a ROS 2 message, in order.
//!
//! They know no map and check nothing; [`crate::input`] does. Their layout is given by the `.msg` files in
//! [`crate::schema`], their bytes by [`crate::cdr`].

pub mod robot;
pub mod standard;
pub mod vision;
