//! Keys, liveliness tokens and attachments of `rmw_zenoh` (ROS 2 Jazzy, 0.2.4 and later).
//!
//! ```text
//! <domain>/<topic>/<DDS type>/<type hash>                                                         data
//! @ros2_lv/<domain>/<session>/<node>/<node>/NN/%/<namespace>/<name>                               a node
//! @ros2_lv/<domain>/<session>/<node>/<entity>/MP|MS/%/<namespace>/<name>/<topic>/<type>/<hash>/<qos>   its topics
//! ```
//!
//! In tokens each `/` of a name is `%`, and so is an empty name.

use std::fmt;

use xxhash_rust::xxh3::xxh3_128;

use super::name::{Namespace, NodeName, TopicName};
use super::qos::Qos;
use crate::schema::MessageType;

/// The prefix of all tokens.
const ADMIN: &str = "@ros2_lv";
/// Between a namespace's and a topic's parts in a token.
const SLASH: &str = "%";

/// The key of a topic. A publisher of another type uses another key and is not received.
#[must_use]
pub fn data_key(domain: u32, topic: &TopicName, message: &MessageType) -> String {
    format!("{domain}/{}/{}/{}", topic.chunks(), message.dds_name(), message.hash)
}

/// A node of the ROS graph. It is the only node of its Zenoh session, with number 0.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its domain, 0 to 232.
    pub domain: u32,
    /// The id of its Zenoh session.
    pub session: String,
    /// Its namespace.
    pub namespace: Namespace,
    /// Its name.
    pub name: NodeName,
}

/// The role of a node at a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The node publishes on the topic.
    Publisher,
    /// The node subscribes to the topic.
    Subscription,
}

impl Node {
    /// The liveliness token of the node.
    #[must_use]
    pub fn token(&self) -> String {
        format!("{}/0/NN/{}", self.begin(), self.end())
    }

    /// The liveliness token of a publisher or subscriber of the node, with this entity number, from 1.
    #[must_use]
    pub fn topic_token(
        &self,
        entity: usize,
        role: Role,
        topic: &TopicName,
        message: &MessageType,
        qos: Qos,
    ) -> String {
        let role = match role {
            Role::Publisher => "MP",
            Role::Subscription => "MS",
        };
        let (topic, dds) = (mangled(topic), message.dds_name());
        format!("{}/{entity}/{role}/{}/{topic}/{dds}/{}/{qos}", self.begin(), self.end(), message.hash)
    }

    fn begin(&self) -> String {
        format!("{ADMIN}/{}/{}/0", self.domain, self.session)
    }

    fn end(&self) -> String {
        format!("{SLASH}/{}/{}", mangled(&self.namespace), self.name)
    }
}

fn mangled(name: &impl fmt::Display) -> String {
    name.to_string().replace('/', SLASH)
}

/// Key expression of the tokens of all publishers of a topic, of any type.
#[must_use]
pub fn publishers(domain: u32, topic: &TopicName) -> String {
    format!("{ADMIN}/{domain}/*/*/*/MP/*/*/*/{}/**", mangled(topic))
}

/// A publisher, from its token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Publisher {
    /// Namespace and name of its node.
    pub node: String,
    /// Its type as mangled by DDS.
    pub dds_name: String,
    /// The hash of its type's definition.
    pub hash: String,
}

impl Publisher {
    /// Parses a token of [`publishers`]; `None` if it is invalid.
    #[must_use]
    pub fn from_token(token: &str) -> Option<Self> {
        let chunks: Vec<&str> = token.split('/').collect();
        let [ADMIN, _, _, _, _, "MP", _, namespace, node, _, dds_name, hash, _] = chunks[..] else {
            return None;
        };
        let namespace = namespace.replace(SLASH, "/");
        let node = format!("{}/{node}", namespace.trim_end_matches('/'));
        Some(Self { node, dds_name: dds_name.to_owned(), hash: hash.to_owned() })
    }

    /// Why a subscriber of a type does not receive this publisher's messages; `None` if it does.
    #[must_use]
    pub fn mismatch(&self, expected: &MessageType) -> Option<String> {
        let node = &self.node;
        if self.dds_name != expected.dds_name() {
            let found = self.dds_name.replace("::dds_::", "::").replace("::", "/");
            let found = found.trim_end_matches('_');
            Some(format!("node {node} publishes it as {found}; allowed is {}", expected.name))
        } else if self.hash != expected.hash {
            Some(format!(
                "node {node} publishes another definition of {}, type hash {}; allowed is {}, that of ROS 2 Jazzy",
                expected.name, self.hash, expected.hash
            ))
        } else {
            None
        }
    }
}

/// The attachments of one publisher's messages: sequence number, time and sender. Without them nodes of `rmw_zenoh`
/// drop the message.
#[derive(Clone, Copy, Debug)]
pub struct Attachments {
    publisher: [u8; 16],
    count: i64,
}

impl Attachments {
    /// The attachments of the publisher with this token; the token's hash is its identifier.
    #[must_use]
    pub fn of(token: &str) -> Self {
        Self { publisher: xxh3_128(token.as_bytes()).to_le_bytes(), count: 0 }
    }

    /// The attachment of its next message, sent at a Unix time in nanoseconds: 33 bytes.
    #[must_use]
    pub fn next(&mut self, unix_ns: i64) -> Vec<u8> {
        self.count += 1;
        let mut bytes = Vec::with_capacity(33);
        bytes.extend(self.count.to_le_bytes());
        bytes.extend(unix_ns.to_le_bytes());
        bytes.push(16);
        bytes.extend(self.publisher);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;
    use crate::wire::standard::PoseStamped;

    const HASH: &str = "RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8";

    fn node(namespace: &str) -> Node {
        Node {
            domain: 7,
            session: "a1b2".into(),
            namespace: namespace.parse().unwrap(),
            name: "dragnet".parse().unwrap(),
        }
    }

    fn topic(node: &Node, name: &str) -> TopicName {
        TopicName::resolve(name, &node.namespace, &node.name).unwrap()
    }

    #[test]
    fn keys_and_tokens_are_those_of_rmw_zenoh() {
        let node = node("/robot1");
        let (topic, message) = (topic(&node, "goal_pose"), MessageType::of::<PoseStamped>());
        let key = format!("7/robot1/goal_pose/geometry_msgs::msg::dds_::PoseStamped_/{HASH}");
        assert_eq!(data_key(7, &topic, &message), key);
        assert_eq!(node.token(), "@ros2_lv/7/a1b2/0/0/NN/%/%robot1/dragnet");
        let token = format!(
            "@ros2_lv/7/a1b2/0/3/MP/%/%robot1/dragnet/%robot1%goal_pose/geometry_msgs::msg::dds_::PoseStamped_/{HASH}/::,10:,:,:,,"
        );
        assert_eq!(node.topic_token(3, Role::Publisher, &topic, &message, Qos::RELIABLE), token);
        assert_eq!(publishers(7, &topic), "@ros2_lv/7/*/*/*/MP/*/*/*/%robot1%goal_pose/**");
    }

    #[test]
    fn a_publisher_of_another_type_or_definition_is_reported_by_name() {
        let check = |namespace: &str, type_and_hash: &str, expected: Option<&str>| {
            let token =
                format!("@ros2_lv/7/c/0/3/MP/%/{namespace}/driver/%odom/{type_and_hash}/::,10:,:,:,,");
            let publisher = Publisher::from_token(&token).unwrap();
            let reported = publisher.mismatch(&MessageType::of::<PoseStamped>());
            assert_eq!(reported.is_some(), expected.is_some(), "{reported:?}");
            assert_mentions(&reported.unwrap_or_default(), expected.unwrap_or_default());
        };
        check("%", &format!("geometry_msgs::msg::dds_::PoseStamped_/{HASH}"), None);
        let wrong = "/a/b/driver .. nav_msgs/msg/Odometry .. geometry_msgs/msg/PoseStamped";
        check("%a%b", "nav_msgs::msg::dds_::Odometry_/RIHS01_00", Some(wrong));
        let other = "/driver .. another definition .. geometry_msgs/msg/PoseStamped .. RIHS01_00";
        check("%", "geometry_msgs::msg::dds_::PoseStamped_/RIHS01_00", Some(other));
    }

    #[test]
    fn a_token_of_another_kind_is_ignored() {
        for token in [
            "",
            "@ros2_lv/7/a/0/0/NN/%/%/n",
            "a/7/c/0/3/MP/%/%/d/%o/T/H/q",
            "@ros2_lv/7/c/0/3/MS/%/%/d/%o/T/H/q",
        ] {
            assert_eq!(Publisher::from_token(token), None, "{token}");
        }
    }

    #[test]
    fn attachments_count_from_one_and_name_their_publisher() {
        let mut attachments = Attachments::of("@ros2_lv/0/token");
        let (first, second) = (attachments.next(5), attachments.next(-1));
        assert_eq!((first.len(), first[..8].to_vec(), first[16]), (33, vec![1, 0, 0, 0, 0, 0, 0, 0], 16));
        assert_eq!((second[0], &second[8..16]), (2, &[255; 8][..]));
        assert_eq!(first[17..], second[17..]);
        assert_ne!(first[17..], Attachments::of("@ros2_lv/0/other").next(5)[17..]);
    }
}
