//! Access control: a token for commands, and requests from pages of this server only.

use std::fmt::Write;
use std::net::IpAddr;

/// The minimum length of a configured token.
const LEAST_CHARACTERS: usize = 16;

/// A secret that allows its bearer to change the mission.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

/// An invalid token.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TokenError {
    /// Too easy to guess, or not usable in an address.
    #[error(
        "a token of {0} characters; allowed are at least {LEAST_CHARACTERS} letters, digits, `-` and `_`, and nothing else"
    )]
    Weak(usize),
    /// The operating system gives no random bits.
    #[error("no random bits for a token: {0}")]
    NoRandomness(String),
}

impl Token {
    /// A new random token: 128 bits.
    ///
    /// # Errors
    /// If the operating system provides no randomness.
    pub fn random() -> Result<Self, TokenError> {
        let mut bytes = [0_u8; 16];
        getrandom::fill(&mut bytes).map_err(|error| TokenError::NoRandomness(error.to_string()))?;
        let mut text = String::with_capacity(2 * bytes.len());
        for byte in bytes {
            // Writing to a string cannot fail.
            let _ = write!(text, "{byte:02x}");
        }
        Ok(Self(text))
    }

    /// A configured token.
    ///
    /// # Errors
    /// If it is too short, or has characters that an address cannot contain.
    pub fn chosen(text: &str) -> Result<Self, TokenError> {
        let text = text.trim();
        let is_plain = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
        if text.len() >= LEAST_CHARACTERS && is_plain {
            Ok(Self(text.to_owned()))
        } else {
            Err(TokenError::Weak(text.len()))
        }
    }

    /// The token as text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Whether the header `Authorization: Bearer TOKEN` contains it.
    #[must_use]
    pub fn is_in(&self, authorization: Option<&str>) -> bool {
        authorization.and_then(|value| value.strip_prefix("Bearer ")).is_some_and(|given| self.is(given))
    }

    /// Compares the token with a text, in constant time.
    #[must_use]
    pub fn is(&self, given: &str) -> bool {
        let difference = self
            .0
            .bytes()
            .zip(given.bytes().chain(std::iter::repeat(0)))
            .fold(0, |sum, (a, b)| sum | (a ^ b));
        std::hint::black_box(difference) == 0 && given.len() == self.0.len()
    }
}

/// Keeps the token out of logs.
impl std::fmt::Debug for Token {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("Token(..)")
    }
}

/// Whether a request addresses this server by an address that DNS cannot redirect and, if it comes from a page, comes
/// from a page of this server: `Host` is an IP address or `localhost`, and `Origin`, if present, is that host.
#[must_use]
pub fn is_own_page(host: Option<&str>, origin: Option<&str>) -> bool {
    let Some(host) = host else { return false };
    let is_origin = origin.is_none_or(|origin| origin.strip_prefix("http://") == Some(host));
    is_literal(host) && is_origin
}

/// Whether a client may read what needs no token: it is no page in a browser, or the page is of this computer or of a
/// website in the list. Without this each website that is open in a browser here could read what only this computer can.
#[must_use]
pub fn may_read(origin: Option<&str>, websites: &[String]) -> bool {
    let Some(origin) = origin else { return true };
    let Some((scheme, host)) = origin.split_once("://") else { return false };
    // Programs that are made of pages, such as Foxglove's, have other schemes.
    !matches!(scheme, "http" | "https")
        || websites.iter().any(|website| website == origin)
        || name(host).is_some_and(|name| {
            name == "localhost" || name.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
        })
}

fn is_literal(host: &str) -> bool {
    name(host).is_some_and(|name| name == "localhost" || name.parse::<IpAddr>().is_ok())
}

/// The name or the number of a host, without its port.
fn name(host: &str) -> Option<&str> {
    let is_port = |port: &str| !port.is_empty() && port.bytes().all(|byte| byte.is_ascii_digit());
    match host.strip_prefix('[') {
        Some(rest) => match rest.split_once(']') {
            Some((name, "")) => Some(name),
            Some((name, port)) if port.strip_prefix(':').is_some_and(is_port) => Some(name),
            _ => None,
        },
        None => match host.split_once(':') {
            Some((name, port)) if is_port(port) => Some(name),
            Some(_) => None,
            None => Some(host),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_token_is_the_token() {
        let token = Token::random().unwrap();
        assert_eq!(token.text().len(), 32);
        assert_ne!(token, Token::random().unwrap());
        let text = token.text();
        assert!(token.is_in(Some(&format!("Bearer {text}"))));
        for wrong in ["", "Bearer ", &format!("Bearer {text}0"), &format!("Bearer {}", &text[1..]), text] {
            assert!(!token.is_in(Some(wrong)), "{wrong}");
        }
        assert!(!token.is_in(None));
    }

    #[test]
    fn a_weak_token_is_rejected() {
        assert!(Token::chosen("correct-horse_battery").is_ok());
        assert!(Token::chosen("short").unwrap_err().to_string().contains("at least 16"));
        assert!(Token::chosen("sixteen letters?").is_err());
    }

    #[test]
    fn a_website_reads_only_if_it_is_listed() {
        let websites = ["https://app.foxglove.dev".to_owned()];
        let check = |origin, expected| assert_eq!(may_read(origin, &websites), expected, "{origin:?}");
        check(None, true);
        check(Some("file://"), true);
        check(Some("foxglove://app"), true);
        check(Some("https://app.foxglove.dev"), true);
        check(Some("http://localhost:8080"), true);
        check(Some("http://127.0.0.1"), true);
        check(Some("http://[::1]:8080"), true);
        check(Some("http://app.foxglove.dev"), false);
        check(Some("https://app.foxglove.dev.evil.example"), false);
        check(Some("https://evil.example"), false);
        check(Some("http://192.0.2.7"), false);
        check(Some("null"), false);
    }

    #[test]
    fn only_a_page_of_this_server_is_its_own() {
        let check =
            |host, origin, expected| assert_eq!(is_own_page(host, origin), expected, "{host:?} {origin:?}");
        check(Some("127.0.0.1:8080"), None, true);
        check(Some("127.0.0.1:8080"), Some("http://127.0.0.1:8080"), true);
        check(Some("localhost:8080"), Some("http://localhost:8080"), true);
        check(Some("[::1]:8080"), Some("http://[::1]:8080"), true);
        check(Some("127.0.0.1:8080"), Some("http://127.0.0.1:8081"), false);
        check(Some("127.0.0.1:8080"), Some("https://127.0.0.1:8080"), false);
        check(Some("127.0.0.1:8080"), Some("null"), false);
        check(Some("evil.example:8080"), Some("http://evil.example:8080"), false);
        check(Some("127.0.0.1.evil.example"), None, false);
        check(None, None, false);
    }
}
