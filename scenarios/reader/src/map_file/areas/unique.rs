//! Whether each key of a JSON text is there once in its object. Parsers take the last of two and say nothing; what the first
//! one said may be that nobody enters an area.

use std::collections::BTreeSet;
use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

/// Goes through a text; what is no JSON at all is told by whoever reads it.
///
/// # Errors
/// The first key that its object has twice, with line and column.
pub(super) fn check(text: &str) -> Result<(), serde_json::Error> {
    match serde_json::from_str::<Unique>(text) {
        Err(error) if error.is_data() => Err(error),
        _ => Ok(()),
    }
}

struct Unique;

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Unique)
    }
}

impl<'de> Visitor<'de> for Unique {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("JSON")
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_unit<E>(self) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self, A::Error> {
        while list.next_element::<Self>()?.is_some() {}
        Ok(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut object: A) -> Result<Self, A::Error> {
        let mut keys = BTreeSet::new();
        while let Some(key) = object.next_key::<String>()? {
            let shown: String = key.chars().take(40).collect();
            if !keys.insert(key) {
                return Err(A::Error::custom(format!(
                    "{shown:?} stands twice in one object; allowed is each key once"
                )));
            }
            object.next_value::<Self>()?;
        }
        Ok(self)
    }
}
