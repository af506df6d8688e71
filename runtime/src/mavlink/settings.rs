//! Settings of the autopilot of a vehicle.

use std::fmt;
use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use dragnet_mavlink::autopilot::config::{Config, Engage, OnFault, PositionSource, Response};
use dragnet_mavlink::target::Limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::RuntimeError;

/// The table `[mavlink]`; only `connection` is required. The vehicle moves by goals: `vehicle.motion.kind = "goal"`.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Where the autopilot is: `udpin:ADDRESS:PORT` to be called by it, `udpout:HOST:PORT` or `tcp:HOST:PORT` to call it.
    #[schemars(extend("examples" = ["udpin:127.0.0.1:14550"]))]
    pub connection: String,
    /// The autopilot's system number, 1 to 255; without it the first with a heartbeat counts, and a second is a fault.
    #[serde(default)]
    pub autopilot_system: Option<u8>,
    /// This robot's system number, 1 to 255: the autopilot's own for a computer on the vehicle.
    #[serde(default = "system")]
    pub system: u8,
    /// This robot's component number, 2 to 255.
    #[serde(default = "component")]
    pub component: u8,
    /// Who arms the vehicle and switches it to `GUIDED` or `OFFBOARD`.
    #[serde(default)]
    pub engage: EngageTable,
    /// Source of the position.
    #[serde(default)]
    pub position: PositionTable,
    /// Height above home at which a copter searches, meters; needed for copters, ignored by rovers and boats.
    #[serde(default)]
    pub altitude_meters: Option<f64>,
    /// Lowest height above home of a copter's targets, meters.
    #[serde(default = "min_altitude_meters")]
    pub min_altitude_meters: f64,
    /// Highest height above home of a copter's targets, meters; they stay 2 m below it, and below the autopilot's fence.
    #[serde(default = "max_altitude_meters")]
    pub max_altitude_meters: f64,
    /// Largest distance of targets from home, meters, above 0; they stay 2 m within it, and within the autopilot's fence.
    #[serde(default = "max_distance_meters")]
    pub max_distance_meters: f64,
    /// Charge below which the battery is low, percent, 0 to 100.
    #[serde(default = "min_battery_percent")]
    pub min_battery_percent: f64,
    /// Time without a heartbeat after which the link is lost, seconds, 1 to 60.
    #[serde(default = "link_timeout_seconds")]
    pub link_timeout_seconds: f64,
    /// Time without progress after which a target is given up, seconds, 1 to 3600.
    #[serde(default = "stuck_seconds")]
    pub stuck_seconds: f64,
    /// Standard deviation of a position that comes without one, meters, above 0 to 1000.
    #[serde(default = "position_std_meters")]
    pub position_std_meters: f64,
    /// Standard deviation of the heading, degrees, 0 to 90.
    #[serde(default = "heading_std_degrees")]
    pub heading_std_degrees: f64,
    /// The response to each kind of fault.
    #[serde(default)]
    pub on_fault: OnFaultTable,
    /// Where detectors send what they see.
    #[serde(default)]
    pub detections: DetectionsTable,
}

/// Who arms the vehicle and switches its mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EngageTable {
    /// The pilot; until then the robot waits.
    #[default]
    Pilot,
    /// The robot, once at its start, if the vehicle is disarmed then; copters take off.
    Robot,
}

/// Source of the position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PositionTable {
    /// `GLOBAL_POSITION_INT`. The map must be georeferenced.
    #[default]
    Global,
    /// `LOCAL_POSITION_NED`: the map's origin is measured from the autopilot's, east and north.
    Local,
}

/// A response to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResponseTable {
    /// The vehicle goes on; the fault is reported.
    Continue,
    /// The vehicle stays where it is until the fault is over.
    Hold,
    /// The robot commands a return.
    Home,
}

/// The response to each kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OnFaultTable {
    /// The battery is low.
    pub battery: ResponseTable,
    /// The autopilot reports a breach of its fence.
    pub fence: ResponseTable,
    /// No valid position, a battery whose charge jumps, two autopilots.
    pub data: ResponseTable,
}

impl Default for OnFaultTable {
    fn default() -> Self {
        Self { battery: ResponseTable::Home, fence: ResponseTable::Hold, data: ResponseTable::Hold }
    }
}

/// Where detectors send what they see: one JSON object a datagram and image.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectionsTable {
    /// UDP address and port.
    pub listen: String,
    /// Classes that count; all if empty.
    pub classes: Vec<String>,
    /// Smallest score that counts, 0 to 1.
    pub min_score: f64,
}

impl Default for DetectionsTable {
    fn default() -> Self {
        Self { listen: "127.0.0.1:14600".to_owned(), classes: Vec::new(), min_score: 0.25 }
    }
}

const fn system() -> u8 {
    1
}

/// `MAV_COMP_ID_ONBOARD_COMPUTER`.
const fn component() -> u8 {
    191
}

const fn min_altitude_meters() -> f64 {
    2.0
}

/// The limit of most countries.
const fn max_altitude_meters() -> f64 {
    120.0
}

const fn max_distance_meters() -> f64 {
    1000.0
}

const fn min_battery_percent() -> f64 {
    20.0
}

/// As ArduPilot's failsafe of ground stations: of heartbeats that come every second a bad radio loses several.
const fn link_timeout_seconds() -> f64 {
    5.0
}

const fn stuck_seconds() -> f64 {
    30.0
}

const fn position_std_meters() -> f64 {
    2.0
}

const fn heading_std_degrees() -> f64 {
    3.0
}

/// Settings that have been checked.
#[derive(Clone, Debug)]
pub struct Checked {
    /// How the autopilot is reached.
    pub connection: Connection,
    /// Settings of the autopilot's state machine.
    pub config: Config,
    /// Standard deviation of the heading, radians.
    pub heading_std_radians: f64,
    /// Where detections arrive.
    pub detections: SocketAddr,
    /// Which of them count.
    pub filter: DetectionFilter,
}

/// Which detections count.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectionFilter {
    /// Their classes; all if empty.
    pub classes: Vec<String>,
    /// Their smallest score.
    pub min_score: f64,
}

/// How an autopilot is reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Connection {
    /// It calls here.
    UdpIn(SocketAddr),
    /// It is called there: host and port.
    UdpOut(String),
    /// The same over TCP.
    Tcp(String),
}

impl fmt::Display for Connection {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpIn(address) => write!(formatter, "udpin:{address}"),
            Self::UdpOut(host) => write!(formatter, "udpout:{host}"),
            Self::Tcp(host) => write!(formatter, "tcp:{host}"),
        }
    }
}

impl Settings {
    /// Checks the settings of a file.
    ///
    /// # Errors
    /// If a value is invalid: with its key and the allowed values.
    pub fn check(&self, file: &Path) -> Result<Checked, RuntimeError> {
        self.checked().map_err(|reason| RuntimeError::Settings { file: file.to_owned(), reason })
    }

    fn checked(&self) -> Result<Checked, String> {
        let autopilot_system = self.autopilot_system.map(|system| number("autopilot_system", system, 1));
        let DetectionsTable { listen, classes, min_score } = &self.detections;
        let min_score = within("detections.min_score", *min_score, 0.0, 1.0)?;
        Ok(Checked {
            connection: connection(&self.connection)?,
            config: Config {
                autopilot_system: autopilot_system.transpose()?,
                system: number("system", self.system, 1)?,
                component: number("component", self.component, 2)?,
                engage: match self.engage {
                    EngageTable::Pilot => Engage::Pilot,
                    EngageTable::Robot => Engage::Robot,
                },
                position: match self.position {
                    PositionTable::Global => PositionSource::Global,
                    PositionTable::Local => PositionSource::Local,
                },
                altitude_meters: self.altitude_meters,
                limits: self.limits()?,
                min_battery_percent: within("min_battery_percent", self.min_battery_percent, 0.0, 100.0)?,
                on_fault: self.on_fault.into(),
                link_timeout_ns: time("link_timeout_seconds", self.link_timeout_seconds, 60.0)?,
                stuck_ns: time("stuck_seconds", self.stuck_seconds, 3600.0)?,
                position_std_meters: within("position_std_meters", self.position_std_meters, 1e-3, 1000.0)?,
            },
            heading_std_radians: within("heading_std_degrees", self.heading_std_degrees, 0.0, 90.0)?
                .to_radians(),
            detections: address("detections.listen", listen)?,
            filter: DetectionFilter { classes: classes.clone(), min_score },
        })
    }

    fn limits(&self) -> Result<Limits, String> {
        let limits = Limits {
            min_altitude_meters: within("min_altitude_meters", self.min_altitude_meters, 1.5, 1e4)?,
            max_altitude_meters: within("max_altitude_meters", self.max_altitude_meters, 1.5, 1e4)?,
            max_distance_meters: within("max_distance_meters", self.max_distance_meters, 1.0, 1e6)?,
        };
        let Some(altitude) = self.altitude_meters else { return Ok(limits) };
        let (min, max) = (limits.min_altitude_meters, limits.max_altitude_meters - 2.0);
        within("altitude_meters", altitude, min, max)?;
        Ok(limits)
    }
}

impl From<OnFaultTable> for OnFault {
    fn from(table: OnFaultTable) -> Self {
        let response = |response| match response {
            ResponseTable::Continue => Response::Continue,
            ResponseTable::Hold => Response::Hold,
            ResponseTable::Home => Response::Home,
        };
        Self { battery: response(table.battery), fence: response(table.fence), data: response(table.data) }
    }
}

fn connection(text: &str) -> Result<Connection, String> {
    let host = |host: &str| {
        let has_port = host
            .rsplit_once(':')
            .is_some_and(|(name, port)| !name.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0));
        if has_port {
            return Ok(host.to_owned());
        }
        Err(format!(
            "mavlink.connection is {text:?}; allowed after the colon are a host and a port, 1 to 65535"
        ))
    };
    match text.split_once(':') {
        Some(("udpin", address_text)) => Ok(Connection::UdpIn(address("connection", address_text)?)),
        Some(("udpout", address_text)) => host(address_text).map(Connection::UdpOut),
        Some(("tcp", address_text)) => host(address_text).map(Connection::Tcp),
        _ => Err(format!(
            "mavlink.connection is {text:?}; allowed are udpin:ADDRESS:PORT, udpout:HOST:PORT and tcp:HOST:PORT; a serial \
             line needs mavlink-router between"
        )),
    }
}

fn address(key: &str, text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| {
        format!("mavlink.{key} is {text:?}; allowed are an address of this computer and a port, such as 127.0.0.1:14550")
    })
}

fn number(key: &str, value: u8, least: u8) -> Result<u8, String> {
    if value >= least {
        Ok(value)
    } else {
        Err(format!("mavlink.{key} is {value}; allowed is {least} to 255"))
    }
}

fn within(key: &str, value: f64, least: f64, most: f64) -> Result<f64, String> {
    // NaN is in no range.
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(format!("mavlink.{key} is {value}; allowed is {least} to {most}"))
}

fn time(key: &str, seconds: f64, most: f64) -> Result<u64, String> {
    let seconds = within(key, seconds, 1.0, most)?;
    Ok(u64::try_from(Duration::from_secs_f64(seconds).as_nanos()).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;

    fn check(text: &str) -> Result<Checked, String> {
        let settings: Settings = toml::from_str(text).map_err(|error| error.to_string())?;
        settings.checked()
    }

    #[test]
    fn invalid_settings_are_reported_with_their_key() {
        let refused = |text: &str, mentioned: &str| {
            let text = if text.starts_with("connection") {
                text.to_owned()
            } else {
                format!("connection = \"udpin:0.0.0.0:14550\"\n{text}")
            };
            assert_mentions(&check(&text).unwrap_err(), mentioned);
        };
        refused("connection = \"/dev/ttyACM0\"", "mavlink.connection .. udpin .. udpout .. tcp");
        refused("connection = \"udpin:localhost:14550\"", "mavlink.connection .. an address");
        refused("connection = \"tcp:localhost\"", "mavlink.connection .. a host and a port");
        refused("connection = \"tcp::5760\"", "mavlink.connection .. a host and a port");
        refused("autopilot_system = 0", "mavlink.autopilot_system is 0 .. 1 to 255");
        refused("component = 1", "mavlink.component is 1 .. 2 to 255");
        refused("altitude_meters = 119.0", "mavlink.altitude_meters is 119 .. 2 to 118");
        refused("altitude_meters = nan", "mavlink.altitude_meters is NaN");
        refused("max_distance_meters = inf", "mavlink.max_distance_meters is inf");
        refused("min_battery_percent = -1.0", "mavlink.min_battery_percent .. 0 to 100");
        refused("link_timeout_seconds = 0.0", "mavlink.link_timeout_seconds .. 1 to 60");
        refused("on_fault = { battery = \"land\" }", "continue .. hold .. home");
        refused("detections = { listen = \"14600\" }", "mavlink.detections.listen .. a port");
        refused("detections = { min_score = 2.0 }", "mavlink.detections.min_score .. 0 to 1");
    }

    #[test]
    fn a_connection_is_enough_and_the_pilot_has_the_vehicle() {
        let checked = check("connection = \"udpin:0.0.0.0:14550\"").unwrap();
        assert_eq!(checked.connection.to_string(), "udpin:0.0.0.0:14550");
        assert_eq!(checked.config.engage, Engage::Pilot);
        let expected = OnFault { battery: Response::Home, fence: Response::Hold, data: Response::Hold };
        assert_eq!(checked.config.on_fault, expected);
        let called = check("connection = \"tcp:autopilot.local:5760\"").unwrap().connection;
        assert_eq!(called, Connection::Tcp("autopilot.local:5760".to_owned()));
    }
}
