//! The plan of one robot for `QGroundControl`: a `.plan` file, version 1, as defined in its developer guide.
//!
//! It has a waypoint at each turn of the path, and at its end. No-go areas are exclusion fences. Altitudes are 0 above
//! home.

use dragnet_scenario::map_file::{GeoPoint, Purpose};
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use geo::orient::{Direction, Orient};
use serde_json::{Value, json};

use crate::account::{Account, Plan};
use crate::error::ExportError;

/// `MAV_AUTOPILOT_ARDUPILOTMEGA`.
const ARDUPILOT: u32 = 3;
/// `MAV_TYPE_GROUND_ROVER`.
const GROUND_ROVER: u32 = 10;
/// `MAV_CMD_NAV_WAYPOINT`.
const WAYPOINT: u32 = 16;
/// `MAV_FRAME_GLOBAL_RELATIVE_ALT`.
const RELATIVE_HEIGHT: u32 = 3;

/// The number of each robot with a plan, and the text of its file.
///
/// # Errors
/// If no robot has a plan.
pub fn texts(account: &Account) -> Result<Vec<(RobotId, String)>, ExportError> {
    if account.plans.is_empty() {
        return Err(ExportError::NoPlan { seconds: account.until.as_seconds() });
    }
    let text = |(robot, plan): (&RobotId, &Plan)| (*robot, format!("{:#}\n", file(account, *robot, plan)));
    Ok(account.plans.iter().map(text).collect())
}

fn file(account: &Account, robot: RobotId, plan: &Plan) -> Value {
    let home = account.point(plan.from);
    let speed = account.speed_meters_per_second(robot);
    let items: Vec<Value> =
        (1..).zip(turns(account, plan)).map(|(number, cell)| item(number, account.point(cell))).collect();
    json!({
        "fileType": "Plan",
        "geoFence": { "circles": [], "polygons": fences(account), "version": 2 },
        "groundStation": "QGroundControl",
        "mission": {
            "cruiseSpeed": speed,
            "firmwareType": ARDUPILOT,
            "globalPlanAltitudeMode": 1,
            "hoverSpeed": speed,
            "items": items,
            "plannedHomePosition": [home.latitude_degrees, home.longitude_degrees, 0],
            "vehicleType": GROUND_ROVER,
            "version": 2,
        },
        "rallyPoints": { "points": [], "version": 2 },
        "version": 1,
    })
}

/// Cells at which the path turns, and the last one.
fn turns(account: &Account, plan: &Plan) -> Vec<Cell> {
    let grid = account.terrain.grid();
    let way: Vec<Cell> = std::iter::once(plan.from).chain(plan.path.iter().copied()).collect();
    let is_turn = |cells: &&[Cell]| grid.offset(cells[0], cells[1]) != grid.offset(cells[1], cells[2]);
    way.windows(3).filter(is_turn).map(|cells| cells[1]).chain(way.last().copied()).collect()
}

fn item(number: usize, point: GeoPoint) -> Value {
    json!({
        "AMSLAltAboveTerrain": null,
        "Altitude": 0,
        "AltitudeMode": 1,
        "autoContinue": true,
        "command": WAYPOINT,
        "doJumpId": number,
        "frame": RELATIVE_HEIGHT,
        "params": [0, 0, 0, null, point.latitude_degrees, point.longitude_degrees, 0],
        "type": "SimpleItem",
    })
}

/// Outlines of closed cells, clockwise and not closed.
fn fences(account: &Account) -> Vec<Value> {
    let no_go = account.areas.iter().filter(|(area, _)| matches!(area.purpose, Purpose::NoGo(..)));
    let polygons = no_go.flat_map(|(area, _)| area.purpose.polygons());
    let fence = |polygon: &geo::Polygon<f64>| {
        let ring = polygon.orient(Direction::Reversed);
        let corners = &ring.exterior().0;
        let points: Vec<Value> =
            corners[..corners.len().saturating_sub(1)].iter().map(|it| json!([it.y, it.x])).collect();
        json!({ "inclusion": false, "polygon": points, "version": 1 })
    };
    polygons.map(fence).collect()
}
