//! The page in headless Chromium, driven by `live/page/test/browser.mjs`.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use dragnet_proto::convert::Codec;
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Activity, Audience, Heartbeat, Intent, Message};
use dragnet_runtime::link::{Incoming, Link};
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{RobotId, Versions};
use serde_json::Value;
use tempfile::TempDir;

use super::interpreter::interpreter;
use super::pictured::find;
use super::{Served, folder, root};

/// A requirement of a browser test that this computer lacks; `test.sh` installs it.
fn missing() -> Option<String> {
    let chromium = std::env::var("CHROMIUM").unwrap_or_else(|_| "/usr/bin/chromium".to_owned());
    let modules = root().join("live/page/node_modules/playwright-core");
    let node = Command::new("node").arg("--version").output();
    if node.is_err() {
        Some("node is missing (on Debian: apt-get install nodejs npm)".to_owned())
    } else if !PathBuf::from(&chromium).exists() {
        Some(format!("{chromium} is missing (on Debian: apt-get install chromium)"))
    } else if !modules.exists() {
        Some("live/page/node_modules is missing: npm ci --prefix live/page".to_owned())
    } else {
        None
    }
}

/// Plays one case of the script; screenshots go to `live/screenshots`.
fn play(case: &str, served: Served) {
    drop(played(case, served));
}

/// The same; the program still runs.
fn played(case: &str, served: Served) -> Served {
    let screenshots = root().join("live/screenshots");
    std::fs::create_dir_all(&screenshots).unwrap();
    let script = root().join("live/page/test/browser.mjs");
    let output =
        Command::new("node").arg(script).args([case, &served.address]).arg(screenshots).output().unwrap();
    let reported = [output.stdout, output.stderr].concat();
    let reported = String::from_utf8_lossy(&reported);
    assert!(output.status.success(), "{case}: {reported}\n{}", served.complaints());
    served
}

/// Prints why nothing was tested, if so; a failure where all requirements must be there.
fn in_browser(test: impl FnOnce()) {
    match missing() {
        None => test(),
        Some(what) => {
            assert!(std::env::var_os("CI").is_none(), "{what}");
            eprintln!("not tested in a browser: {what}");
        }
    }
}

#[test]
fn an_operator_watches_pauses_marks_and_adds_an_area() {
    in_browser(|| play("live", Served::run()));
}

#[test]
fn finds_are_confirmed_and_dismissed_in_the_page_the_recording_and_the_export() {
    in_browser(|| {
        let served = Served::start(&["run", "full.toml", "--live", "--record", "hall.mcap"]);
        let served = played("finds", served);
        let dragnet = |arguments: &[&str]| {
            let mut dragnet = Command::new(env!("CARGO_BIN_EXE_dragnet"));
            let output = dragnet.args(arguments).current_dir(served.folder()).output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8(output.stdout).unwrap()
        };
        let inspected = dragnet(&["inspect", "hall.mcap"]);
        let lines = || inspected.lines().map(str::trim_start);
        let confirmed = lines().find(|line| line.ends_with(", confirmed by hand")).unwrap();
        assert!(confirmed.contains(", probability 1.0000"), "{confirmed}");
        let dismissed = lines().skip_while(|line| !line.starts_with("dismissed ")).nth(1).unwrap();
        let [stays, goes] = [confirmed, dismissed].map(|line| {
            let cell = line.strip_prefix("cell ").and_then(|line| line.split_once(']')).unwrap().0;
            format!("{cell}]")
        });
        assert!(inspected.contains("/robots/0/verdicts") && inspected.contains("/robots/3/verdicts"));
        let told = dragnet(&["replay", "hall.mcap"]);
        for line in [
            format!("has confirmed the find at {stays}"),
            format!("has dismissed the find at {goes}"),
            format!("the find at {goes} is undone"),
            "the operator marks a search of cell".to_owned(),
        ] {
            assert!(told.contains(&line), "{line}: {told}");
        }
        dragnet(&["export", "hall.mcap", "--to", "hall.geojson", "--origin", "49.2,-2.2"]);
        let exported = std::fs::read_to_string(served.folder().join("hall.geojson")).unwrap();
        let exported: Value = serde_json::from_str(&exported).unwrap();
        let of = |cell: &str| {
            let [row, column]: [u32; 2] = serde_json::from_str(cell).unwrap();
            let features = exported["features"].as_array().unwrap().iter().map(|it| &it["properties"]);
            let mut at = features.filter(|it| it["row"] == row && it["column"] == column);
            at.next().map(|it| (it["kind"].clone(), it["operator"].clone())).unwrap()
        };
        assert_eq!(of(&stays), ("found".into(), "confirmed".into()));
        assert_eq!(of(&goes), ("dismissed".into(), "dismissed".into()));
    });
}

/// The coordinator of a mission in the hall, with its scenario and the endpoint on which robots reach it.
fn coordinator_of_hall() -> (Served, Scenario, String) {
    let (folder, endpoint) = (folder(), free_endpoints(1).unwrap().remove(0));
    let settings = format!(
        "[live]\n[common]\nmission = \"hall\"\nscenario = \"hall.toml\"\nzenoh.listen = [{endpoint:?}]\n"
    );
    std::fs::write(folder.path().join("coordinator.toml"), settings).unwrap();
    let scenario = Scenario::load(&folder.path().join("hall.toml")).unwrap();
    (Served::start_in(folder, &["coordinator", "--config", "coordinator.toml"]), scenario, endpoint)
}

/// Plays one case on the page of that coordinator, with a robot beside it.
fn play_with<Robot: Future<Output = ()> + Send + 'static>(case: &str, robot: fn(Scenario, String) -> Robot) {
    let (served, scenario, endpoint) = coordinator_of_hall();
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let robot = runtime.spawn(robot(scenario, endpoint));
    play(case, served);
    robot.abort();
}

#[test]
fn a_robot_that_is_cut_off_is_waited_for() {
    in_browser(|| play_with("cutOff", repeat_orders));
}

#[test]
fn a_find_is_shown_with_its_picture() {
    in_browser(|| play_with("pictured", find));
}

/// Robot 1, which stands in the south-western corner and says each second which orders it has.
async fn repeat_orders(scenario: Scenario, coordinator: String) {
    let endpoints = Endpoints { connect: vec![coordinator], ..Endpoints::default() };
    let session = open(&endpoints).await.unwrap();
    let (codec, participant) = (Codec::of(&scenario), Participant::Robot(RobotId::FIRST));
    let mut link = Link::join(session, "hall".parse().unwrap(), participant, codec).await.unwrap();
    link.announce().await.unwrap();
    let cell = scenario.terrain().grid().cell_numbered(0).unwrap();
    let (robot, mut directive) = (RobotId::FIRST, Directive::default());
    let mut seconds = tokio::time::interval(Duration::from_secs(1));
    for number in 1.. {
        loop {
            tokio::select! {
                _ = seconds.tick() => break,
                received = link.receive() => {
                    if let Some(Incoming::Message { message: Message::MissionStatus(status), .. }) = received {
                        directive = status.directive;
                    }
                }
            }
        }
        let time_ns = number * 1_000_000_000;
        let heartbeat = Heartbeat {
            robot,
            time_ns,
            activity: Activity::Searching,
            cell,
            path_meters: 0.0,
            intent: Intent { robot, incarnation: 0, decision: 1, time_ns, path: Vec::new().into() },
            versions: Versions::default(),
            digest: Digest(0),
            directive: directive.clone(),
        };
        link.publish(number, Audience::All, &Message::Heartbeat(heartbeat)).await.unwrap();
    }
}

#[test]
fn without_the_token_the_page_is_read_only() {
    in_browser(|| play("readOnly", Served::run()));
}

#[test]
fn the_page_fits_a_phone() {
    in_browser(|| play("phone", Served::run()));
}

#[test]
fn a_map_of_the_earth_is_read_and_measured() {
    in_browser(|| play("earth", Served::start(&["run", "earth.toml", "--live", "--record", "earth.mcap"])));
}

#[test]
fn a_leader_plans_a_mission_forecasts_saves_and_simulates_it() {
    in_browser(|| play("plan", Served::start(&["plan"])));
}

/// A folder with a base map, which the package `pmtiles` has written.
fn with_basemap() -> TempDir {
    let folder = folder();
    let mut write = Command::new(interpreter(root()));
    write
        .arg(root().join("tests/python/basemap.py"))
        .arg(folder.path().join("ground.pmtiles"))
        .args(["49.2386", "-2.2352"]);
    let written = write.output().unwrap();
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    folder
}

#[test]
fn a_base_map_lies_under_a_mission_where_it_belongs() {
    in_browser(|| {
        let search = ["run", "earth.toml", "--live", "--basemap", "ground.pmtiles", "--record", "earth.mcap"];
        play("basemap", Served::start_in(with_basemap(), &search));
    });
}

#[test]
fn an_empty_plan_begins_on_the_base_map() {
    in_browser(|| {
        play("planOnBasemap", Served::start_in(with_basemap(), &["plan", "--basemap", "ground.pmtiles"]));
    });
}

#[test]
fn the_planning_page_fits_a_phone() {
    in_browser(|| play("planPhone", Served::start(&["plan", "missing_person"])));
}

#[test]
fn a_frozen_link_is_shown() {
    in_browser(|| play("stale", Served::run()));
}

#[test]
fn fifty_robots_on_a_large_map_are_told_apart() {
    in_browser(|| {
        let command = "run crowd.toml --live --real-time-factor 1 --record crowd.mcap";
        play("crowd", Served::start(&command.split(' ').collect::<Vec<_>>()));
    });
}

#[test]
fn two_robots_of_one_number_are_marked_and_described() {
    in_browser(|| {
        let (served, scenario, endpoint) = coordinator_of_hall();
        let runtime = tokio::runtime::Runtime::new().unwrap();
        let both = runtime.block_on(async {
            let endpoints = Endpoints { connect: vec![endpoint], ..Endpoints::default() };
            let session = open(&endpoints).await.unwrap();
            let mut both = Vec::new();
            for _ in 0..2 {
                let (codec, participant) =
                    (Codec::new(scenario.terrain().grid()), Participant::Robot(RobotId::FIRST));
                let mut link =
                    Link::join(session.clone(), "hall".parse().unwrap(), participant, codec).await.unwrap();
                link.announce().await.unwrap();
                both.push(link);
            }
            both
        });
        play("doubled", served);
        drop(both);
    });
}

/// A page of a search that was recorded before.
fn recorded() -> Served {
    let folder = folder();
    let run = Command::new(env!("CARGO_BIN_EXE_dragnet"))
        .args(["run", "short.toml", "--seed", "3", "--record", "hall.mcap"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    Served::start_in(folder, &["replay", "hall.mcap", "--live"])
}

#[test]
fn seeking_forward_and_back_shows_the_same() {
    in_browser(|| play("replay", recorded()));
}

#[test]
fn a_find_raises_a_banner_and_a_sound() {
    in_browser(|| play("sound", recorded()));
}
