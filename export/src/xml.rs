//! XML output: elements one by one, with text that any reader accepts.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

/// A document in progress.
pub(crate) type Document = Writer<Vec<u8>>;

/// A document with a declaration and the written elements.
pub(crate) fn document(write: impl FnOnce(&mut Document) -> io::Result<()>) -> String {
    declared(Writer::new_with_indent(Vec::new(), b' ', 2), write)
}

/// The same without any space between elements.
pub(crate) fn line(write: impl FnOnce(&mut Document) -> io::Result<()>) -> String {
    declared(Writer::new(Vec::new()), write)
}

fn declared(mut writer: Document, write: impl FnOnce(&mut Document) -> io::Result<()>) -> String {
    let declaration = Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None));
    let written = writer.write_event(declaration).and_then(|()| write(&mut writer));
    written.unwrap_or_else(|_| unreachable!("memory takes all that is written"));
    String::from_utf8(writer.into_inner()).unwrap_or_else(|_| unreachable!("texts make a text"))
}

/// An element with text alone.
pub(crate) fn element(writer: &mut Document, name: &str, text: &str) -> io::Result<()> {
    writer.create_element(name).write_text_content(BytesText::new(&plain(text)))?;
    Ok(())
}

/// Without the characters that XML cannot contain.
pub(crate) fn plain(text: &str) -> String {
    let is_allowed = |c: &char| matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{fffd}' | '\u{10000}'..);
    text.chars().filter(is_allowed).collect()
}
