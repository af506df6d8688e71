//! An autopilot without its link: messages and wishes in, messages and notices out.

use proptest::prelude::*;

use super::config::{Engage, OnFault, PositionSource, Response};
use super::*;
use crate::common::{
    ATTITUDE_DATA, BATTERY_STATUS_DATA, COMMAND_ACK_DATA, COMMAND_LONG_DATA, FENCE_STATUS_DATA, FenceBreach,
    HOME_POSITION_DATA, LOCAL_POSITION_NED_DATA, MavAutopilot, MavCmd, MavModeFlag, MavParamType, MavResult,
    MavType, PARAM_VALUE_DATA, PositionTargetTypemask, STATUSTEXT_DATA, SYS_STATUS_DATA,
};
use crate::mentions::assert_mentions;

const MS: u64 = 1_000_000;
const GUIDED: u32 = 15;
const RTL: u32 = 11;
const OFFBOARD: u32 = 6 << 16;

fn config() -> Config {
    Config {
        autopilot_system: None,
        system: 1,
        component: 191,
        engage: Engage::Pilot,
        position: PositionSource::Local,
        altitude_meters: Some(30.0),
        limits: Limits { max_distance_meters: 502.0, min_altitude_meters: 5.0, max_altitude_meters: 60.0 },
        min_battery_percent: 20.0,
        on_fault: OnFault { battery: Response::Home, fence: Response::Hold, data: Response::Hold },
        link_timeout_ns: 3000 * MS,
        stuck_ns: 20_000 * MS,
        position_std_meters: 2.0,
    }
}

/// A vehicle that sends its state ten times a second.
struct Site {
    autopilot: Autopilot,
    now_ns: u64,
    boot_ns: u64,
    mavtype: MavType,
    firmware: MavAutopilot,
    mode: u32,
    is_armed: bool,
    /// North, east, down, meters.
    here: [f32; 3],
    system: u32,
    sent: Vec<MavMessage>,
    notices: Vec<Notice>,
    failed: Vec<String>,
}

impl Site {
    fn new(config: Config) -> Self {
        Self {
            autopilot: Autopilot::new(config),
            now_ns: 1_000_000 * MS,
            boot_ns: 0,
            mavtype: MavType::MAV_TYPE_GROUND_ROVER,
            firmware: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            mode: GUIDED,
            is_armed: true,
            here: [0.0; 3],
            system: 1,
            sent: Vec::new(),
            notices: Vec::new(),
            failed: Vec::new(),
        }
    }

    /// A rover that stands at home, armed and guided.
    fn ready() -> Self {
        let mut site = Self::new(config());
        site.pass(1);
        site.clear();
        site
    }

    fn clear(&mut self) {
        self.sent.clear();
        self.notices.clear();
    }

    fn tell(&mut self, event: Event) {
        for action in self.autopilot.handle(self.now_ns, event) {
            match action {
                Action::Send(message) => self.sent.push(*message),
                Action::Tell(notice) => self.notices.push(notice),
                Action::Failed(reason) => self.failed.push(reason),
                Action::Position(_) => {}
            }
        }
    }

    fn receive(&mut self, message: MavMessage) {
        self.receive_from(self.system, 1, message);
    }

    fn receive_from(&mut self, system_id: u32, component_id: u8, message: MavMessage) {
        let header = MavHeader { system_id, component_id, sequence: 0 };
        self.tell(Event::Received(header, Box::new(message)));
    }

    fn boot_ms(&self) -> u32 {
        u32::try_from((self.now_ns - self.boot_ns) / MS).unwrap()
    }

    fn heartbeat(&self) -> MavMessage {
        let armed =
            if self.is_armed { MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED } else { MavModeFlag::empty() };
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: self.mode,
            mavtype: self.mavtype,
            autopilot: self.firmware,
            base_mode: armed,
            ..HEARTBEAT_DATA::default()
        })
    }

    fn position(&self) -> MavMessage {
        let [x, y, z] = self.here;
        let time_boot_ms = self.boot_ms();
        MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
            time_boot_ms,
            x,
            y,
            z,
            ..Default::default()
        })
    }

    fn attitude(&self) -> MavMessage {
        let time_boot_ms = self.boot_ms();
        MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..ATTITUDE_DATA::default() })
    }

    /// A heartbeat now, and seconds of attitudes and positions.
    fn pass(&mut self, seconds: u64) {
        for step in 0..10 * seconds {
            if step % 5 == 0 {
                self.receive(self.heartbeat());
            }
            if step % 10 == 0 {
                self.receive(MavMessage::HOME_POSITION(HOME_POSITION_DATA::default()));
            }
            self.receive(self.attitude());
            self.receive(self.position());
            self.tell(Event::Tick);
            self.now_ns += 100 * MS;
        }
    }

    fn switch(&mut self, mode: u32) {
        self.mode = mode;
        self.receive(self.heartbeat());
    }

    /// North and east of the targets that were sent, and other orders by name; and forgets all that was sent.
    fn orders(&mut self) -> Vec<String> {
        let order = |message: MavMessage| match message {
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(data)
                if !data.type_mask.contains(PositionTargetTypemask::POSITION_TARGET_TYPEMASK_X_IGNORE) =>
            {
                Some(format!("{:.0} {:.0} {:.0}", data.x, data.y, -data.z))
            }
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(_) => Some("standstill".to_owned()),
            MavMessage::COMMAND_LONG(COMMAND_LONG_DATA { command, param1, param2, param7, .. }) => {
                match command {
                    MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH => Some("home".to_owned()),
                    MavCmd::MAV_CMD_DO_SET_MODE => Some(format!("mode {param2}")),
                    MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => Some(format!("arm {param1}")),
                    MavCmd::MAV_CMD_NAV_TAKEOFF => Some(format!("take off {param7}")),
                    _ => None,
                }
            }
            _ => None,
        };
        std::mem::take(&mut self.sent).into_iter().filter_map(order).collect()
    }

    fn assert_noticed(&self, mentioned: &str) {
        let said: Vec<String> =
            self.notices.iter().map(|notice| format!("{}: {}", notice.subject, notice.message)).collect();
        assert_mentions(&said.join("; "), mentioned);
    }
}

fn target(north_meters: f64, east_meters: f64) -> Target {
    Target { place: Place::Local { north_meters, east_meters }, yaw_radians: 0.0 }
}

fn distinct(mut orders: Vec<String>) -> Vec<String> {
    orders.dedup();
    orders
}

#[test]
fn a_target_is_sent_at_once_and_again_every_second() {
    let mut site = Site::ready();
    site.tell(Event::Go(target(10.0, 20.0)));
    assert_eq!(site.orders(), ["10 20 0"]);
    site.pass(3);
    assert_eq!(site.orders(), ["10 20 0"; 2]);
    site.tell(Event::Go(target(10.0, 30.0)));
    site.tell(Event::Go(target(10.0, 30.0)));
    assert_eq!(site.orders(), ["10 30 0"]);
    site.tell(Event::Hold);
    assert_eq!(site.orders(), ["0 0 0"]);
}

#[test]
fn the_robot_yields_to_the_pilot_at_once_and_goes_on_when_the_mode_is_back() {
    for other in [0, 4, 10, RTL] {
        let mut site = Site::ready();
        site.tell(Event::Go(target(10.0, 20.0)));
        site.switch(other);
        site.clear();
        site.tell(Event::Go(target(30.0, 20.0)));
        site.here = [3.0, 4.0, 0.0];
        site.pass(30);
        assert!(site.orders().is_empty(), "{other}");
        assert!(site.failed.is_empty(), "a pilot is not stuck: {:?}", site.failed);
        site.switch(GUIDED);
        assert_eq!(site.orders(), ["30 20 0"]);
    }
}

#[test]
fn a_disarmed_vehicle_is_not_steered_and_not_armed() {
    let mut site = Site::new(config());
    site.is_armed = false;
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(10);
    assert!(site.orders().is_empty());
    site.assert_noticed("control: .. disarmed");
    site.is_armed = true;
    site.pass(1);
    assert_eq!(site.orders(), ["10 20 0"]);
    site.assert_noticed("control: the robot steers");
}

#[test]
fn without_heartbeats_nothing_is_sent_that_moves_the_vehicle() {
    let mut site = Site::ready();
    site.tell(Event::Go(target(10.0, 20.0)));
    for _ in 0..60 {
        site.receive(site.attitude());
        site.receive(site.position());
        site.tell(Event::Tick);
        site.now_ns += 100 * MS;
    }
    site.assert_noticed("link: heartbeats have stopped .. failsafe");
    site.clear();
    for _ in 0..30 {
        site.tell(Event::Tick);
        site.now_ns += 100 * MS;
    }
    assert!(site.orders().is_empty());
    site.pass(4);
    assert_eq!(distinct(site.orders()), ["10 20 0"]);
    site.assert_noticed("link: well again");
}

/// What is sent, from a target on, while something is wrong, and what is said.
fn check_fault(config: Config, wrong: impl Fn(&mut Site), order: &str, mentioned: &str) {
    let mut site = Site::new(config);
    site.pass(1);
    site.tell(Event::Go(target(10.0, 20.0)));
    site.clear();
    for _ in 0..3 {
        wrong(&mut site);
        site.pass(1);
    }
    assert_eq!(distinct(site.orders()).last().map(String::as_str), Some(order), "{mentioned}");
    site.assert_noticed(mentioned);
}

fn battery(battery_remaining: i8) -> impl Fn(&mut Site) {
    move |site| {
        let data = SYS_STATUS_DATA { battery_remaining, ..SYS_STATUS_DATA::default() };
        site.receive(MavMessage::SYS_STATUS(data));
    }
}

fn jumping(site: &mut Site) {
    for battery_remaining in [90, 15] {
        let data = BATTERY_STATUS_DATA { id: 2, battery_remaining, ..BATTERY_STATUS_DATA::default() };
        site.receive(MavMessage::BATTERY_STATUS(data));
    }
}

fn breach(site: &mut Site) {
    let data = FENCE_STATUS_DATA {
        breach_status: 1,
        breach_type: FenceBreach::FENCE_BREACH_BOUNDARY,
        ..FENCE_STATUS_DATA::default()
    };
    site.receive(MavMessage::FENCE_STATUS(data));
}

#[test]
fn on_a_fault_the_vehicle_does_what_the_settings_say_and_says_why() {
    let with = |change: fn(&mut OnFault)| {
        let mut changed = config();
        change(&mut changed.on_fault);
        changed
    };
    check_fault(config(), battery(10), "home", "battery: .. 10 % .. 20 %");
    let on = with(|on_fault| on_fault.battery = Response::Continue);
    check_fault(on, battery(10), "10 20 0", "battery: .. 10 %");
    check_fault(config(), jumping, "0 0 0", "charge: battery 2 jumps from 90 to 15 %");
    check_fault(with(|on_fault| on_fault.data = Response::Home), jumping, "home", "charge: battery 2 jumps");
    check_fault(config(), breach, "0 0 0", "fence: .. FENCE_BREACH_BOUNDARY");
    check_fault(with(|on_fault| on_fault.fence = Response::Home), breach, "home", "fence:");
    let second = |site: &mut Site| site.receive_from(7, 1, site.heartbeat());
    check_fault(config(), second, "0 0 0", "identity: .. systems 1 and 7 .. mavlink.autopilot_system");
    // No other fault hides the strictest response.
    let both = |site: &mut Site| {
        breach(site);
        battery(10)(site);
    };
    check_fault(config(), both, "home", "battery:");
}

#[test]
fn a_height_that_is_no_number_stops_the_vehicle_where_it_is() {
    let mut site = Site::ready();
    site.tell(Event::Go(target(10.0, 20.0)));
    site.here[2] = f32::NAN;
    site.pass(1);
    site.assert_noticed("position: LOCAL_POSITION_NED: .. NaN m");
    // For as long as the last position is recent it is where to stay.
    assert_eq!(distinct(site.orders()), ["10 20 0", "0 0 0"]);
    site.pass(4);
    assert_eq!(distinct(site.orders()), ["0 0 0", "standstill"]);
    site.here[2] = 0.0;
    site.pass(4);
    assert_eq!(distinct(site.orders()), ["standstill", "0 0 0", "10 20 0"]);
    site.assert_noticed("position: well again");
}

#[test]
fn other_systems_and_components_are_not_the_autopilot() {
    let mut named = config();
    named.autopilot_system = Some(1);
    let mut site = Site::new(named);
    site.receive_from(7, 1, site.heartbeat());
    site.receive_from(1, 25, site.heartbeat());
    site.receive_from(300, 1, site.heartbeat());
    site.tell(Event::Go(target(10.0, 20.0)));
    site.now_ns += 4000 * MS;
    site.tell(Event::Tick);
    assert!(site.orders().is_empty());
    site.assert_noticed("link: no heartbeat of system 1");
    site.pass(4);
    site.receive_from(7, 1, site.heartbeat());
    assert_eq!(distinct(site.orders()), ["10 20 0"]);
    assert!(!site.notices.iter().any(|notice| notice.subject == "identity"));
}

#[test]
fn two_autopilots_with_one_number_are_noticed() {
    let mut site = Site::ready();
    site.tell(Event::Go(target(10.0, 20.0)));
    for _ in 0..10 {
        site.pass(1);
        let data = LOCAL_POSITION_NED_DATA { time_boot_ms: 77_000, ..LOCAL_POSITION_NED_DATA::default() };
        site.receive(MavMessage::LOCAL_POSITION_NED(data));
    }
    site.assert_noticed("identity: two autopilots .. system 1");
    let last = site.orders().pop().unwrap();
    assert!(["0 0 0", "standstill"].contains(&last.as_str()), "{last}");
}

#[test]
fn an_autopilot_that_starts_again_gets_its_vehicle_back() {
    let mut site = Site::ready();
    site.tell(Event::Go(target(10.0, 20.0)));
    site.boot_ns = site.now_ns;
    (site.mode, site.is_armed) = (4, false);
    site.pass(5);
    site.assert_noticed("link: the autopilot has started again");
    site.clear();
    site.pass(5);
    assert!(site.orders().is_empty());
    (site.mode, site.is_armed) = (GUIDED, true);
    site.pass(1);
    assert_eq!(distinct(site.orders()), ["10 20 0"]);
}

#[test]
fn what_does_not_come_is_asked_for_again() {
    let mut site = Site::new(config());
    site.pass(7);
    let count = |site: &Site, wanted: f32| {
        let is_request = |message: &&MavMessage| {
            matches!(message, MavMessage::COMMAND_LONG(data)
                if data.command == MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL && (data.param1 - wanted).abs() < 0.5)
        };
        site.sent.iter().filter(is_request).count()
    };
    // The battery never comes; the attitude comes from the beginning on.
    assert_eq!((count(&site, 147.0), count(&site, 30.0)), (3, 0));
    let parameters = site.sent.iter().filter(|message| matches!(message, MavMessage::PARAM_REQUEST_READ(_)));
    assert_eq!(parameters.count(), 12);
}

#[test]
fn targets_beyond_the_autopilots_fence_are_not_sent() {
    let mut site = Site::ready();
    for (name, param_value) in
        [("FENCE_ENABLE", 1.0), ("FENCE_TYPE", 2.0), ("FENCE_RADIUS", 102.0), ("FENCE_ALT_MAX", 0.0)]
    {
        let (param_id, param_type) = (name.into(), MavParamType::MAV_PARAM_TYPE_REAL32);
        let data = PARAM_VALUE_DATA { param_id, param_value, param_type, ..PARAM_VALUE_DATA::default() };
        site.receive(MavMessage::PARAM_VALUE(data));
    }
    site.tell(Event::Go(target(100.0, 0.0)));
    assert_eq!(site.orders(), ["100 0 0"]);
    site.tell(Event::Go(target(101.0, 0.0)));
    assert_eq!(site.orders(), ["0 0 0"]);
    assert_mentions(&site.failed.join(""), "101 m from home .. 100 m");
    site.assert_noticed("target: .. 101 m");
}

#[test]
fn a_vehicle_that_does_not_move_gives_its_target_up() {
    let mut site = Site::ready();
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(15);
    site.here = [5.0, 0.0, 0.0];
    site.pass(15);
    assert!(site.failed.is_empty());
    site.pass(10);
    assert_mentions(&site.failed.join(""), "not moved for 20 s");
    assert_eq!(site.orders().last().unwrap(), "5 0 0");
    site.here = [10.0, 20.0, 0.0];
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(40);
    assert_eq!(site.failed.len(), 1, "at its target it may stand");
}

#[test]
fn while_home_is_unknown_the_vehicle_stays_and_keeps_its_target() {
    let mut site = Site::new(config());
    site.tell(Event::Go(target(10.0, 20.0)));
    site.receive(site.heartbeat());
    assert!(site.orders().is_empty(), "nothing is sent before a position");
    site.receive(site.attitude());
    site.receive(site.position());
    assert_eq!(site.orders(), ["0 0 0"]);
    site.assert_noticed("target: home is unknown");
    site.receive(MavMessage::HOME_POSITION(HOME_POSITION_DATA::default()));
    assert_eq!(site.orders(), ["10 20 0"]);
    assert!(site.failed.is_empty());
}

fn copter(engage: Engage) -> Site {
    let mut site = Site::new(Config { engage, ..config() });
    (site.mavtype, site.mode, site.is_armed) = (MavType::MAV_TYPE_QUADROTOR, 5, false);
    site
}

#[test]
fn a_robot_that_is_told_to_arms_its_copter_and_takes_off_once() {
    let mut site = copter(Engage::Robot);
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(3);
    assert_eq!(site.orders(), ["mode 4"; 3]);
    site.mode = 4;
    site.pass(2);
    assert_eq!(distinct(site.orders()), ["arm 1"]);
    site.is_armed = true;
    site.pass(2);
    assert_eq!(distinct(site.orders()), ["take off 30"]);
    site.here[2] = -29.0;
    site.pass(1);
    assert_eq!(distinct(site.orders()), ["10 20 30"]);
    // A pilot lands and disarms: it stays so.
    (site.mode, site.is_armed) = (9, false);
    site.pass(5);
    assert!(site.orders().is_empty());
}

#[test]
fn a_robot_does_not_take_a_vehicle_from_a_pilot() {
    let mut site = copter(Engage::Robot);
    site.is_armed = true;
    site.pass(5);
    assert!(site.orders().is_empty());
    site.assert_noticed("start: somebody else has the vehicle");
    let mut site = copter(Engage::Robot);
    site.pass(2);
    site.is_armed = true;
    site.clear();
    site.pass(5);
    assert!(site.orders().is_empty(), "armed by a pilot, in the pilot's mode");
}

#[test]
fn an_autopilot_that_refuses_to_arm_is_asked_no_longer() {
    let mut site = copter(Engage::Robot);
    site.mode = 4;
    site.pass(3);
    let (command, result) = (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, MavResult::MAV_RESULT_FAILED);
    site.receive(MavMessage::COMMAND_ACK(COMMAND_ACK_DATA { command, result, ..Default::default() }));
    site.pass(40);
    assert_eq!(site.orders().len(), 30);
    site.assert_noticed("start: .. does not arm .. MAV_RESULT_FAILED");
}

#[test]
fn a_copter_on_the_ground_and_one_without_an_altitude_are_not_steered() {
    let mut site = copter(Engage::Pilot);
    (site.mode, site.is_armed) = (4, true);
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(2);
    assert!(site.orders().is_empty());
    site.assert_noticed("control: .. on the ground");
    let mut site = Site::new(Config { altitude_meters: None, ..config() });
    site.mavtype = MavType::MAV_TYPE_QUADROTOR;
    (site.mode, site.here[2]) = (4, -30.0);
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(2);
    assert!(site.orders().is_empty());
    site.assert_noticed("vehicle: .. mavlink.altitude_meters");
}

#[test]
fn px4_gets_its_own_place_until_it_is_the_robots() {
    let mut site = Site::new(config());
    (site.firmware, site.mavtype) = (MavAutopilot::MAV_AUTOPILOT_PX4, MavType::MAV_TYPE_QUADROTOR);
    (site.mode, site.here) = (3 << 16, [1.0, 2.0, -20.0]);
    site.tell(Event::Go(target(10.0, 20.0)));
    site.pass(2);
    let streamed = site.orders();
    assert!(streamed.len() >= 9 && streamed.iter().all(|order| order == "1 2 30"), "{streamed:?}");
    site.switch(OFFBOARD);
    site.pass(1);
    let streamed = site.orders();
    assert!(streamed.len() >= 5 && streamed.iter().all(|order| order == "10 20 30"), "{streamed:?}");
}

#[test]
fn ground_stations_read_notices_in_parts() {
    let mut site = Site::ready();
    let message = "a".repeat(80);
    site.tell(Event::Say(Notice {
        level: Level::Error,
        subject: "pose".to_owned(),
        message: message.clone(),
    }));
    let texts: Vec<STATUSTEXT_DATA> = site
        .sent
        .iter()
        .filter_map(|message| match message {
            MavMessage::STATUSTEXT(data) => Some(data.clone()),
            _ => None,
        })
        .collect();
    let joined: String = texts.iter().map(|text| text.text.to_str().unwrap()).collect();
    assert_eq!(joined, format!("dragnet: pose: {message}"));
    assert!(texts.len() == 2 && texts[0].id != 0 && texts[0].id == texts[1].id);
    assert_eq!((texts[0].chunk_seq, texts[1].chunk_seq), (0, 1));
}

proptest! {
    /// Whatever is wished, lost and switched: no target is outside of the limits, none is sent in another mode.
    #[test]
    fn no_order_leaves_the_limits_or_the_mode(
        steps in proptest::collection::vec((-900.0_f64..900.0, -900.0_f64..900.0, 0_u8..10), 1..60)
    ) {
        let mut site = Site::ready();
        let limits = config().limits;
        for (north, east, kind) in steps {
            match kind {
                0 => site.switch(RTL),
                1 => site.switch(GUIDED),
                2 => site.here = [1.0, f32::NAN, 0.0],
                3 => site.here = [2.0, 0.0, 0.0],
                4 => breach(&mut site),
                5 => site.tell(Event::Hold),
                6 => site.now_ns += 2000 * MS,
                _ => site.tell(Event::Go(target(north, east))),
            }
            if kind > 1 {
                site.receive(site.position());
            }
            let is_guided = site.mode == GUIDED;
            for order in site.orders() {
                prop_assert!(is_guided, "{}", order);
                let numbers: Vec<f64> = order.split(' ').filter_map(|number| number.parse().ok()).collect();
                if let [north, east, _] = numbers[..] {
                    prop_assert!(north.hypot(east) <= limits.max_distance_meters - 1.0, "{}", order);
                }
            }
        }
    }
}
