//! The `.plan` files, against the developer guide of `QGroundControl`.

use dragnet_export::{Account, plan};
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use serde_json::{Value, json};

use crate::mission::{SECOND_NS, at, playback};

#[test]
fn a_plan_has_a_waypoint_wherever_the_path_turns() {
    let account = Account::new(&playback(), None, None).unwrap();
    let texts = plan::texts(&account).unwrap();
    let [(robot, text)] = &texts[..] else { panic!("robot 2 has no plan") };
    assert_eq!(*robot, RobotId::FIRST);
    let file: Value = serde_json::from_str(text).unwrap();
    let mission = &file["mission"];
    let fixed = json!([file["fileType"], file["version"], mission["version"], mission["vehicleType"]]);
    assert_eq!(fixed, json!(["Plan", 1, 2, 10]));
    let speeds = json!([mission["cruiseSpeed"], mission["hoverSpeed"], mission["globalPlanAltitudeMode"]]);
    assert_eq!(speeds, json!([1.5, 1.5, 1]));
    let home = account.point(at(2, 17));
    assert_eq!(mission["plannedHomePosition"], json!([home.latitude_degrees, home.longitude_degrees, 0]));
    let items = mission["items"].as_array().unwrap();
    assert_eq!(items.len(), 3);
    for ((number, item), cell) in (1..).zip(items).zip([at(2, 19), at(5, 19), at(5, 18)]) {
        let point = account.point(cell);
        let params = json!([0, 0, 0, null, point.latitude_degrees, point.longitude_degrees, 0]);
        assert_eq!(item["params"], params);
        let fixed =
            json!([item["type"], item["command"], item["frame"], item["doJumpId"], item["autoContinue"]]);
        assert_eq!(fixed, json!(["SimpleItem", 16, 3, number, true]));
    }
}

#[test]
fn closed_cells_are_a_fence_drawn_clockwise() {
    let account = Account::new(&playback(), None, None).unwrap();
    let file: Value = serde_json::from_str(&plan::texts(&account).unwrap()[0].1).unwrap();
    let fence = &file["geoFence"];
    assert_eq!(json!([fence["version"], fence["circles"]]), json!([2, []]));
    let [pond] = &fence["polygons"].as_array().unwrap()[..] else { panic!("{fence}") };
    assert_eq!(json!([pond["inclusion"], pond["version"]]), json!([false, 1]));
    let corners: Vec<(f64, f64)> = serde_json::from_value(pond["polygon"].clone()).unwrap();
    assert_eq!(corners.len(), 4, "not closed");
    let next = corners.iter().cycle().skip(1);
    let doubled: f64 = corners.iter().zip(next).map(|(a, b)| a.1 * b.0 - b.1 * a.0).sum();
    assert!(doubled < 0.0, "east and north, clockwise: {doubled}");
}

#[test]
fn without_a_plan_there_is_no_file() {
    let early = Account::new(&playback(), None, Some(MissionTime(90 * SECOND_NS))).unwrap();
    let error = plan::texts(&early).unwrap_err().to_string();
    assert!(
        error.contains("no robot has a plan 90.0 s after the start; allowed is an earlier time"),
        "{error}"
    );
}
