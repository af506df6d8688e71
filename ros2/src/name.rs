//! ROS 2 names: letters, digits and `_`, in parts between slashes, none of which begins with a digit.

use std::fmt;
use std::str::FromStr;

/// The maximum length of a name, characters: that of DDS.
const MAX_LENGTH: usize = 247;

/// An invalid ROS name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{found:?} is no name of a ROS 2 {what}: {allowed}")]
pub struct NameError {
    found: String,
    what: &'static str,
    allowed: &'static str,
}

/// The namespace of names without a leading slash: `/` or `/robot1`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Namespace(String);

impl Default for Namespace {
    /// The root.
    fn default() -> Self {
        Self("/".to_owned())
    }
}

impl fmt::Display for Namespace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl FromStr for Namespace {
    type Err = NameError;

    /// With or without the leading slash; the empty text is the root.
    fn from_str(text: &str) -> Result<Self, NameError> {
        let name = text.strip_prefix('/').unwrap_or(text);
        if name.is_empty() || are_parts(name) {
            return Ok(Self(format!("/{name}")));
        }
        let allowed = "allowed are parts of a-z, A-Z, 0-9 and _ between slashes, such as /robot1, or nothing";
        Err(NameError { found: shown(text), what: "namespace", allowed })
    }
}

/// A node's own name, such as `dragnet`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeName(String);

impl fmt::Display for NodeName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl FromStr for NodeName {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        if are_parts(text) && !text.contains('/') {
            return Ok(Self(text.to_owned()));
        }
        let allowed = "allowed are a-z, A-Z, 0-9 and _, the first one no digit";
        Err(NameError { found: shown(text), what: "node", allowed })
    }
}

/// A topic by its full name, such as `/robot1/odom`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TopicName(String);

impl TopicName {
    /// Resolves a name for a node in a namespace: one with a leading slash is absolute, one that begins with `~/` is
    /// private to the node, any other is relative to the namespace.
    ///
    /// # Errors
    /// If the name is invalid.
    pub fn resolve(text: &str, namespace: &Namespace, node: &NodeName) -> Result<Self, NameError> {
        let home = if namespace.0 == "/" { "" } else { &namespace.0 };
        let (prefix, name) = match (text.strip_prefix('/'), text.strip_prefix("~/")) {
            (Some(name), _) => (String::new(), name),
            (_, Some(name)) => (format!("{home}/{node}"), name),
            _ => (home.to_owned(), text),
        };
        let whole = format!("{prefix}/{name}");
        if are_parts(name) && whole.len() <= MAX_LENGTH {
            return Ok(Self(whole));
        }
        let allowed = "allowed are parts of a-z, A-Z, 0-9 and _ between slashes, none of which begins with a digit, \
                       such as odom, /robot1/odom or ~/belief; 247 characters in all";
        Err(NameError { found: shown(text), what: "topic", allowed })
    }

    /// The name without its leading slash, as used in keys.
    #[must_use]
    pub fn chunks(&self) -> &str {
        &self.0[1..]
    }
}

impl fmt::Display for TopicName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

fn are_parts(name: &str) -> bool {
    name.len() <= MAX_LENGTH && name.split('/').all(is_part)
}

fn is_part(part: &str) -> bool {
    let begins = part.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    begins && part.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// The name, shortened for error messages.
fn shown(text: &str) -> String {
    text.chars().take(MAX_LENGTH).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_is_named_as_ros_resolves_it() {
        let check = |namespace: &str, name: &str, expected: &str| {
            let (namespace, node) = (namespace.parse().unwrap(), "dragnet".parse().unwrap());
            let topic = TopicName::resolve(name, &namespace, &node).unwrap();
            assert_eq!((topic.to_string().as_str(), topic.chunks()), (expected, &expected[1..]));
        };
        check("", "odom", "/odom");
        check("/", "a/_action/status", "/a/_action/status");
        check("robot1", "odom", "/robot1/odom");
        check("/fleet/robot1", "/odom", "/odom");
        check("/robot1", "~/belief", "/robot1/dragnet/belief");
        check("", "~/belief", "/dragnet/belief");
    }

    #[test]
    fn invalid_ros_names_are_rejected_with_the_allowed_ones() {
        let (root, node) = (Namespace::default(), "dragnet".parse().unwrap());
        for name in
            ["", "/", "a//b", "a/", "2d", "a/2d", "odöm", "a b", "*", "a/**", "$x", "~odom", "@a", "{node}/a"]
        {
            let error = TopicName::resolve(name, &root, &node).unwrap_err().to_string();
            assert!(error.contains("is no name of a ROS 2 topic: allowed are"), "{name}: {error}");
        }
        assert!(TopicName::resolve(&"a".repeat(247), &root, &node).is_err());
        assert!("a/".parse::<Namespace>().is_err() && "1".parse::<Namespace>().is_err());
        assert!("a/b".parse::<NodeName>().is_err() && "".parse::<NodeName>().is_err());
    }
}
