//! The operator of a field coordinator, who gives commands at its page.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};

use crate::field::Field;

const TOKEN: &str = "a-token_of_a-person";

/// An operator with a page.
pub(crate) struct Operator {
    port: u16,
}

impl Operator {
    pub(crate) fn new() -> Self {
        Self { port: TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port() }
    }

    /// The settings of a coordinator with this page that records to a file.
    pub(crate) fn settings(&self, field: &Field, recording: &Path) -> PathBuf {
        let (token, settings) = (field.path("token.txt"), field.coordinator_settings(recording));
        std::fs::write(&token, TOKEN).unwrap();
        let page =
            format!("[live]\nlisten = \"127.0.0.1:{}\"\ntoken_file = \"{}\"\n", self.port, token.display());
        std::fs::write(&settings, std::fs::read_to_string(&settings).unwrap() + &page).unwrap();
        settings
    }

    /// Gives a command; returns the page's answer.
    pub(crate) fn order(&self, command: &str) -> String {
        let (port, length) = (self.port, command.len());
        let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
        let head = format!(
            "POST /command HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\nAuthorization: Bearer {TOKEN}\r\n\
             Content-Length: {length}\r\n\r\n"
        );
        socket.write_all((head + command).as_bytes()).unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        answer
    }
}
