//! An independent reader of messages, driven by the text of a schema.

use dragnet_ros2::cdr;
use dragnet_ros2::schema::RosMessage;
use serde_json::{Map, Value};

/// Reads CDR by a schema, as a viewer does.
struct Reader<'a> {
    definitions: Vec<(&'a str, &'a str)>,
    body: &'a [u8],
    position: usize,
}

impl<'a> Reader<'a> {
    fn new(name: &'a str, schema: &'a str, bytes: &'a [u8]) -> Self {
        let separator = format!("\n{}\nMSG: ", "=".repeat(80));
        let mut parts = schema.split(separator.as_str());
        let mut definitions = vec![(name, parts.next().unwrap())];
        definitions.extend(parts.map(|part| part.split_once('\n').unwrap()));
        Self { definitions, body: &bytes[4..], position: 0 }
    }

    fn bytes<const SIZE: usize>(&mut self) -> [u8; SIZE] {
        self.position = self.position.next_multiple_of(SIZE);
        let bytes = self.body[self.position..][..SIZE].try_into().unwrap();
        self.position += SIZE;
        bytes
    }

    fn length(&mut self) -> usize {
        u32::from_le_bytes(self.bytes()) as usize
    }

    fn message(&mut self, name: &str) -> Value {
        let (_, text) = *self.definitions.iter().find(|(known, _)| *known == name).unwrap();
        let fields = text.lines().filter_map(field);
        Value::Object(fields.map(|(kind, name)| (name.to_owned(), self.field(kind))).collect())
    }

    fn field(&mut self, kind: &str) -> Value {
        let Some((element, size)) = kind.split_once('[') else { return self.one(kind) };
        let length = match size.trim_end_matches(']') {
            "" => self.length(),
            fixed => fixed.parse().unwrap(),
        };
        (0..length).map(|_| self.one(element)).collect()
    }

    fn one(&mut self, kind: &str) -> Value {
        match kind {
            "bool" => (self.bytes::<1>()[0] == 1).into(),
            "int8" => i8::from_le_bytes(self.bytes()).into(),
            "uint8" | "byte" => self.bytes::<1>()[0].into(),
            "uint16" => u16::from_le_bytes(self.bytes()).into(),
            "int32" => i32::from_le_bytes(self.bytes()).into(),
            "uint32" => u32::from_le_bytes(self.bytes()).into(),
            "int64" => i64::from_le_bytes(self.bytes()).into(),
            "uint64" => u64::from_le_bytes(self.bytes()).into(),
            "float32" => f32::from_le_bytes(self.bytes()).into(),
            "float64" => f64::from_le_bytes(self.bytes()).into(),
            "string" => {
                let length = self.length();
                let text = &self.body[self.position..][..length - 1];
                self.position += length;
                std::str::from_utf8(text).unwrap().into()
            }
            message => self.message(message),
        }
    }
}

/// Type and name, unless the line is a comment or a constant.
fn field(line: &str) -> Option<(&str, &str)> {
    let line = line.split('#').next().unwrap();
    let mut words = line.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    (!name.contains('=')).then_some((kind, name))
}

/// A different number in every field, and no empty array, so that a swapped or missing field shows.
struct Filler(u8);

impl Filler {
    fn next(&mut self) -> u8 {
        self.0 += 1;
        self.0
    }

    fn fill(&mut self, value: &mut Value, kinds: &Value) {
        match (value, kinds) {
            (Value::Object(fields), Value::Object(kinds)) => {
                for (name, kind) in kinds {
                    self.fill(&mut fields[name], kind);
                }
            }
            (Value::Array(entries), Value::Array(kinds)) => {
                if entries.is_empty() {
                    entries.extend([kinds[0].clone(), kinds[0].clone()]);
                }
                for entry in entries {
                    self.fill(entry, &kinds[0]);
                }
            }
            (value, Value::Bool(_)) => *value = true.into(),
            (value, Value::String(_)) => *value = "x".repeat(self.next().into()).into(),
            (value, Value::Number(number)) if number.is_f64() => {
                *value = (f64::from(self.next()) + 0.5).into();
            }
            (value, _) => *value = self.next().into(),
        }
    }
}

/// The fields of a definition as JSON: numbers 0, arrays of one element.
fn blank(reader: &Reader<'_>, name: &str) -> Value {
    let (_, text) = *reader.definitions.iter().find(|(known, _)| *known == name).unwrap();
    let value = |kind: &str| {
        let (element, size) = kind.split_once('[').unwrap_or((kind, ""));
        let value = match element {
            "bool" => false.into(),
            "string" => "".into(),
            "float32" | "float64" => 0.0.into(),
            message if message.contains('/') => blank(reader, message),
            _ => 0.into(),
        };
        match size.trim_end_matches(']') {
            "" if size.is_empty() => value,
            "" => Value::Array(vec![value]),
            fixed => Value::Array(vec![value; fixed.parse().unwrap()]),
        }
    };
    let fields = text.lines().filter_map(field);
    Value::Object(fields.map(|(kind, name)| (name.to_owned(), value(kind))).collect::<Map<_, _>>())
}

/// Matrices in rows again, as the structs have them: arrays of 3 x 3 or 6 x 6 are nothing else.
fn with_rows(value: Value) -> Value {
    match value {
        Value::Array(entries) if entries.len() == 9 || entries.len() == 36 => {
            entries.chunks(entries.len().isqrt()).map(<[Value]>::to_vec).collect()
        }
        Value::Array(entries) => entries.into_iter().map(with_rows).collect(),
        Value::Object(fields) => {
            fields.into_iter().map(|(name, value)| (name, with_rows(value))).collect::<Map<_, _>>().into()
        }
        other => other,
    }
}

/// Matrices as one array, as they are on the wire.
fn flatten(value: &mut Value) {
    match value {
        Value::Array(entries) if entries.iter().any(Value::is_array) => {
            let rows = entries.drain(..).filter_map(|row| row.as_array().cloned());
            *value = Value::Array(rows.flatten().collect());
        }
        Value::Array(entries) => entries.iter_mut().for_each(flatten),
        Value::Object(fields) => fields.values_mut().for_each(flatten),
        _ => {}
    }
}

/// Checks that a message, filled with a different number in every field, is read by its schema.
pub(crate) fn check<T: RosMessage + Default + serde::de::DeserializeOwned>() {
    let (schema, name) = (T::schema(), T::NAME.replace("/msg/", "/"));
    let kinds = blank(&Reader::new(&name, &schema, &[0; 4]), &name);
    let mut filled = serde_json::to_value(T::default()).unwrap();
    flatten(&mut filled);
    Filler(0).fill(&mut filled, &kinds);
    let message: T = serde_json::from_value(with_rows(filled.clone())).unwrap();

    let bytes = cdr::encode(&message);
    let mut reader = Reader::new(&name, &schema, &bytes);
    assert_eq!(reader.message(&name), filled, "{name}");
    assert_eq!(reader.position, bytes.len() - 4, "{name}: all bytes are read");
}
