//! Mission time as wall time.

use dragnet_scenario::time::MissionTime;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// Such as `2000-01-01T00:01:07.5Z`: the mission's start by the clock of the recording computer, plus mission time.
/// Whole milliseconds, the resolution of most readers.
pub(crate) fn wall_time(start_unix_ns: u64, time: MissionTime) -> String {
    let milliseconds = (u128::from(start_unix_ns) + u128::from(time.0)) / 1_000_000;
    i128::try_from(milliseconds)
        .ok()
        .and_then(|milliseconds| OffsetDateTime::from_unix_timestamp_nanos(milliseconds * 1_000_000).ok())
        .and_then(|moment| moment.format(&Rfc3339).ok())
        .unwrap_or_else(|| "9999-12-31T23:59:59Z".to_owned())
}

/// Unix time with all three digits of milliseconds, such as `2000-01-01T00:01:07.500Z`: some readers of Cursor on Target
/// want them.
pub(crate) fn utc(unix_ns: u64) -> String {
    let moment =
        OffsetDateTime::from_unix_timestamp_nanos(unix_ns.into()).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    let ((year, month, day), (hour, minute, second, millisecond)) =
        (moment.to_calendar_date(), moment.to_hms_milli());
    let month = u8::from(month);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{millisecond:03}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_that_of_the_start_and_of_the_mission() {
        let start = 946_684_800_000_000_000;
        assert_eq!(wall_time(start, MissionTime(67_500_900_000)), "2000-01-01T00:01:07.5Z");
        assert_eq!(wall_time(u64::MAX, MissionTime(u64::MAX)), "3139-02-09T23:09:07.419Z");
    }

    #[test]
    fn a_time_in_utc_has_all_its_digits() {
        assert_eq!(utc(946_684_867_500_999_999), "2000-01-01T00:01:07.500Z");
        assert_eq!(utc(u64::MAX), "2554-07-21T23:34:33.709Z");
    }
}
