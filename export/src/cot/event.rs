//! One event of Cursor on Target 2.0, and its text.

use std::io;
use std::time::Duration;

use dragnet_scenario::map_file::GeoPoint;
use quick_xml::events::BytesText;

use crate::time::utc;
use crate::xml::{self, Document, plain};

/// What stands for an unknown height or error.
const UNKNOWN: &str = "9999999.0";

/// An event: what something is, where, and until when that is to be shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The name of the thing; the next event of this name replaces this one.
    pub uid: String,
    /// The type, such as `a-f-G-E-V`: a friendly vehicle on the ground.
    pub kind: &'static str,
    /// How the position came about, such as `m-g`: by a machine.
    pub how: &'static str,
    /// When it was sent, Unix time, nanoseconds.
    pub time_unix_ns: u64,
    /// The time from then on after which it is not to be shown as current.
    pub stale: Duration,
    /// The position.
    pub point: GeoPoint,
    /// The largest horizontal error of the position, meters, if known.
    pub error_meters: Option<f64>,
    /// What else is known.
    pub detail: Detail,
}

/// What else is known of a thing.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// A unit that moves.
    Unit {
        /// Its name on maps.
        callsign: String,
        /// Its state in words.
        remarks: String,
        /// Its motion, if known.
        motion: Option<Motion>,
    },
    /// A marker on the map.
    Marker {
        /// Its name on maps.
        callsign: String,
        /// What is known of it, in words.
        remarks: String,
        /// Its color.
        color: Color,
    },
    /// A line, or the ground that it encloses if it ends where it begins.
    Shape {
        /// Its name on maps.
        callsign: String,
        /// What it is for, in words.
        remarks: String,
        /// Its color.
        color: Color,
        /// Its corners, at least two.
        corners: Vec<GeoPoint>,
    },
    /// Maps are to remove what has this name.
    Removal {
        /// The name of what is removed.
        uid: String,
    },
}

/// How a unit moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// From true north, clockwise, degrees, 0 to 360.
    pub course_degrees: f64,
    /// Over ground, at least 0.
    pub speed_meters_per_second: f64,
}

/// A color: opacity, red, green and blue, 8 bits each from the highest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color(pub u32);

impl Color {
    /// As events write it: the bits of a signed number.
    fn number(self) -> String {
        self.0.cast_signed().to_string()
    }

    /// The same color, of which a fifth covers what is below.
    const fn faint(self) -> Self {
        Self(self.0 & 0x00ff_ffff | 0x3300_0000)
    }
}

impl Event {
    /// The event as an XML document in one line, as a datagram or a part of a stream.
    #[must_use]
    pub fn text(&self) -> String {
        xml::line(|writer| {
            let (time, stale) = (utc(self.time_unix_ns), utc(self.stale_unix_ns()));
            let event = writer.create_element("event").with_attributes([
                ("version", "2.0"),
                ("uid", &plain(&self.uid)),
                ("type", self.kind),
                ("how", self.how),
                ("time", &time),
                ("start", &time),
                ("stale", &stale),
            ]);
            event.write_inner_content(|writer| {
                self.write_point(writer)?;
                writer.create_element("detail").write_inner_content(|writer| self.detail.write(writer))?;
                Ok(())
            })?;
            Ok(())
        })
    }

    /// When it is no longer current, Unix time, nanoseconds.
    #[must_use]
    pub fn stale_unix_ns(&self) -> u64 {
        self.time_unix_ns.saturating_add(u64::try_from(self.stale.as_nanos()).unwrap_or(u64::MAX))
    }

    fn write_point(&self, writer: &mut Document) -> io::Result<()> {
        let GeoPoint { latitude_degrees, longitude_degrees } = self.point;
        let error = self.error_meters.map_or_else(|| UNKNOWN.to_owned(), |meters| format!("{meters:.1}"));
        let point = writer.create_element("point").with_attributes([
            ("lat", format!("{latitude_degrees:.7}").as_str()),
            ("lon", &format!("{longitude_degrees:.7}")),
            ("hae", UNKNOWN),
            ("ce", &error),
            ("le", UNKNOWN),
        ]);
        point.write_empty()?;
        Ok(())
    }
}

impl Detail {
    fn write(&self, writer: &mut Document) -> io::Result<()> {
        match self {
            Self::Unit { callsign, remarks, motion } => {
                named(writer, callsign, remarks)?;
                if let Some(Motion { course_degrees, speed_meters_per_second }) = motion {
                    let (course, speed) =
                        (format!("{course_degrees:.1}"), format!("{speed_meters_per_second:.2}"));
                    empty(writer, "track", &[("course", &course), ("speed", &speed)])?;
                }
                Ok(())
            }
            Self::Marker { callsign, remarks, color } => {
                named(writer, callsign, remarks)?;
                let color = color.number();
                empty(writer, "color", &[("argb", &color)])?;
                let icon = format!("COT_MAPPING_SPOTMAP/b-m-p-s-m/{color}");
                empty(writer, "usericon", &[("iconsetpath", &icon)])
            }
            Self::Shape { callsign, remarks, color, corners } => {
                named(writer, callsign, remarks)?;
                for GeoPoint { latitude_degrees, longitude_degrees } in corners {
                    let point = format!("{latitude_degrees:.7},{longitude_degrees:.7}");
                    empty(writer, "link", &[("point", &point)])?;
                }
                empty(writer, "strokeColor", &[("value", &color.number())])?;
                empty(writer, "strokeWeight", &[("value", "3.0")])?;
                if corners.first() == corners.last() {
                    empty(writer, "fillColor", &[("value", &color.faint().number())])?;
                }
                empty(writer, "labels_on", &[("value", "true")])
            }
            Self::Removal { uid } => {
                empty(writer, "link", &[("uid", &plain(uid)), ("relation", "none"), ("type", "none")])?;
                empty(writer, "__forcedelete", &[])
            }
        }
    }
}

fn named(writer: &mut Document, callsign: &str, remarks: &str) -> io::Result<()> {
    empty(writer, "contact", &[("callsign", &plain(callsign))])?;
    writer.create_element("remarks").write_text_content(BytesText::new(&plain(remarks)))?;
    Ok(())
}

fn empty(writer: &mut Document, name: &str, attributes: &[(&str, &str)]) -> io::Result<()> {
    writer.create_element(name).with_attributes(attributes.iter().copied()).write_empty()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_degrees: f64, longitude_degrees: f64) -> GeoPoint {
        GeoPoint { longitude_degrees, latitude_degrees }
    }

    #[test]
    fn an_event_is_one_line_of_xml_whatever_the_names_are() {
        let event = Event {
            uid: "dragnet.valley.area-1".to_owned(),
            kind: "u-d-f",
            how: "h-e",
            time_unix_ns: 946_684_800_000_000_000,
            stale: Duration::from_millis(67_500),
            point: at(47.5, -9.5),
            error_meters: None,
            detail: Detail::Shape {
                callsign: "A & \"B\"\u{1}".to_owned(),
                remarks: "1 < 2".to_owned(),
                color: Color(0xffff_0000),
                corners: vec![at(47.5, -9.5), at(47.75, -9.5), at(47.5, -9.5)],
            },
        };
        assert_eq!(
            event.text(),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?><event version=\"2.0\" uid=\"dragnet.valley.area-1\" type=\"u-d-f\" \
             how=\"h-e\" time=\"2000-01-01T00:00:00.000Z\" start=\"2000-01-01T00:00:00.000Z\" \
             stale=\"2000-01-01T00:01:07.500Z\"><point lat=\"47.5000000\" lon=\"-9.5000000\" hae=\"9999999.0\" \
             ce=\"9999999.0\" le=\"9999999.0\"/><detail><contact callsign=\"A &amp; &quot;B&quot;\"/>\
             <remarks>1 &lt; 2</remarks><link point=\"47.5000000,-9.5000000\"/><link point=\"47.7500000,-9.5000000\"/>\
             <link point=\"47.5000000,-9.5000000\"/><strokeColor value=\"-65536\"/><strokeWeight value=\"3.0\"/>\
             <fillColor value=\"872349696\"/><labels_on value=\"true\"/></detail></event>"
        );
    }
}
