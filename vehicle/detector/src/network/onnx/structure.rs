//! The structure of an ONNX file: messages of Protocol Buffers within messages, each of a stated length.
//!
//! <https://protobuf.dev/programming-guides/encoding> says how fields are written, and
//! <https://github.com/onnx/onnx/blob/main/onnx/onnx.proto> which there are.

/// Why this is not the file of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum StructureError {
    /// A message ends within a field.
    #[error("it is cut off, damaged, or something else")]
    Damaged,
    /// A file of messages, but without a graph.
    #[error("there is no graph in it")]
    NoGraph,
    /// A graph within a graph, or a sequence.
    #[error("it has graphs within its graph, or sequences, which no detector needs")]
    Nested,
}

/// A kind of message, as far as others are within it.
#[derive(Clone, Copy)]
enum Message {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    Value,
    Type,
    TensorType,
    Shape,
    /// Numbers and texts alone.
    Plain,
}

/// What a field contains.
enum Content {
    /// Another message.
    Message(Message),
    /// What no detector needs, and may contain itself.
    Nested,
    /// A text, bytes, numbers, or what is not read.
    Bytes,
}

impl Message {
    /// What a field with this number contains, if it has a length.
    const fn content(self, field: u64) -> Content {
        let message = match (self, field) {
            (Self::Model, 7) => Self::Graph,
            (Self::Model, 8 | 14) | (Self::Tensor, 13) | (Self::Shape, 1) => Self::Plain,
            (Self::Graph, 1) => Self::Node,
            (Self::Graph | Self::Attribute, 5) => Self::Tensor,
            (Self::Graph, 11..=13) => Self::Value,
            (Self::Node, 5) => Self::Attribute,
            (Self::Value, 2) => Self::Type,
            (Self::Type, 1) => Self::TensorType,
            (Self::TensorType, 2) => Self::Shape,
            (Self::Attribute, 6 | 11) | (Self::Type, 4) => return Content::Nested,
            _ => return Content::Bytes,
        };
        Content::Message(message)
    }
}

/// Checks that all messages end where they say, and that none contains its own kind.
pub(super) fn check(file: &[u8]) -> Result<(), StructureError> {
    let has_graph = walk(file, Message::Model)?;
    if has_graph { Ok(()) } else { Err(StructureError::NoGraph) }
}

/// Whether a graph is among the fields of a message. Recursion ends: [`Message::content`] has no circles.
fn walk(mut rest: &[u8], message: Message) -> Result<bool, StructureError> {
    let mut has_graph = false;
    while !rest.is_empty() {
        let key = varint(&mut rest)?;
        match key & 7 {
            0 => {
                varint(&mut rest)?;
            }
            1 => {
                take(&mut rest, 8)?;
            }
            2 => {
                let length = varint(&mut rest)?;
                let field = take(&mut rest, length)?;
                match message.content(key >> 3) {
                    Content::Message(inner) => {
                        has_graph |= matches!(inner, Message::Graph);
                        walk(field, inner)?;
                    }
                    Content::Nested => return Err(StructureError::Nested),
                    Content::Bytes => {}
                }
            }
            5 => {
                take(&mut rest, 4)?;
            }
            _ => return Err(StructureError::Damaged),
        }
    }
    Ok(has_graph)
}

/// A number of up to ten bytes, seven bits each, the low ones first.
fn varint(rest: &mut &[u8]) -> Result<u64, StructureError> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let (&byte, after) = rest.split_first().ok_or(StructureError::Damaged)?;
        *rest = after;
        number |= u64::from(byte & 127) << shift;
        if byte < 128 {
            return Ok(number);
        }
    }
    Err(StructureError::Damaged)
}

/// The next bytes.
fn take<'a>(rest: &mut &'a [u8], length: u64) -> Result<&'a [u8], StructureError> {
    let length = usize::try_from(length).ok().filter(|length| *length <= rest.len());
    let (taken, after) = rest.split_at(length.ok_or(StructureError::Damaged)?);
    *rest = after;
    Ok(taken)
}
