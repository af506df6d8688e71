//! Detects endpoints that can never work, even if the network becomes available later, and so must be mistakes in the
//! settings.
//!
//! An address that this computer does not have, an unknown name, and a port that another process holds may all be
//! available later. An unsupported protocol, or an address without a port, never will.

use zenoh::Config;
use zenoh::config::EndPoint;

/// The supported protocols.
const PROTOCOLS: [&str; 2] = ["tcp", "tls"];

/// Checks all endpoints of Zenoh's settings.
///
/// # Errors
/// The first endpoint that can never work, and the allowed values.
pub(crate) fn check(config: &Config) -> Result<(), String> {
    for key in ["listen/endpoints", "connect/endpoints"] {
        for endpoint in listed(&config.get_json(key).unwrap_or_default()) {
            check_one(&endpoint).map_err(|reason| format!("{key}: {endpoint:?}: {reason}"))?;
        }
    }
    Ok(())
}

/// Checks an endpoint.
///
/// # Errors
/// The error of an endpoint that can never work, and the allowed values.
pub(crate) fn check_one(endpoint: &str) -> Result<(), String> {
    let parsed: EndPoint = endpoint
        .parse()
        .map_err(|_| "it is no endpoint; allowed are tcp/HOST:PORT and tls/HOST:PORT".to_owned())?;
    let protocol = parsed.protocol().to_string();
    if !PROTOCOLS.contains(&protocol.as_str()) {
        return Err(format!("{protocol:?} is not spoken here; allowed are tcp/HOST:PORT and tls/HOST:PORT"));
    }
    let address = parsed.address().to_string();
    let (host, port) = address.rsplit_once(':').unwrap_or((&address, ""));
    let is_host = !host.is_empty() && (!host.contains(':') || host.starts_with('[') && host.ends_with(']'));
    if !is_host || port.parse::<u16>().is_err() {
        return Err(format!(
            "{address:?} is no address; allowed are those like 192.168.1.7:7447, [fe80::7]:7447 and host:7447"
        ));
    }
    Ok(())
}

/// All endpoints in a value of Zenoh's settings, JSON: they may be listed by mode, and in groups.
pub(crate) fn listed(json: &str) -> Vec<String> {
    serde_json::from_str(json).map_or_else(|_| Vec::new(), |value| strings(&value))
}

fn strings(value: &serde_json::Value) -> Vec<String> {
    match value {
        serde_json::Value::String(text) => vec![text.clone()],
        serde_json::Value::Array(values) => values.iter().flat_map(strings).collect(),
        serde_json::Value::Object(entries) => entries.values().flat_map(strings).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_that_may_come_later_are_waited_for_and_impossible_ones_rejected() {
        let check = |endpoint: &str, is_possible: bool| {
            assert_eq!(check_one(endpoint).is_ok(), is_possible, "{endpoint}: {:?}", check_one(endpoint));
        };
        check("tcp/192.0.2.7:7447", true);
        check("tcp/robot-9.invalid:7447", true);
        check("tls/[fe80::7]:7447#iface=wlan7", true);
        check("tcp/127.0.0.1:0", true);
        check("tpc/192.0.2.7:7447", false);
        check("udp/192.0.2.7:7447", false);
        check("tcp/192.0.2.7", false);
        check("tcp/192.0.2.7:74470", false);
        check("tcp/fe80::7:7447", false);
        check("192.0.2.7:7447", false);
    }
}
