//! Where the mission is sent to TAK, and with which certificates.

use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use dragnet_files::read_at_most;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore};

/// The maximum size of a file of certificates, bytes.
const MAX_PEM_BYTES: u64 = 1 << 20;
/// The allowed periods, seconds.
const PERIODS: std::ops::RangeInclusive<f64> = 0.1..=3600.0;

/// The mission on the maps of TAK (ATAK, WinTAK, iTAK), as events of Cursor on Target; without it nothing is sent there.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Where to send: `udp://239.2.3.1:6969` is the multicast group of all devices on the network; `udp://HOST:PORT` one
    /// device; `tcp://HOST:8087` and `tls://HOST:8089` a server.
    #[schemars(extend("examples" = ["udp://239.2.3.1:6969"]))]
    pub url: String,
    /// Time from one sending of everything to the next, seconds, 0.1 to 3600. A robot that is lost is shown as current for
    /// four periods.
    #[serde(default = "period")]
    pub period_seconds: f64,
    /// For UDP: the address of this computer in the network to which multicast is sent; without it the system chooses.
    #[serde(default)]
    pub local_address: Option<IpAddr>,
    /// For TLS: the certificate that has signed the server's (PEM), relative to this file.
    #[serde(default)]
    pub ca: Option<PathBuf>,
    /// For TLS: this computer's certificate, with those between it and the authority that the server knows (PEM), relative to
    /// this file.
    #[serde(default)]
    pub certificate: Option<PathBuf>,
    /// For TLS: the key of this computer's certificate (PEM, without a password), relative to this file.
    #[serde(default)]
    pub key: Option<PathBuf>,
    /// For TLS: the name in the server's certificate, if it is not the host of `url`.
    #[serde(default)]
    pub server_name: Option<String>,
}

const fn period() -> f64 {
    5.0
}

/// A target, checked.
#[derive(Clone, Debug)]
pub struct Checked {
    url: String,
    host: String,
    period: Duration,
    transport: Transport,
}

#[derive(Clone, Debug)]
pub(super) enum Transport {
    Udp { local: Option<IpAddr> },
    Tcp,
    Tls { name: ServerName<'static>, config: Arc<ClientConfig> },
}

impl Settings {
    /// A target without certificates, with defaults for all else.
    #[must_use]
    pub fn of(url: &str) -> Self {
        Self {
            url: url.to_owned(),
            period_seconds: period(),
            local_address: None,
            ca: None,
            certificate: None,
            key: None,
            server_name: None,
        }
    }

    /// Checks the settings, and reads the certificates. `file` is the file of the settings.
    ///
    /// # Errors
    /// If a value is invalid, or a file cannot be used: with its key and the allowed values.
    pub fn check(&self, file: &Path) -> Result<Checked, String> {
        let (scheme, host) = self.parts()?;
        if !PERIODS.contains(&self.period_seconds) {
            let (least, most) = (PERIODS.start(), PERIODS.end());
            return Err(format!(
                "tak.period_seconds is {:?}; allowed is from {least} to {most}",
                self.period_seconds
            ));
        }
        let of_tls = [
            ("ca", self.ca.is_some()),
            ("certificate", self.certificate.is_some()),
            ("key", self.key.is_some()),
            ("server_name", self.server_name.is_some()),
        ];
        let given = of_tls.into_iter().find(|&(_, is_given)| is_given && scheme != "tls");
        if let Some((key, _)) = given {
            return Err(format!("tak.{key} is for tls://HOST:PORT; tak.url is {:?}", self.url));
        }
        if self.local_address.is_some() && scheme != "udp" {
            return Err(format!("tak.local_address is for udp://HOST:PORT; tak.url is {:?}", self.url));
        }
        let transport = match scheme {
            "udp" => Transport::Udp { local: self.local_address },
            "tcp" => Transport::Tcp,
            _ => self.tls(&host, file.parent().unwrap_or(Path::new("")))?,
        };
        let period = Duration::from_secs_f64(self.period_seconds);
        Ok(Checked { url: self.url.clone(), host, period, transport })
    }

    /// The scheme, and host and port.
    fn parts(&self) -> Result<(&str, String), String> {
        let allowed = || {
            format!(
                "tak.url is {:?}; allowed are udp://HOST:PORT, tcp://HOST:PORT and tls://HOST:PORT, such as \
                 udp://239.2.3.1:6969, tcp://192.168.1.7:8087 and tls://[fe80::7]:8089",
                self.url
            )
        };
        let (scheme, host) = self.url.split_once("://").ok_or_else(allowed)?;
        let host = host.trim_end_matches('/');
        let (name, port) = host.rsplit_once(':').ok_or_else(allowed)?;
        let is_name = !name.is_empty()
            && !name.contains(['/', '@', ' '])
            && (!name.contains(':') || name.starts_with('[') && name.ends_with(']'));
        let is_port = port.parse::<u16>().is_ok_and(|port| port > 0);
        if ["udp", "tcp", "tls"].contains(&scheme) && is_name && is_port {
            Ok((scheme, host.to_owned()))
        } else {
            Err(allowed())
        }
    }

    fn tls(&self, host: &str, folder: &Path) -> Result<Transport, String> {
        let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
        let name = self.server_name.as_deref().unwrap_or(name.trim_matches(['[', ']']));
        let server = ServerName::try_from(name.to_owned())
            .map_err(|_| format!("tak.server_name: {name:?} is no name of a host, nor an address"))?;
        let ca =
            self.ca.as_ref().ok_or("tls needs tak.ca, the certificate that has signed the server's (PEM)")?;
        let mut roots = RootCertStore::empty();
        for certificate in certificates("ca", &folder.join(ca))? {
            roots.add(certificate).map_err(|error| format!("tak.ca: {}: {error}", ca.display()))?;
        }
        let builder = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .map_err(|error| format!("tls: {error}"))?
            .with_root_certificates(roots);
        let config = match (&self.certificate, &self.key) {
            (None, None) => builder.with_no_client_auth(),
            (Some(certificate), Some(key)) => {
                let (chain, key) = (folder.join(certificate), folder.join(key));
                builder
                    .with_client_auth_cert(certificates("certificate", &chain)?, private_key(&key)?)
                    .map_err(|error| format!("tak.certificate and tak.key do not fit: {error}"))?
            }
            _ => return Err("tak.certificate and tak.key: allowed are both or none".to_owned()),
        };
        Ok(Transport::Tls { name: server, config: Arc::new(config) })
    }
}

impl Checked {
    /// As in the settings.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Host and port.
    pub(super) fn host(&self) -> &str {
        &self.host
    }

    /// Whether a server that wants a certificate gets none.
    pub(super) fn is_anonymous(&self) -> bool {
        matches!(&self.transport, Transport::Tls { config, .. } if !config.client_auth_cert_resolver.has_certs())
    }

    pub(super) const fn period(&self) -> Duration {
        self.period
    }

    pub(super) const fn transport(&self) -> &Transport {
        &self.transport
    }
}

fn pem(key: &str, file: &Path) -> Result<Vec<u8>, String> {
    read_at_most(file, MAX_PEM_BYTES).map_err(|error| format!("tak.{key}: {}: {error}", file.display()))
}

fn certificates(key: &str, file: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let read: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&pem(key, file)?).collect();
    match read {
        Ok(certificates) if !certificates.is_empty() => Ok(certificates),
        Ok(_) => Err(format!(
            "tak.{key}: {} holds no certificate in PEM; of a PKCS #12 file: openssl pkcs12 -in FILE.p12 -nokeys -out FILE.pem",
            file.display()
        )),
        Err(error) => Err(format!("tak.{key}: {}: {error}", file.display())),
    }
}

fn private_key(file: &Path) -> Result<PrivateKeyDer<'static>, String> {
    PrivateKeyDer::from_pem_slice(&pem("key", file)?).map_err(|_| {
        format!(
            "tak.key: {} holds no key in PEM without a password; one with a password becomes one without by \
             openssl pkey -in FILE -out FILE.pem",
            file.display()
        )
    })
}
