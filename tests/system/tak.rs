//! The mission on the maps of TAK: what a real coordinator sends, read by pytak and takproto.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use dragnet_keys::folder::Folder;
use dragnet_keys::name::Name;
use dragnet_keys::register::Topology;
use dragnet_runtime::session::free_endpoints;
use dragnet_scenario::Scenario;
use dragnet_search::cell::Cell;
use serde_json::Value;
use tempfile::TempDir;
use time::OffsetDateTime;

use crate::field::{DRAGNET, Field};
use crate::interpreter::interpreter;
use crate::operator::Operator;
use crate::security::Process;

const PATIENCE: Duration = Duration::from_mins(1);
const SCENARIO: &str = "name = \"field\"\n[map]\nfile = \"site.geojson\"\ncell_meters = 20.0\n[objects]\ncount = 4\n\
                        [robots]\ncount = 2\npolicy = \"path\"\n[mission]\nbudget_meters = 36000.0\n\
                        stop_when_expected_remaining = 0.001\n";

/// A search area of about 300 m, and in it a no-go area that is a triangle.
fn areas() -> String {
    let feature = |name: &str, kind: &str, corners: &[[f64; 2]]| {
        format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"name\": \"{name}\", \"kind\": \"{kind}\"}}, \"geometry\": \
             {{\"type\": \"Polygon\", \"coordinates\": [{corners:?}]}}}}"
        )
    };
    let wood = [[9.5, 47.5], [9.504, 47.5], [9.504, 47.5027], [9.5, 47.5027], [9.5, 47.5]];
    let pond = [[9.501, 47.501], [9.502, 47.501], [9.502, 47.5015], [9.501, 47.501]];
    let features = [feature("Wood & meadow", "search", &wood), feature("Pond", "no_go", &pond)];
    format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(", "))
}

/// TAK, played by `tests/python/tak.py`.
struct Tak {
    child: Child,
    commands: Option<ChildStdin>,
    lines: Receiver<String>,
    port: u16,
}

impl Tak {
    fn start(arguments: &[&str]) -> Self {
        let workspace = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut child = Command::new(interpreter(workspace))
            .args(["-W", "ignore"])
            .arg(workspace.join("tests/python/tak.py"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, lines) = channel();
        let printed = BufReader::new(child.stdout.take().unwrap()).lines();
        std::thread::spawn(move || printed.map_while(Result::ok).try_for_each(|line| sender.send(line)));
        let port = lines.recv_timeout(PATIENCE).unwrap().parse().unwrap();
        Self { commands: child.stdin.take(), child, lines, port }
    }

    /// The next event.
    fn event(&self) -> Value {
        serde_json::from_str(&self.lines.recv_timeout(PATIENCE).unwrap()).unwrap()
    }

    /// The next event that is as wanted; all before it are checked too.
    fn until(&self, is_it: impl Fn(&Value) -> bool) -> Value {
        loop {
            let event = self.event();
            check_times(&event);
            if is_it(&event) {
                return event;
            }
        }
    }

    fn drop_connections(&mut self) {
        writeln!(self.commands.as_mut().unwrap(), "drop").unwrap();
    }
}

impl Drop for Tak {
    fn drop(&mut self) {
        drop(self.commands.take());
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn check_times(event: &Value) {
    let ms = |key: &str| event[key].as_i64().unwrap();
    assert_eq!(ms("time_ms"), ms("start_ms"), "{event}");
    assert!(ms("stale_ms") > ms("time_ms"), "{event}");
    // The clock of this computer, not that of a simulation from the year 2000.
    let now_ms = i64::try_from(OffsetDateTime::now_utc().unix_timestamp_nanos() / 1_000_000).unwrap();
    assert!((now_ms - ms("time_ms")).abs() < 3_600_000, "{event}");
}

/// A mission on the earth with a coordinator that sends it to TAK.
struct Site {
    folder: TempDir,
}

impl Site {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("field.toml"), SCENARIO).unwrap();
        fs::write(folder.path().join("site.geojson"), areas()).unwrap();
        Self { folder }
    }

    /// The coordinator with these settings of TAK.
    fn coordinator(&self, tak: &str) -> Command {
        let endpoint = &free_endpoints(1).unwrap()[0];
        let settings = format!(
            "[common]\nmission = \"field\"\nscenario = \"field.toml\"\nzenoh = {{ listen = [{endpoint:?}] }}\n[tak]\n{tak}\n"
        );
        let file = self.path("coordinator.toml");
        fs::write(&file, settings).unwrap();
        let mut command = Command::new(DRAGNET);
        command.args(["coordinator", "--config"]).arg(file);
        command
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// The cell whose center is there.
fn cell_at(scenario: &Scenario, event: &Value) -> Cell {
    let number = |index: usize| event["point"][index].as_f64().unwrap();
    let is_there = |cell: &Cell| {
        let center = scenario.places().center(*cell).unwrap();
        (center.latitude_degrees - number(0)).abs() < 1e-6
            && (center.longitude_degrees - number(1)).abs() < 1e-6
    };
    let mut there = scenario.terrain().grid().cells().filter(is_there);
    assert!((number(2) - 14.1).abs() < 0.1, "half a diagonal of 20 m: {event}");
    there.next().unwrap_or_else(|| panic!("no cell is there: {event}"))
}

fn text<'a>(event: &'a Value, key: &str) -> &'a str {
    event[key].as_str().unwrap_or_else(|| panic!("{key}: {event}"))
}

#[test]
fn maps_show_robots_and_finds_of_a_search_and_lose_a_dismissed_one() {
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let tak = Tak::start(&["udp", &port.to_string()]);
    let field = Field::new(SCENARIO, 2, 3);
    fs::write(field.path("site.geojson"), areas()).unwrap();
    let operator = Operator::new();
    let settings = operator.settings(&field, &field.path("field.mcap"));
    let more = format!("[tak]\nurl = \"udp://127.0.0.1:{port}\"\nperiod_seconds = 0.1\n");
    fs::write(&settings, fs::read_to_string(&settings).unwrap() + &more).unwrap();
    let coordinator = Process::start(Command::new(DRAGNET).args(["coordinator", "--config"]).arg(settings));
    let robots = [field.robot(1), field.robot(2)];
    let world = field.world();
    let scenario = field.scenario();
    let mut cells: BTreeMap<String, BTreeSet<Cell>> = BTreeMap::new();
    let mut finds: BTreeMap<String, Cell> = BTreeMap::new();
    // Each robot is seen in several cells, and all objects are found.
    while finds.len() < 4 || cells.len() < 2 || cells.values().any(|cells| cells.len() < 2) {
        let event = tak.event();
        check_times(&event);
        let uid = text(&event, "uid").to_owned();
        let lasts_ms = event["stale_ms"].as_i64().unwrap() - event["time_ms"].as_i64().unwrap();
        match (text(&event, "type"), text(&event, "how")) {
            ("a-f-G-E-V", "m-g") => {
                let cell = cell_at(&scenario, &event);
                assert!(scenario.terrain().is_traversable(cell), "{event}");
                assert_eq!(lasts_ms, 400, "{event}");
                assert!(text(&event, "callsign").ends_with(" (field, simulated)"), "{event}");
                assert!(text(&event, "remarks").contains("m driven of at most 36000 m"), "{event}");
                cells.entry(uid).or_default().insert(cell);
            }
            ("b-m-p-s-m", "m-f") => {
                let cell = cell_at(&scenario, &event);
                assert_eq!(uid, format!("dragnet.field.find-{}", cell.number()));
                assert!(text(&event, "remarks").starts_with("object (9"), "{event}");
                assert!(text(&event, "callsign").starts_with("Find "), "{event}");
                finds.insert(uid, cell);
            }
            // A find that further readings have withdrawn.
            ("t-x-d-d", _) => drop(finds.remove(text(&event, "removes"))),
            (kind, how) => assert_eq!((kind, how), ("u-d-f", "h-e"), "{event}"),
        }
    }
    let names: Vec<&str> = cells.keys().map(String::as_str).collect();
    assert_eq!(names, ["dragnet.field.robot-1", "dragnet.field.robot-2"]);
    let outcome: Value = serde_json::from_str(&world.output()).unwrap();
    assert_eq!(outcome["recall"], 1.0, "{outcome}");
    // The operator dismisses a find that is there at the end of the search.
    let find = tak.until(|event| event["type"] == "b-m-p-s-m");
    let position = scenario.terrain().grid().position(cell_at(&scenario, &find));
    let command = format!(
        "{{\"command\":\"find\",\"row\":{},\"column\":{},\"as\":\"dismissed\"}}",
        position.row, position.column
    );
    operator.order(&command);
    let removal = tak.until(|event| event["type"] == "t-x-d-d" && event["removes"] == find["uid"]);
    assert_ne!(removal["uid"], find["uid"]);
    drop((robots, coordinator));
}

/// The shapes of both areas over a connection.
fn check_areas(tak: &Tak, connection: u64) {
    let of_connection = |event: &Value, name: &str| {
        event["connection"] == connection && event["uid"] == format!("dragnet.field.{name}").as_str()
    };
    let wood = tak.until(|event| of_connection(event, "area-1-1"));
    assert_eq!((text(&wood, "type"), text(&wood, "callsign")), ("u-d-f", "Wood & meadow"));
    let corners = wood["corners"].as_array().unwrap();
    assert_eq!((corners.len(), &corners[0]), (5, &corners[4]), "{wood}");
    assert!(corners.contains(&serde_json::json!([47.5027, 9.504])), "latitude first: {wood}");
    let pond = tak.until(|event| of_connection(event, "area-2-1"));
    assert_eq!(pond["corners"].as_array().unwrap().len(), 4, "{pond}");
    assert_eq!(text(&pond, "remarks"), "no-go area: no robot enters it");
}

#[test]
fn a_server_that_ends_the_connection_gets_the_mission_again_over_tcp() {
    let mut tak = Tak::start(&["tcp"]);
    let site = Site::new();
    let url = format!("url = \"tcp://127.0.0.1:{}\"\nperiod_seconds = 0.1", tak.port);
    let coordinator = Process::start(&mut site.coordinator(&url));
    check_areas(&tak, 1);
    tak.drop_connections();
    check_areas(&tak, 2);
    coordinator.logs(&["TAK at tcp://127.0.0.1", "it is tried again, and the mission goes on"]);
    coordinator.logs(&["TAK at tcp://127.0.0.1", "is there again"]);
}

/// Certificates of the mission: those of its simulator are for the server.
fn certificates(site: &Site) -> Folder {
    let now = OffsetDateTime::now_utc();
    let mut keys = Folder::init(&site.path("keys"), "field".parse().unwrap(), Topology::Mesh, now).unwrap();
    keys.add(&[Name::Simulator], &["127.0.0.1".to_owned()], 1, now).unwrap();
    keys.add(&[Name::COORDINATOR], &[], 1, now).unwrap();
    keys
}

#[test]
fn the_mission_is_sent_over_mutual_tls_of_both_versions() {
    let site = Site::new();
    let keys = certificates(&site);
    let server = ["sim.pem", "sim.key", "authority.pem"].map(|name| keys.home(Name::Simulator).join(name));
    let [certificate, key, ca] = server.each_ref().map(|path| path.to_str().unwrap());
    for version in [&["1.2"][..], &[]] {
        let tak = Tak::start(&[&["tls", certificate, key, ca], version].concat());
        let url = format!("url = \"tls://127.0.0.1:{}\"\nperiod_seconds = 0.1\n", tak.port);
        let own = "ca = \"keys/coordinator/authority.pem\"\ncertificate = \"keys/coordinator/coordinator.pem\"\n\
                   key = \"keys/coordinator/coordinator.key\"\n";
        let coordinator = Process::start(&mut site.coordinator(&(url.clone() + own)));
        check_areas(&tak, 1);
        drop(coordinator);
        // Without a certificate of its own, and with one of a stranger as the authority.
        let check = |settings: &str, reason: &str| {
            let coordinator = Process::start(&mut site.coordinator(&(url.clone() + settings)));
            coordinator.logs(&["WARN", "TAK at tls://", reason]);
        };
        check("ca = \"keys/authority.pem\"\n", "give tak.certificate and tak.key");
        check("ca = \"keys/coordinator/coordinator.pem\"\n", "not signed by tak.ca");
        check(
            "ca = \"keys/authority.pem\"\nserver_name = \"tak.example.com\"\n",
            "for another host; give the name in it as tak.server_name",
        );
    }
}

#[test]
fn settings_of_tak_that_cannot_work_are_reported_with_their_key() {
    let site = Site::new();
    certificates(&site);
    let check = |tak: &str, reason: &str| {
        let output = site.coordinator(tak).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && said.contains("coordinator.toml") && said.contains(reason),
            "{said}"
        );
    };
    check("url = 'http://127.0.0.1:1'", "allowed are udp://HOST:PORT, tcp://HOST:PORT and tls://HOST:PORT");
    check("url = 'udp://127.0.0.1'", "tak.url is \"udp://127.0.0.1\"; allowed are");
    check(
        "url = 'udp://127.0.0.1:6969'\nperiod_seconds = 0.0",
        "tak.period_seconds is 0.0; allowed is from 0.1",
    );
    check("url = 'udp://127.0.0.1:6969'\nca = 'a.pem'", "tak.ca is for tls://HOST:PORT");
    check("url = 'tcp://127.0.0.1:6969'\nlocal_address = '::1'", "tak.local_address is for udp://HOST:PORT");
    check("url = 'tls://127.0.0.1:6969'", "tls needs tak.ca");
    let tls = "url = 'tls://127.0.0.1:6969'\nca = 'keys/authority.pem'\n";
    check(&format!("{tls}key = 'keys/sim/sim.key'"), "allowed are both or none");
    check(
        &format!("{tls}certificate = 'keys/sim/sim.key'\nkey = 'keys/sim/sim.key'"),
        "holds no certificate in PEM",
    );
    check(&format!("{tls}certificate = 'keys/sim/sim.pem'\nkey = 'keys/sim/sim.pem'"), "holds no key in PEM");
    check(
        &format!("{tls}certificate = 'keys/sim/sim.pem'\nkey = 'keys/coordinator/coordinator.key'"),
        "do not fit",
    );
    let hall = "name = 'field'\nmap = { shape = 'all_traversable', rows = 9, columns = 9 }\nobjects.count = 1\n\
                robots.count = 1\nmission.budget_seconds = 60.0\n";
    fs::write(site.path("field.toml"), hall).unwrap();
    check("url = 'udp://127.0.0.1:6969'", "needed is map.origin");
    let run = Command::new(DRAGNET)
        .args(["run", "field.toml", "--live", "--tak", "udp://127.0.0.1:6969"])
        .current_dir(site.folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(!run.status.success() && said.contains("needed is map.origin"), "{said}");
}
