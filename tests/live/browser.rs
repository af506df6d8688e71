//! The page in headless Chromium, driven by `live/page/test/browser.mjs`.

use std::path::PathBuf;
use std::process::Command;

use dragnet_proto::convert::Codec;
use dragnet_runtime::link::Link;
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;
use tempfile::TempDir;

use super::interpreter::interpreter;
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
    let screenshots = root().join("live/screenshots");
    std::fs::create_dir_all(&screenshots).unwrap();
    let script = root().join("live/page/test/browser.mjs");
    let output =
        Command::new("node").arg(script).args([case, &served.address]).arg(screenshots).output().unwrap();
    let reported = [output.stdout, output.stderr].concat();
    let reported = String::from_utf8_lossy(&reported);
    assert!(output.status.success(), "{case}: {reported}\n{}", served.complaints());
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
    in_browser(|| play("crowd", Served::start(&["run", "crowd.toml", "--live", "--record", "crowd.mcap"])));
}

#[test]
fn two_robots_of_one_number_are_marked_and_described() {
    in_browser(|| {
        let (folder, endpoint) = (folder(), free_endpoints(1).unwrap().remove(0));
        let settings = format!(
            "[live]\n[common]\nmission = \"hall\"\nscenario = \"hall.toml\"\nzenoh.listen = [{endpoint:?}]\n"
        );
        std::fs::write(folder.path().join("coordinator.toml"), settings).unwrap();
        let scenario = Scenario::load(&folder.path().join("hall.toml")).unwrap();
        let served = Served::start_in(folder, &["coordinator", "--config", "coordinator.toml"]);
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
