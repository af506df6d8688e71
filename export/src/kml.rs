//! An account as KML 2.2: folders of found objects, of dismissed ones and of marks if there are any, tracks, cleared cells, and the areas of the mission.

use std::io;

use dragnet_coordinator::finds::Find;
use dragnet_proto::message::Detection;
use dragnet_scenario::map_file::{Area, GeoPoint, Purpose};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::mark::{Clue, Searched};
use dragnet_search::observation::RobotId;
use geo::{LineString, Polygon};

use crate::account::{Account, Coverage, Visit};
use crate::bands::{Band, bands, not_searched};
use crate::time::wall_time;
use crate::xml::{self, Document};

/// Kind and style of what is not searched.
const NOT_SEARCHED: &str = "not_searched";

/// Color of what is not searched: alpha, blue, green, red.
const NOT_SEARCHED_COLOR: &str = "600000ff";

/// Colors of the bands, from the lowest probability.
const BAND_COLORS: [&str; Band::COUNT] = ["6000a5ff", "6000ffff", "6000ff80", "80008000"];

/// The text of a KML file.
#[must_use]
pub fn text(account: &Account) -> String {
    xml::document(|writer| {
        let root = writer.create_element("kml").with_attribute(("xmlns", "http://www.opengis.net/kml/2.2"));
        root.write_inner_content(|writer| {
            writer.create_element("Document").write_inner_content(|writer| {
                xml::element(writer, "name", &account.name)?;
                xml::element(writer, "description", &describe(account))?;
                (0..)
                    .zip(BAND_COLORS)
                    .try_for_each(|(number, color)| style(writer, &band_style(number), color))?;
                style(writer, NOT_SEARCHED, NOT_SEARCHED_COLOR)?;
                folder(writer, "Found", |writer| {
                    (1..).zip(&account.found).try_for_each(|(number, it)| found(writer, account, number, it))
                })?;
                if !account.dismissed.is_empty() {
                    folder(writer, "Dismissed", |writer| {
                        let mut dismissed = (1..).zip(&account.dismissed);
                        dismissed.try_for_each(|(number, it)| self::dismissed(writer, account, number, it))
                    })?;
                }
                if account.marks.standing().next().is_some() {
                    folder(writer, "Marks", |writer| {
                        account.clues().try_for_each(|it| clue(writer, account, it))?;
                        account.searches().try_for_each(|it| searched(writer, account, it))
                    })?;
                }
                folder(writer, "Tracks", |writer| {
                    account
                        .tracks
                        .iter()
                        .try_for_each(|(robot, visits)| track(writer, account, *robot, visits))
                })?;
                folder(writer, "Cleared", |writer| {
                    let bands = bands(&account.terrain, &account.frame, &account.pod);
                    bands
                        .iter()
                        .try_for_each(|band| cover(writer, band, "cleared", &band_style(band.number())))
                })?;
                folder(writer, "Not searched", |writer| {
                    let rest = not_searched(&account.terrain, &account.frame, &account.pod);
                    rest.iter().try_for_each(|band| cover(writer, band, NOT_SEARCHED, NOT_SEARCHED))
                })?;
                folder(writer, "Areas", |writer| {
                    account.areas.iter().try_for_each(|(it, coverage)| area(writer, it, coverage.as_ref()))
                })
            })?;
            Ok(())
        })?;
        Ok(())
    })
}

fn describe(account: &Account) -> String {
    let subject =
        account.subject.map_or_else(String::new, |it| format!("; the {}, by the posterior: {it}", it.noun()));
    format!(
        "Until {}: POA {:.4}, POD {:.4}, POS {:.4}{subject}",
        wall_time(account.start_unix_ns, account.until),
        account.total.poa,
        account.total.pod,
        account.total.pos(),
    )
}

fn style(writer: &mut Document, id: &str, color: &str) -> io::Result<()> {
    let element = writer.create_element("Style").with_attribute(("id", id));
    element.write_inner_content(|writer| {
        writer
            .create_element("LineStyle")
            .write_inner_content(|writer| xml::element(writer, "width", "0"))?;
        writer
            .create_element("PolyStyle")
            .write_inner_content(|writer| xml::element(writer, "color", color))?;
        Ok(())
    })?;
    Ok(())
}

fn folder(
    writer: &mut Document,
    name: &str,
    fill: impl FnOnce(&mut Document) -> io::Result<()>,
) -> io::Result<()> {
    writer.create_element("Folder").write_inner_content(|writer| {
        xml::element(writer, "name", name)?;
        fill(writer)
    })?;
    Ok(())
}

fn found(writer: &mut Document, account: &Account, number: usize, object: &Detection) -> io::Result<()> {
    let when = wall_time(account.start_unix_ns, MissionTime(object.time_ns));
    placemark(writer, &format!("Object {number}"), |writer| {
        picture(writer, account, object.cell)?;
        writer
            .create_element("TimeStamp")
            .write_inner_content(|writer| xml::element(writer, "when", &when))?;
        let operator = account.operator(object.cell).map(|word| ("operator", word.to_owned()));
        let facts = [("kind", "found".into()), ("probability", object.probability.to_string())];
        let facts = facts.into_iter().chain(operator).chain(accuracy(account, object.cell));
        data(writer, &facts.collect::<Vec<_>>())?;
        point(writer, account.place(object.cell))
    })
}

fn dismissed(writer: &mut Document, account: &Account, number: usize, find: &Find) -> io::Result<()> {
    let when = wall_time(account.start_unix_ns, find.since);
    placemark(writer, &format!("Dismissed {number}"), |writer| {
        picture(writer, account, find.cell)?;
        writer
            .create_element("TimeStamp")
            .write_inner_content(|writer| xml::element(writer, "when", &when))?;
        let facts = [("kind", "dismissed".into()), ("operator", "dismissed".into())];
        data(writer, &facts.into_iter().chain(accuracy(account, find.cell)).collect::<Vec<_>>())?;
        point(writer, account.place(find.cell))
    })
}

/// Distance within which a find is of its point with a probability of 95 %, if its position is known.
fn accuracy(account: &Account, cell: Cell) -> Option<(&'static str, String)> {
    let position = account.positions.get(&cell)?;
    Some(("accuracy_meters", position.accuracy_meters().to_string()))
}

fn clue(
    writer: &mut Document,
    account: &Account,
    (number, time, clue, note): (usize, MissionTime, Clue, String),
) -> io::Result<()> {
    let (ratio, radius) = (clue.ratio(), account.radius_meters(clue));
    let facts =
        [("kind", "clue".into()), ("ratio", ratio.to_string()), ("radius_meters", radius.to_string())];
    mark(writer, account, (&format!("Clue {number}"), time, &note), &facts, |writer| {
        point(writer, account.point(clue.cell))
    })
}

fn searched(
    writer: &mut Document,
    account: &Account,
    (number, time, search, note): (usize, MissionTime, Searched, String),
) -> io::Result<()> {
    let (pod, cells) = (search.probability_of_detection(), search.cells.len());
    let facts = [("kind", "searched".into()), ("pod", pod.to_string()), ("cells", cells.to_string())];
    mark(writer, account, (&format!("Searched {number}"), time, &note), &facts, |writer| {
        polygons(writer, &account.outline(&search.cells).0)
    })
}

/// The note is no description: programs read facts in those.
fn mark(
    writer: &mut Document,
    account: &Account,
    (name, time, note): (&str, MissionTime, &str),
    facts: &[(&str, String)],
    shape: impl FnOnce(&mut Document) -> io::Result<()>,
) -> io::Result<()> {
    let when = wall_time(account.start_unix_ns, time);
    placemark(writer, name, |writer| {
        writer
            .create_element("TimeStamp")
            .write_inner_content(|writer| xml::element(writer, "when", &when))?;
        data(writer, &[facts, &[("note", note.to_owned())]].concat())?;
        shape(writer)
    })
}

fn track(writer: &mut Document, account: &Account, robot: RobotId, visits: &[Visit]) -> io::Result<()> {
    let (Some(first), Some(last)) = (visits.first(), visits.last()) else { return Ok(()) };
    let time = |visit: &Visit| wall_time(account.start_unix_ns, visit.time);
    placemark(writer, &format!("Robot {robot}"), |writer| {
        writer.create_element("TimeSpan").write_inner_content(|writer| {
            xml::element(writer, "begin", &time(first))?;
            xml::element(writer, "end", &time(last))
        })?;
        data(writer, &[("kind", "track".into()), ("robot", robot.to_string())])?;
        if visits.len() == 1 {
            return point(writer, account.point(first.cell));
        }
        writer.create_element("LineString").write_inner_content(|writer| {
            xml::element(writer, "tessellate", "1")?;
            coordinates(writer, visits.iter().map(|visit| account.point(visit.cell)))
        })?;
        Ok(())
    })
}

fn band_style(number: usize) -> String {
    format!("band-{number}")
}

fn cover(writer: &mut Document, band: &Band, kind: &str, style: &str) -> io::Result<()> {
    placemark(writer, &band.title(), |writer| {
        xml::element(writer, "styleUrl", &format!("#{style}"))?;
        data(
            writer,
            &[
                ("kind", kind.to_owned()),
                ("pod_from", band.from.to_string()),
                ("pod_to", band.to.to_string()),
                ("cells", band.cells.to_string()),
            ],
        )?;
        polygons(writer, &band.region.0)
    })
}

fn area(writer: &mut Document, area: &Area, coverage: Option<&Coverage>) -> io::Result<()> {
    placemark(writer, &area.name, |writer| {
        let mut facts = vec![("kind", area.purpose.word().to_owned())];
        facts.extend(area.purpose.distances());
        if let Some(coverage) = coverage {
            // That of a region stays as drawn, for who reads the file as a map.
            facts.push(("poa", area.purpose.poa().unwrap_or(coverage.poa).to_string()));
            facts.push(("pod", coverage.pod.to_string()));
            facts.push(("pos", coverage.pos().to_string()));
            facts.push(("cells", coverage.cells.to_string()));
            facts.extend(coverage.now.map(|now| ("probability_now", now.to_string())));
        }
        data(writer, &facts)?;
        match &area.purpose {
            Purpose::LastKnownPosition { point: place, .. } | Purpose::Start(place) => point(writer, *place),
            other if !other.lines().is_empty() => {
                writer.create_element("MultiGeometry").write_inner_content(|writer| {
                    other.polygons().iter().try_for_each(|it| polygon(writer, it))?;
                    other.lines().iter().try_for_each(|line| {
                        writer
                            .create_element("LineString")
                            .write_inner_content(|writer| line_coordinates(writer, line))?;
                        Ok(())
                    })
                })?;
                Ok(())
            }
            other => polygons(writer, other.polygons()),
        }
    })
}

fn placemark(
    writer: &mut Document,
    name: &str,
    fill: impl FnOnce(&mut Document) -> io::Result<()>,
) -> io::Result<()> {
    writer.create_element("Placemark").write_inner_content(|writer| {
        xml::element(writer, "name", name)?;
        fill(writer)
    })?;
    Ok(())
}

/// A description in HTML that shows a find's picture, if there is one.
fn picture(writer: &mut Document, account: &Account, cell: Cell) -> io::Result<()> {
    let Some((file, picture)) = account.picture_file(cell).zip(account.pictures.get(&cell)) else {
        return Ok(());
    };
    let [file, source] = [file, picture.facts.source()].map(quick_xml::escape::escape);
    xml::element(writer, "description", &format!("<img src=\"{file}\" width=\"320\"><br>{source}"))
}

fn data(writer: &mut Document, facts: &[(&str, String)]) -> io::Result<()> {
    writer.create_element("ExtendedData").write_inner_content(|writer| {
        for (name, value) in facts {
            let element = writer.create_element("Data").with_attribute(("name", *name));
            element.write_inner_content(|writer| xml::element(writer, "value", value))?;
        }
        Ok(())
    })?;
    Ok(())
}

fn polygons(writer: &mut Document, polygons: &[Polygon<f64>]) -> io::Result<()> {
    writer
        .create_element("MultiGeometry")
        .write_inner_content(|writer| polygons.iter().try_for_each(|it| polygon(writer, it)))?;
    Ok(())
}

fn polygon(writer: &mut Document, polygon: &Polygon<f64>) -> io::Result<()> {
    writer.create_element("Polygon").write_inner_content(|writer| {
        boundary(writer, "outerBoundaryIs", polygon.exterior())?;
        polygon.interiors().iter().try_for_each(|hole| boundary(writer, "innerBoundaryIs", hole))
    })?;
    Ok(())
}

fn boundary(writer: &mut Document, name: &str, ring: &LineString<f64>) -> io::Result<()> {
    writer.create_element(name).write_inner_content(|writer| {
        writer.create_element("LinearRing").write_inner_content(|writer| line_coordinates(writer, ring))?;
        Ok(())
    })?;
    Ok(())
}

fn point(writer: &mut Document, point: GeoPoint) -> io::Result<()> {
    writer
        .create_element("Point")
        .write_inner_content(|writer| coordinates(writer, std::iter::once(point)))?;
    Ok(())
}

fn line_coordinates(writer: &mut Document, line: &LineString<f64>) -> io::Result<()> {
    coordinates(writer, line.0.iter().map(|&corner| corner.into()))
}

fn coordinates(writer: &mut Document, points: impl Iterator<Item = GeoPoint>) -> io::Result<()> {
    let tuples: Vec<String> =
        points.map(|point| format!("{},{}", point.longitude_degrees, point.latitude_degrees)).collect();
    xml::element(writer, "coordinates", &tuples.join(" "))
}
