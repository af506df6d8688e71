//! Requests to the planning page, tested with plain sockets.

use std::fs;
use std::process::Command;

use serde_json::{Value, json};

use super::http::ask;
use super::{Served, root};

/// An answer: its status, and its body.
type Answer = (u16, Value);

fn post(served: &Served, what: &str, body: &Value) -> Answer {
    let bearer = format!("Authorization: Bearer {}", served.token());
    let (status, _, body) = ask(served, &format!("POST /plan/{what}"), &[&bearer], &body.to_string());
    (status, serde_json::from_str(&body).unwrap_or_default())
}

fn state(served: &Served) -> Value {
    let (status, _, body) = ask(served, "GET /plan/state", &[], "");
    assert_eq!(status, 200);
    serde_json::from_str(&body).unwrap()
}

fn refused((status, body): Answer, expected: u16, words: &str) {
    let error = body["error"].as_str().unwrap_or_default();
    assert!(status == expected && error.contains(words), "{status}: {body}");
}

fn import(served: &Served, revision: &Value, name: &str, bytes: &[u8]) -> Answer {
    let content = base64(bytes);
    post(
        served,
        "import",
        &json!({ "revision": revision, "name": name, "content": content, "replaces": true }),
    )
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let of_three = |three: &[u8]| {
        let bits =
            three.iter().fold(0_u32, |bits, &byte| bits << 8 | u32::from(byte)) << (8 * (3 - three.len()));
        let letter = |place: usize| {
            let index = bits >> (18 - 6 * place) & 63;
            if place <= three.len() { char::from(LETTERS[index as usize]) } else { '=' }
        };
        (0..4).map(letter).collect::<String>()
    };
    bytes.chunks(3).map(of_three).collect()
}

#[test]
fn changing_the_plan_requires_the_token_and_an_own_page() {
    let served = Served::start(&["plan"]);
    for what in ["change", "import", "forecast", "cancel", "save", "simulate"] {
        let line = format!("POST /plan/{what}");
        assert_eq!(ask(&served, &line, &[], "{}").0, 401, "{what}");
        let wrong = "Authorization: Bearer 0123456789abcdef0123456789abcdef";
        assert_eq!(ask(&served, &line, &[wrong], "{}").0, 401, "{what}");
        assert_eq!(ask(&served, &line, &["Host: evil.example"], "{}").0, 403, "{what}");
    }
    assert_eq!(ask(&served, "GET /plan/state", &["Origin: http://evil.example"], "").0, 403);
    // The pages of missions are not here.
    assert_eq!(ask(&served, "POST /command", &[], "{}").0, 404);
    assert_eq!(state(&served)["revision"], 1);
}

/// A person sees what is missing, and draws it anew.
#[test]
fn a_file_with_an_invalid_area_is_read_without_it() {
    let served = Served::start(&["plan"]);
    let area = |name: &str, ring: &str| {
        format!(
            "{{\"type\":\"Feature\",\"properties\":{{\"kind\":\"search\",\"name\":\"{name}\"}},\
             \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[{ring}]]}}}}"
        )
    };
    let square = area("moor", "[9.5,47.5],[9.51,47.5],[9.51,47.51],[9.5,47.51],[9.5,47.5]");
    let crossing = area("bow", "[9.6,47.5],[9.61,47.51],[9.61,47.5],[9.6,47.51],[9.6,47.5]");
    let file = format!("{{\"type\":\"FeatureCollection\",\"features\":[{square},{crossing}]}}");
    let before = state(&served);
    let (status, body) = import(&served, &before["revision"], "a.geojson", file.as_bytes());
    let message = body["message"].as_str().unwrap_or_default();
    assert!(
        status == 200 && message.contains("1 area read. Not read: ") && message.contains("bow"),
        "{body}"
    );
    let alone = format!("{{\"type\":\"FeatureCollection\",\"features\":[{crossing}]}}");
    refused(import(&served, &body["revision"], "b.geojson", alone.as_bytes()), 422, "bow");
}

#[test]
fn invalid_requests_and_files_are_refused_and_change_nothing() {
    let served = Served::start(&["plan", "missing_person"]);
    let before = state(&served);
    let (revision, plan) = (&before["revision"], &before["plan"]);
    refused(post(&served, "change", &json!("no plan")), 400, "invalid type");
    refused(post(&served, "change", &json!({ "revision": revision, "plan": {} })), 422, "scenario");
    let mut wrong = plan.clone();
    wrong["scenario"]["robots"]["count"] = json!("two");
    refused(
        post(&served, "change", &json!({ "revision": revision, "plan": wrong })),
        422,
        "scenario.robots.count: invalid type: string \"two\", expected a whole number",
    );
    refused(import(&served, revision, "a.png", b"no"), 422, "a.png: unknown extension");
    refused(import(&served, revision, "../../etc/a.kml", b"<kml"), 422, "a.kml: ");
    refused(import(&served, revision, "a.toml", b"name = 'a'"), 422, "dragnet plan a.toml");
    refused(import(&served, revision, "a.geojson", &[0xff, 0xfe]), 422, "a.geojson: ");
    let far = br#"{"type":"Point","coordinates":[500,95]}"#;
    let far = format!(
        r#"{{"type":"Feature","properties":{{"kind":"start"}},"geometry":{}}}"#,
        String::from_utf8_lossy(far)
    );
    refused(import(&served, revision, "far.geojson", far.as_bytes()), 422, "longitude");
    let empty = br#"{"type":"FeatureCollection","features":[]}"#;
    refused(import(&served, revision, "empty.geojson", empty), 422, "empty.geojson: holds no area");
    let bomb = format!("<!DOCTYPE kml [<!ENTITY a \"{}\">]><kml>&a;</kml>", "b".repeat(1000));
    refused(import(&served, revision, "bomb.kml", bomb.as_bytes()), 422, "bomb.kml");
    refused(import(&served, revision, "a.kmz", b"PK no archive"), 422, "a.kmz: not a KMZ archive");
    let not_base64 = json!({ "revision": revision, "name": "a.kml", "content": "%", "replaces": false });
    refused(post(&served, "import", &not_base64), 422, "base64");
    let long = vec![b' '; (16 << 20) + 1];
    refused(import(&served, revision, "long.kml", &long), 422, "at most 16777216");
    assert_eq!(post(&served, "change", &json!("x".repeat(5 << 20))).0, 413);
    assert_eq!(post(&served, "import", &json!("x".repeat(24 << 20))).0, 413);
    refused(post(&served, "forecast", &json!({ "robots": 0, "missions": 10 })), 422, "1 to 1000");
    refused(post(&served, "simulate", &json!({})), 409, "save the plan first");
    assert_eq!(state(&served), before);
}

#[test]
fn of_two_windows_none_overwrites_what_the_other_has_changed() {
    let served = Served::start(&["plan", "missing_person"]);
    let before = state(&served);
    let with_speed = |speed: f64| {
        let mut plan = before["plan"].clone();
        plan["scenario"]["mission"]["speed_meters_per_second"] = json!(speed);
        json!({ "revision": before["revision"], "plan": plan })
    };
    let (status, after) = post(&served, "change", &with_speed(3.0));
    assert_eq!(
        (status, &after["plan"]["scenario"]["mission"]["speed_meters_per_second"]),
        (200, &json!(3.0))
    );
    refused(post(&served, "change", &with_speed(5.0)), 409, "changed in another window");
    refused(
        import(
            &served,
            &before["revision"],
            "a.geojson",
            b"{\"type\":\"FeatureCollection\",\"features\":[]}",
        ),
        409,
        "another window",
    );
    refused(
        post(&served, "save", &json!({ "revision": before["revision"], "overwrite": false })),
        409,
        "another window",
    );
    assert_eq!(state(&served)["plan"], after["plan"]);
}

#[test]
fn a_page_makes_the_program_read_and_write_no_other_files() {
    let served = Served::start(&["plan", "missing_person"]);
    let before = state(&served);
    let mut plan = before["plan"].clone();
    plan["scenario"]["recording"]["file"] = json!("/etc/passwd");
    plan["scenario"]["prior"]["file"] = json!("/etc/passwd");
    plan["scenario"]["map"]["file"] = json!("/etc/passwd");
    plan["scenario"]["name"] = json!("../outside");
    let (status, after) = post(&served, "change", &json!({ "revision": before["revision"], "plan": plan }));
    assert_eq!(status, 200);
    assert!(!after["plan"].to_string().contains("passwd"));
    assert_eq!(after["review"]["problems"][0]["at"]["key"], "name");
    refused(
        post(&served, "save", &json!({ "revision": after["revision"], "overwrite": true })),
        422,
        "letters, digits",
    );
}

#[test]
fn a_saved_plan_is_a_scenario_that_can_be_checked_and_run() {
    let map = root().join("scenarios/maps/missing_person.kml");
    let served = Served::start(&["plan", map.to_str().unwrap()]);
    let state = state(&served);
    let (status, saved) =
        post(&served, "save", &json!({ "revision": state["revision"], "overwrite": false }));
    assert_eq!((status, &saved["saved"]["is_current"]), (200, &json!(true)), "{saved}");
    // Changed by hand, it is not overwritten without a question, which says so.
    let path = served.folder().join("missing_person.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{text}# by hand\n")).unwrap();
    let again = post(&served, "save", &json!({ "revision": state["revision"], "overwrite": false }));
    refused(again, 409, "missing_person.toml in ");
    let again = post(&served, "save", &json!({ "revision": state["revision"], "overwrite": false }));
    refused(again, 409, "has changed since it was saved here");
    fs::write(&path, text).unwrap();
    let dragnet = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_dragnet"))
            .args(arguments)
            .current_dir(served.folder())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let checked = dragnet(&["check", "missing_person.toml"]);
    assert!(checked.contains("missing_person.toml: ok: 53 x 62 cells of 20 m"), "{checked}");
    assert!(checked.contains("sight 100 m"), "{checked}");
    assert!(checked.contains("prior \"Car park\": POA 40.0 %"), "{checked}");
    // The same search as that of the areas alone.
    let run = |what: &str| {
        let record = format!("{}.mcap", what.len());
        let json = dragnet(&["run", what, "--json", "--over", "memory", "--record", &record]);
        let result: Value = serde_json::from_str(&json).unwrap();
        assert!(result["last_find_s"].is_number(), "{result}");
        ["last_find_s", "tail_s", "expected_remaining"].map(|key| result[key].clone())
    };
    let scenario = fs::read_to_string(served.folder().join("missing_person.toml")).unwrap();
    assert!(scenario.contains("file = \"missing_person.geojson\""), "{scenario}");
    assert_eq!(run("missing_person.toml"), run(map.to_str().unwrap()));
}

#[test]
fn a_forecast_is_that_of_the_command_and_becomes_out_of_date() {
    let served = Served::start(&["plan", "missing_person"]);
    let begun = post(&served, "forecast", &json!({ "robots": 2, "missions": 3 }));
    assert_eq!((begun.0, &begun.1["forecast"]["revision"]), (200, &json!(1)));
    let mut forecast = Value::Null;
    while forecast["state"] != "done" {
        assert_ne!(forecast["state"], "failed", "{forecast}");
        forecast = state(&served)["forecast"].clone();
    }
    let command = Command::new(env!("CARGO_BIN_EXE_dragnet"))
        .args(["forecast", "missing_person", "--robots", "1,2", "--seeds", "3", "--json"])
        .output()
        .unwrap();
    let by_command: Value = serde_json::from_slice(&command.stdout).unwrap();
    assert_eq!(forecast["teams"], by_command["teams"]);
    let now = state(&served);
    let mut plan = now["plan"].clone();
    plan["scenario"]["mission"]["speed_meters_per_second"] = json!(1.0);
    let (_, changed) = post(&served, "change", &json!({ "revision": now["revision"], "plan": plan }));
    assert_ne!(changed["revision"], changed["forecast"]["revision"]);
    // A forecast of a thousand missions ends at once.
    post(&served, "forecast", &json!({ "robots": 2, "missions": 1000 }));
    let (status, cancelled) = post(&served, "cancel", &json!({}));
    assert_eq!((status, &cancelled["forecast"]), (200, &Value::Null));
}

#[test]
fn simulations_that_end_with_the_page_have_finished_their_recordings() {
    let mut served = Served::start(&["plan", "missing_person"]);
    let revision = state(&served)["revision"].clone();
    assert_eq!(post(&served, "save", &json!({ "revision": revision, "overwrite": false })).0, 200);
    assert_eq!(post(&served, "simulate", &json!({})).0, 200);
    let recording = served.folder().join("missing_person-0.mcap");
    while !fs::metadata(&recording).is_ok_and(|file| file.len() > 5_000) {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let sent = Command::new("kill").args(["-s", "TERM", &served.program.id().to_string()]).status().unwrap();
    assert!(sent.success() && served.program.wait().unwrap().success());
    let inspected =
        Command::new(env!("CARGO_BIN_EXE_dragnet")).arg("inspect").arg(recording).output().unwrap();
    let told = String::from_utf8_lossy(&inspected.stdout);
    assert!(told.contains("complete"), "{told}");
}

#[test]
fn what_cannot_be_planned_is_refused_before_a_page_is_served() {
    for (arguments, words) in [
        (&["plan", "warehouse"][..], "not drawn on the earth"),
        (&["plan", "nothing.kml"], "nothing.kml: "),
        (&["plan", "--into", "nowhere"], "--into nowhere: no such folder"),
        (&["plan", "--listen", "here"], "is no address"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_dragnet")).args(arguments).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && told.contains(words), "{arguments:?}: {told}");
    }
}
