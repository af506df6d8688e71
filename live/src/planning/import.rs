//! Files that a viewer opens: the browser sends their content, and the readers of map files read it.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use dragnet_planning::MissionPlan;
use dragnet_scenario::map_file::{Area, Areas, Purpose};
use serde::Deserialize;

use super::Refused;
use super::draft::Stale;

/// A file as a page sends it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sent {
    revision: u64,
    /// Its name, which says its format.
    name: String,
    /// Its content, in base64.
    content: String,
    /// Whether it replaces the areas of the plan, or adds to them.
    replaces: bool,
}

/// A plan with the areas of a file.
pub(super) struct Import {
    pub(super) revision: u64,
    pub(super) plan: MissionPlan,
    pub(super) message: String,
}

/// The plan with the areas of a file.
pub(super) fn import(
    sent: Sent,
    plan: impl FnOnce(u64) -> Result<MissionPlan, Stale>,
) -> Result<Import, Refused> {
    let Sent { revision, name, content, replaces } = sent;
    // Only what follows the last separator: browsers send a name, others may send a path.
    let name = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let bytes = STANDARD
        .decode(content)
        .map_err(|error| Refused::invalid(format!("{name}: not in base64: {error}")))?;
    if Path::new(name).extension().is_some_and(|it| it.eq_ignore_ascii_case("toml")) {
        return Err(Refused::invalid(format!(
            "{name}: a scenario names files beside it, which a browser does not send; open it with: dragnet plan {name}"
        )));
    }
    let (areas, invalid) = Areas::valid_from_bytes(Path::new(name), bytes).map_err(Refused::invalid)?;
    let mut plan = plan(revision)?;
    let ignored = match areas.left_out.len() {
        0 => String::new(),
        _ => format!(" Without a meaning for a search, and left out: {}.", shown(&areas.left_out)),
    };
    let errors: Vec<String> = invalid.iter().map(ToString::to_string).collect();
    let invalid = if errors.is_empty() { String::new() } else { format!(" Not read: {}.", shown(&errors)) };
    if areas.areas.is_empty() && !invalid.is_empty() {
        return Err(Refused::invalid(invalid.trim_start()));
    }
    if areas.areas.is_empty() {
        return Err(Refused::invalid(format!("{name}: holds no area and no place.{ignored}")));
    }
    if replaces {
        plan.features.clear();
    }
    plan.add(&areas);
    let mended = match areas.mended.len() {
        0 => String::new(),
        _ => format!(" Mended, which changes next to nothing: {}.", shown(&areas.mended)),
    };
    let message = format!("{name}: {} read.{invalid}{mended}{ignored}", counted(&areas.areas));
    Ok(Import { revision, plan, message })
}

/// `1 area`, `2 areas and 1 place`.
fn counted(areas: &[Area]) -> String {
    let is_place =
        |area: &&Area| matches!(area.purpose, Purpose::Start(_) | Purpose::LastKnownPosition { .. });
    let places = areas.iter().filter(is_place).count();
    let parts: Vec<String> = [(areas.len() - places, "area"), (places, "place")]
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(count, what)| format!("{count} {what}{}", if count == 1 { "" } else { "s" }))
        .collect();
    parts.join(" and ")
}

/// The first of the names.
fn shown(names: &[String]) -> String {
    const MOST: usize = 5;
    let first = names.iter().take(MOST).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}
