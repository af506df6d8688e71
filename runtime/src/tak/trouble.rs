//! What is wrong with a connection, in words, each reason once until it works again.

use std::collections::BTreeSet;
use std::io;

use tokio_rustls::rustls::{self, AlertDescription, CertificateError};

use super::settings::Checked;

/// Reasons that are told while it does not work; others are not.
const MOST_REASONS: usize = 8;

/// The reasons why a connection has not worked since it last did.
#[derive(Debug)]
pub(super) struct Trouble {
    /// What to do about a connection that is closed without a reason.
    advice: &'static str,
    told: BTreeSet<String>,
}

impl Trouble {
    /// No trouble yet with a target.
    pub(super) fn of(target: &Checked) -> Self {
        let advice = if target.is_anonymous() {
            "; if it wants a certificate, give tak.certificate and tak.key"
        } else {
            ""
        };
        Self { advice, told: BTreeSet::new() }
    }

    /// The reason, if it was not told yet.
    pub(super) fn news(&mut self, error: &io::Error) -> Option<String> {
        let reason = self.reason(error);
        let is_news = self.told.len() < MOST_REASONS && self.told.insert(reason.clone());
        is_news.then_some(reason)
    }

    /// Forgets all reasons, since it works; returns whether there were any.
    pub(super) fn is_over(&mut self) -> bool {
        !std::mem::take(&mut self.told).is_empty()
    }

    fn reason(&self, error: &io::Error) -> String {
        use io::ErrorKind::{BrokenPipe, ConnectionAborted, ConnectionReset, UnexpectedEof};
        let tls = error.get_ref().and_then(|cause| cause.downcast_ref::<rustls::Error>());
        match (tls, error.kind()) {
            (Some(rustls::Error::AlertReceived(AlertDescription::HandshakeFailure)), _)
            | (None, BrokenPipe | ConnectionAborted | ConnectionReset | UnexpectedEof) => {
                format!("it closes the connection{}", self.advice)
            }
            (Some(rustls::Error::InvalidCertificate(reason)), _) => server(reason),
            (Some(rustls::Error::AlertReceived(alert)), _) => client(*alert),
            (Some(rustls::Error::InvalidMessage(_)), _) => "what answers there does not speak TLS".to_owned(),
            (Some(other), _) => format!("TLS: {other}"),
            (None, _) => error.to_string(),
        }
    }
}

/// Why the server's certificate is not accepted.
fn server(reason: &CertificateError) -> String {
    match reason {
        CertificateError::UnknownIssuer | CertificateError::BadSignature => {
            "its certificate is not signed by tak.ca".to_owned()
        }
        CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
            "its certificate is for another host; give the name in it as tak.server_name".to_owned()
        }
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "its certificate has expired by this computer's clock".to_owned()
        }
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
            "its certificate is not valid yet by this computer's clock".to_owned()
        }
        other => format!("its certificate is not accepted: {other}"),
    }
}

/// What the server says of this side.
fn client(alert: AlertDescription) -> String {
    match alert {
        AlertDescription::CertificateRequired => {
            "it wants a certificate: give tak.certificate and tak.key".to_owned()
        }
        AlertDescription::BadCertificate
        | AlertDescription::UnknownCA
        | AlertDescription::CertificateUnknown
        | AlertDescription::AccessDenied
        | AlertDescription::CertificateExpired
        | AlertDescription::CertificateRevoked
        | AlertDescription::UnsupportedCertificate => {
            format!("it does not accept tak.certificate: {alert:?}")
        }
        other => format!("it ends the connection: {other:?}"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::settings::Settings;
    use super::*;

    fn trouble(url: &str) -> Trouble {
        Trouble::of(&Settings::of(url).check(Path::new("")).unwrap())
    }

    #[test]
    fn each_reason_is_told_once_until_it_works_again() {
        let refused = || io::Error::from(io::ErrorKind::ConnectionRefused);
        let closed = || io::Error::from(io::ErrorKind::UnexpectedEof);
        let mut trouble = trouble("tcp://127.0.0.1:8087");
        assert!(!trouble.is_over());
        let told = [refused(), closed(), refused(), closed()].map(|error| trouble.news(&error).is_some());
        assert_eq!(told, [true, true, false, false]);
        assert!(trouble.is_over() && !trouble.is_over());
        assert!(trouble.news(&refused()).is_some());
        for number in 0..100 {
            trouble.news(&io::Error::other(format!("{number}")));
        }
        assert_eq!(trouble.told.len(), MOST_REASONS);
    }

    #[test]
    fn certificates_are_spoken_of_by_the_keys_of_the_settings() {
        let check = |error: rustls::Error, expected: &str| {
            let error = io::Error::new(io::ErrorKind::InvalidData, error);
            let reason = trouble("tcp://127.0.0.1:8087").reason(&error);
            assert!(reason.contains(expected), "{reason}");
        };
        check(CertificateError::UnknownIssuer.into(), "tak.ca");
        check(CertificateError::NotValidForName.into(), "tak.server_name");
        check(CertificateError::Expired.into(), "clock");
        check(
            rustls::Error::AlertReceived(AlertDescription::CertificateRequired),
            "tak.certificate and tak.key",
        );
        check(rustls::Error::AlertReceived(AlertDescription::UnknownCA), "does not accept tak.certificate");
    }
}
