//! An account as GPX 1.1: found objects, without dismissed ones, and clues as waypoints, tracks of the robots with times. GPX has no areas, so cleared
//! cells are left out.

use std::io;

use dragnet_proto::message::Detection;
use dragnet_scenario::accuracy;
use dragnet_scenario::map_file::GeoPoint;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;

use crate::account::{Account, Visit};
use crate::time::wall_time;
use crate::xml::{self, Document};

/// The text of a GPX file.
#[must_use]
pub fn text(account: &Account) -> String {
    xml::document(|writer| {
        let root = writer.create_element("gpx").with_attributes([
            ("version", "1.1"),
            ("creator", "dragnet"),
            ("xmlns", "http://www.topografix.com/GPX/1/1"),
        ]);
        root.write_inner_content(|writer| {
            writer.create_element("metadata").write_inner_content(|writer| {
                xml::element(writer, "name", &account.name)?;
                xml::element(writer, "time", &wall_time(account.start_unix_ns, account.until))
            })?;
            for (number, object) in (1..).zip(&account.found) {
                found(writer, account, number, object)?;
            }
            for (number, time, clue, note) in account.clues() {
                let texts = [format!("Clue {number}"), note];
                waypoint(writer, account, (account.point(clue.cell), time), [&texts[0], &texts[1]], None)?;
            }
            account.tracks.iter().try_for_each(|(robot, visits)| track(writer, account, *robot, visits))
        })?;
        Ok(())
    })
}

fn found(writer: &mut Document, account: &Account, number: usize, object: &Detection) -> io::Result<()> {
    let operator = account.operator(object.cell).map_or_else(String::new, |word| format!(", {word} by hand"));
    let known = account.positions.get(&object.cell).map(|it| accuracy(it.accuracy_meters()));
    let known = known.map_or_else(String::new, |known| format!(", {known}"));
    let description = format!("probability {:.4}{operator}{known}", object.probability);
    let at = (account.place(object.cell), MissionTime(object.time_ns));
    let picture = account.picture_file(object.cell);
    waypoint(writer, account, at, [&format!("Object {number}"), &description], picture.as_deref())
}

fn waypoint(
    writer: &mut Document,
    account: &Account,
    (point, time): (GeoPoint, MissionTime),
    [name, description]: [&str; 2],
    picture: Option<&str>,
) -> io::Result<()> {
    let (latitude, longitude) = degrees(point);
    let point = writer
        .create_element("wpt")
        .with_attributes([("lat", latitude.as_str()), ("lon", longitude.as_str())]);
    point.write_inner_content(|writer| {
        xml::element(writer, "time", &wall_time(account.start_unix_ns, time))?;
        xml::element(writer, "name", name)?;
        xml::element(writer, "desc", description)?;
        if let Some(file) = picture {
            writer.create_element("link").with_attribute(("href", file)).write_empty()?;
        }
        Ok(())
    })?;
    Ok(())
}

fn track(writer: &mut Document, account: &Account, robot: RobotId, visits: &[Visit]) -> io::Result<()> {
    writer.create_element("trk").write_inner_content(|writer| {
        xml::element(writer, "name", &format!("Robot {robot}"))?;
        writer.create_element("trkseg").write_inner_content(|writer| {
            for visit in visits {
                let (latitude, longitude) = degrees(account.point(visit.cell));
                let point = writer
                    .create_element("trkpt")
                    .with_attributes([("lat", latitude.as_str()), ("lon", longitude.as_str())]);
                point.write_inner_content(|writer| {
                    xml::element(writer, "time", &wall_time(account.start_unix_ns, visit.time))
                })?;
            }
            Ok(())
        })?;
        Ok(())
    })?;
    Ok(())
}

/// Latitude and longitude to a centimeter: schemas of GPX take no exponents.
fn degrees(point: GeoPoint) -> (String, String) {
    (format!("{:.7}", point.latitude_degrees), format!("{:.7}", point.longitude_degrees))
}
