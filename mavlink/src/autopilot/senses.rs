//! What an autopilot says of its vehicle: position, attitude, home, batteries, fence and mission.

use std::f64::consts::PI;

use mavlink_core::Message;

use super::boot_clock::Stamped;
use super::config::PositionSource;
use super::{Action, Autopilot, Level, Subject};
use crate::MavMessage;
use crate::common::{ATTITUDE_DATA, FENCE_STATUS_DATA, GPS_RAW_INT_DATA, GpsFixType, HOME_POSITION_DATA};
use crate::target::{Place, Position};

/// Number under which the charge of `SYS_STATUS` is kept: no `BATTERY_STATUS` has it.
const SYSTEM_BATTERY: u8 = u8::MAX;
/// `GLOBAL_POSITION_INT` has no heading.
const NO_HEADING: u16 = u16::MAX;
/// Age up to which an attitude goes with a position, nanoseconds.
const ATTITUDE_NS: u64 = 500_000_000;
/// The highest height above home that is one, meters.
const MAX_ALTITUDE_METERS: f64 = 50_000.0;

/// The state of a vehicle.
#[derive(Clone, Debug, Default)]
pub(super) struct Senses {
    position: Option<Position>,
    /// When it came; before the first, when it was expected to.
    received_ns: Option<u64>,
    /// Roll, pitch and yaw, radians, and when they came.
    attitude: Option<([f64; 3], u64)>,
    home: Option<Place>,
    gnss: Option<Gnss>,
    /// The item of the autopilot's own mission.
    mission_item: Option<u16>,
}

#[derive(Clone, Copy, Debug)]
struct Gnss {
    has_fix: bool,
    /// Standard deviation, meters, if the receiver gives it.
    std_meters: Option<f64>,
}

/// The name of the message with the position.
pub(super) const fn position_name(source: PositionSource) -> &'static str {
    match source {
        PositionSource::Global => "GLOBAL_POSITION_INT",
        PositionSource::Local => "LOCAL_POSITION_NED",
    }
}

impl Senses {
    pub(super) const fn position(&self) -> Option<&Position> {
        self.position.as_ref()
    }

    pub(super) const fn home(&self) -> Option<&Place> {
        self.home.as_ref()
    }

    pub(super) const fn mission_item(&self) -> Option<u16> {
        self.mission_item
    }

    /// Time since the last valid position.
    pub(super) fn silence_ns(&self, now_ns: u64) -> u64 {
        self.received_ns.map_or(0, |received_ns| now_ns.saturating_sub(received_ns))
    }

    /// From now on positions are expected.
    pub(super) fn begin(&mut self, now_ns: u64) {
        self.received_ns.get_or_insert(now_ns);
    }

    fn attitude(&self, now_ns: u64) -> Option<[f64; 3]> {
        self.attitude
            .filter(|(_, heard_ns)| now_ns.saturating_sub(*heard_ns) <= ATTITUDE_NS)
            .map(|(angles, _)| angles)
    }
}

/// A place and a height as an autopilot sends them.
struct Fix {
    place: Place,
    altitude_meters: f64,
    yaw_radians: Option<f64>,
}

impl Autopilot {
    /// A message of the autopilot.
    pub(super) fn sense(&mut self, message: &MavMessage) {
        let kind = message.message_id();
        self.senses.begin(self.now_ns);
        self.heard_ns.insert(kind, self.now_ns);
        match message {
            MavMessage::GLOBAL_POSITION_INT(data) if self.config.position == PositionSource::Global => {
                let [latitude_degrees, longitude_degrees] =
                    [data.lat, data.lon].map(|degrees| f64::from(degrees) / 1e7);
                self.locate(
                    kind,
                    data.time_boot_ms,
                    &Fix {
                        place: Place::Global { latitude_degrees, longitude_degrees },
                        altitude_meters: f64::from(data.relative_alt) / 1000.0,
                        yaw_radians: (data.hdg != NO_HEADING)
                            .then(|| (f64::from(data.hdg) / 100.0).to_radians()),
                    },
                );
            }
            MavMessage::LOCAL_POSITION_NED(data) if self.config.position == PositionSource::Local => {
                let [north_meters, east_meters, down_meters] = [data.x, data.y, data.z].map(f64::from);
                self.locate(
                    kind,
                    data.time_boot_ms,
                    &Fix {
                        place: Place::Local { north_meters, east_meters },
                        altitude_meters: -down_meters,
                        yaw_radians: None,
                    },
                );
            }
            MavMessage::ATTITUDE(data) => self.turn(kind, data),
            MavMessage::SYSTEM_TIME(data) => {
                self.stamped(kind, data.time_boot_ms);
            }
            MavMessage::GPS_RAW_INT(data) => self.senses.gnss = Some(Gnss::of(data)),
            MavMessage::HOME_POSITION(data) => self.senses.home = home(self.config.position, data),
            MavMessage::SYS_STATUS(data) => self.charge(SYSTEM_BATTERY, data.battery_remaining),
            MavMessage::BATTERY_STATUS(data) => self.charge(data.id, data.battery_remaining),
            MavMessage::FENCE_STATUS(data) => self.judge_fence(data),
            MavMessage::PARAM_VALUE(data) => self.fence.read(data),
            MavMessage::MISSION_CURRENT(data) => self.senses.mission_item = Some(data.seq),
            MavMessage::COMMAND_ACK(data) => self.starter.hear(data.command, data.result),
            _ => {}
        }
    }

    /// When a message was true; `None` if a newer one came before it.
    fn stamped(&mut self, kind: u32, stamp_ms: u32) -> Option<u64> {
        match self.clock.read(self.now_ns, kind, stamp_ms) {
            Stamped::New(time_ns) => Some(time_ns),
            Stamped::Late => None,
            Stamped::Rebooted(time_ns) => {
                self.notice_reboot();
                self.senses.begin(self.now_ns);
                Some(time_ns)
            }
        }
    }

    fn turn(&mut self, kind: u32, data: &ATTITUDE_DATA) {
        if self.stamped(kind, data.time_boot_ms).is_none() {
            return;
        }
        let angles = [data.roll, data.pitch, data.yaw].map(f64::from);
        if angles.iter().all(|angle| angle.abs() <= 2.0 * PI) {
            self.senses.attitude = Some((angles, self.now_ns));
        } else {
            let message = format!("ATTITUDE has {angles:?}; allowed are angles in radians");
            self.ill(Subject::Input, Level::Warning, message);
        }
    }

    fn locate(&mut self, kind: u32, stamp_ms: u32, fix: &Fix) {
        let Some(time_ns) = self.stamped(kind, stamp_ms) else { return };
        match self.judged(fix) {
            Ok(position) => {
                let position = Position { time_ns, ..position };
                self.senses.position = Some(position);
                self.senses.received_ns = Some(self.now_ns);
                self.well(Subject::Position);
                self.actions.push(Action::Position(position));
            }
            Err(reason) => {
                let name = position_name(self.config.position);
                self.ill(Subject::Position, Level::Error, format!("{name}: {reason}"));
            }
        }
    }

    /// A position without its time.
    fn judged(&self, fix: &Fix) -> Result<Position, String> {
        check_place(&fix.place)?;
        let altitude_meters = fix.altitude_meters;
        // NaN is in no range.
        if !(-MAX_ALTITUDE_METERS..=MAX_ALTITUDE_METERS).contains(&altitude_meters) {
            return Err(format!(
                "a height of {altitude_meters} m; allowed are {MAX_ALTITUDE_METERS} m above or below home"
            ));
        }
        let gnss = self.senses.gnss.filter(|_| self.config.position == PositionSource::Global);
        if gnss.is_some_and(|gnss| !gnss.has_fix) {
            return Err("the receiver has no fix in three dimensions".to_owned());
        }
        let attitude = self.senses.attitude(self.now_ns);
        let Some(yaw_radians) = fix.yaw_radians.or(attitude.map(|[.., yaw]| yaw)) else {
            return Err("it has no heading, and no ATTITUDE of the last half second has".to_owned());
        };
        let [roll_radians, pitch_radians, _] = attitude.unwrap_or_default();
        Ok(Position {
            time_ns: 0,
            place: fix.place,
            altitude_meters,
            yaw_radians,
            roll_radians,
            pitch_radians,
            std_meters: gnss.and_then(|gnss| gnss.std_meters).unwrap_or(self.config.position_std_meters),
        })
    }

    fn charge(&mut self, number: u8, percent: i8) {
        match self.batteries.read(self.now_ns, number, percent) {
            Ok(()) => self.well(Subject::Charge),
            Err(reason) => self.ill(Subject::Charge, Level::Error, reason),
        }
        let Some(lowest) = self.batteries.lowest_percent() else { return };
        let min = self.config.min_battery_percent;
        if f64::from(lowest) < min {
            let message = format!("the battery is at {lowest} %; needed are {min} %");
            self.ill(Subject::Battery, Level::Error, message);
        } else {
            self.well(Subject::Battery);
        }
    }

    fn judge_fence(&mut self, data: &FENCE_STATUS_DATA) {
        if data.breach_status == 0 {
            self.well(Subject::Fence);
        } else {
            let message = format!("the autopilot reports a breach of its fence: {:?}", data.breach_type);
            self.ill(Subject::Fence, Level::Error, message);
        }
    }
}

impl Gnss {
    fn of(data: &GPS_RAW_INT_DATA) -> Self {
        let has_fix = !matches!(
            data.fix_type,
            GpsFixType::GPS_FIX_TYPE_NO_GPS
                | GpsFixType::GPS_FIX_TYPE_NO_FIX
                | GpsFixType::GPS_FIX_TYPE_2D_FIX
        );
        // 0 is what receivers without an estimate send.
        let std_meters = (data.h_acc > 0 && data.h_acc < u32::MAX).then(|| f64::from(data.h_acc) / 1000.0);
        Self { has_fix, std_meters }
    }
}

fn check_place(place: &Place) -> Result<(), String> {
    match *place {
        Place::Global { latitude_degrees, longitude_degrees } => {
            let is_on_earth = latitude_degrees.abs() <= 90.0 && longitude_degrees.abs() <= 180.0;
            let is_unset = latitude_degrees.abs() < 1e-6 && longitude_degrees.abs() < 1e-6;
            if is_on_earth && !is_unset {
                return Ok(());
            }
            Err(format!(
                "a latitude of {latitude_degrees} and a longitude of {longitude_degrees} degrees; allowed are -90 to 90 \
                 and -180 to 180, and not both 0"
            ))
        }
        Place::Local { north_meters, east_meters } if (north_meters + east_meters).is_finite() => Ok(()),
        Place::Local { north_meters, east_meters } => {
            Err(format!("{north_meters} m north and {east_meters} m east; allowed are numbers"))
        }
    }
}

/// Home, if the message has one.
fn home(source: PositionSource, data: &HOME_POSITION_DATA) -> Option<Place> {
    let place = match source {
        PositionSource::Global => {
            let [latitude_degrees, longitude_degrees] =
                [data.latitude, data.longitude].map(|degrees| f64::from(degrees) / 1e7);
            Place::Global { latitude_degrees, longitude_degrees }
        }
        PositionSource::Local => {
            Place::Local { north_meters: f64::from(data.x), east_meters: f64::from(data.y) }
        }
    };
    check_place(&place).is_ok().then_some(place)
}
