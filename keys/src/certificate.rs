//! The certificate authority of a mission, and the certificates that it signs.
//!
//! Keys are ECDSA over P-256, which every TLS library supports. An authority signs for one mission only.

use std::ops::Range;

use dragnet_proto::key::Mission;
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose, SerialNumber,
};
use time::{Duration, OffsetDateTime};

use crate::KeysError;
use crate::register::Entry;

/// Maximum validity of a certificate, days, and validity of the authority.
pub const MAX_DAYS: u32 = 3650;
/// Certificates are valid from this many days before they are made: vehicles' clocks may be behind.
pub const SLACK_DAYS: i64 = 30;

/// A certificate and its private key, PEM.
#[derive(Clone)]
pub struct Signed {
    /// The certificate.
    pub certificate: String,
    /// The private key, PKCS #8.
    pub private_key: String,
}

/// The validity of a certificate: the first of a PEM file; `None` if there is none.
#[must_use]
pub fn validity(pem: &[u8]) -> Option<Range<OffsetDateTime>> {
    let (_, block) = x509_parser::pem::parse_x509_pem(pem).ok()?;
    let validity = block.parse_x509().ok()?.validity().clone();
    Some(validity.not_before.to_datetime()..validity.not_after.to_datetime())
}

/// Creates the certificate authority of a mission.
///
/// # Errors
/// If the system provides no randomness.
pub fn authority(mission: &Mission, now: OffsetDateTime) -> Result<Signed, KeysError> {
    let name = format!("authority of {mission}");
    let mut params = params(mission, &name, 1, now);
    params.not_after = now + Duration::days(MAX_DAYS.into());
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    let failed = || KeysError::certificate(&name);
    let key = KeyPair::generate().map_err(failed())?;
    let certificate = params.self_signed(&key).map_err(failed())?;
    Ok(Signed { certificate: certificate.pem(), private_key: key.serialize_pem() })
}

/// Creates the certificate of an entry, for use as client and as server.
///
/// # Errors
/// If a host or the authority's files are invalid.
pub fn issue(
    authority: &Signed,
    mission: &Mission,
    entry: &Entry,
    now: OffsetDateTime,
) -> Result<Signed, KeysError> {
    let name = entry.common_name();
    let failed = || KeysError::certificate(&name);
    let mut params = params(mission, &name, entry.serial, now);
    params.not_after = OffsetDateTime::from_unix_timestamp(entry.valid_until).unwrap_or(now);
    params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
    params.extended_key_usages =
        vec![ExtendedKeyUsagePurpose::ServerAuth, ExtendedKeyUsagePurpose::ClientAuth];
    params.use_authority_key_identifier_extension = true;
    params.subject_alt_names = hosts(&entry.hosts)?;
    let signer = KeyPair::from_pem(&authority.private_key).map_err(failed())?;
    let issuer = Issuer::from_ca_cert_pem(&authority.certificate, signer).map_err(failed())?;
    let key = KeyPair::generate().map_err(failed())?;
    let certificate = params.signed_by(&key, &issuer).map_err(failed())?;
    Ok(Signed { certificate: certificate.pem(), private_key: key.serialize_pem() })
}

fn params(mission: &Mission, common_name: &str, serial: u64, now: OffsetDateTime) -> CertificateParams {
    let mut params = CertificateParams::default();
    params.distinguished_name = rcgen::DistinguishedName::new();
    params.distinguished_name.push(DnType::OrganizationName, mission.as_str());
    params.distinguished_name.push(DnType::CommonName, common_name);
    params.serial_number = Some(SerialNumber::from(serial));
    params.not_before = now - Duration::days(SLACK_DAYS);
    params
}

/// Checks that a host can be part of a certificate.
///
/// # Errors
/// If it is neither a host name nor an IP address.
pub fn check_host(host: &str) -> Result<(), KeysError> {
    let is_label = |label: &str| {
        !label.is_empty() && label.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-')
    };
    let is_name = host.len() < 254 && host.split('.').all(is_label);
    if is_name || host.parse::<std::net::IpAddr>().is_ok() {
        Ok(())
    } else {
        Err(KeysError::Host(host.to_owned()))
    }
}

fn hosts(hosts: &[String]) -> Result<Vec<rcgen::SanType>, KeysError> {
    let params = CertificateParams::new(hosts).map_err(|_| KeysError::Host(hosts.join(" ")))?;
    Ok(params.subject_alt_names)
}
