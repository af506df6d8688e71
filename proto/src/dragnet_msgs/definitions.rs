//! The ROS names and definitions of Dragnet's own messages.

use dragnet_ros2::schema::{Definitions, RosMessage};

macro_rules! ros_messages {
    ($($message:ident,)*) => {
        $(impl RosMessage for super::$message {
            fn to_cdr(&self) -> Vec<u8> {
                dragnet_ros2::cdr::encode(self)
            }
            const NAME: &'static str = concat!("dragnet_msgs/msg/", stringify!($message));
            const DEFINITIONS: Definitions = DEFINITIONS;
        })*

        /// Names of all messages.
        pub const NAMES: &[&str] = &[$(concat!("dragnet_msgs/msg/", stringify!($message))),*];

        /// All messages.
        pub const DEFINITIONS: Definitions = &[$((
            concat!("dragnet_msgs/", stringify!($message)),
            include_str!(concat!("../../msg/", stringify!($message), ".msg")),
        )),*];
    };
}

ros_messages! {
    Observation,
    ObjectPosition,
    Intent,
    Heartbeat,
    SyncRequest,
    SyncReply,
    Version,
    Detection,
    MissionStatus,
    Directive,
    Verdicts,
    Orders,
    Zones,
    Mark,
    Marks,
    Picture,
    Step,
    StepReply,
    Sensed,
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use dragnet_ros2::schema::schema;

    use super::*;

    #[test]
    fn a_schema_holds_every_message_in_it_once() {
        for name in NAMES {
            let schema = schema(name, DEFINITIONS);
            let parts: Vec<&str> = schema.lines().filter(|line| line.starts_with("MSG: ")).collect();
            assert_eq!(parts.iter().collect::<BTreeSet<_>>().len(), parts.len(), "{name}: {parts:?}");
        }
    }
}
