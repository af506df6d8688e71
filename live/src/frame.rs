//! Frames: JSON messages to a page. A new viewer receives the whole state, then changes.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use dragnet_coordinator::finds::Find;
use dragnet_coordinator::segment::SegmentRow;
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::marks::{MarkId, Marked, Marks};
use dragnet_proto::orders::{NumberedOrder, RobotOrder};
use dragnet_proto::runs::runs;
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::mark::{Mark, Searched};
use dragnet_search::observation::{RobotId, Source};
use dragnet_search::subjects::{Standing, SubjectPosterior};
use dragnet_search::terrain::Terrain;
use serde::Serialize;
use std::collections::BTreeMap;

use crate::orders::{Acknowledged, Order};
use crate::picture::PictureFrame;
use crate::place::{AreaFrame, EarthFrame, MapPoint};
use crate::view::{State, View};

/// Log-odds are clamped to these for display, nats: probabilities of 0.000 000 8 and 0.9975. One object somewhere in a
/// large map is a small probability in each cell, and the page must still tell likely cells from others.
pub const LEAST_NATS: f64 = -14.0;
/// See [`LEAST_NATS`].
pub const MOST_NATS: f64 = 6.0;
/// If more than this share of the cells has changed, the whole map is sent.
const SHARE: usize = 8;

/// The first message to a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hello {
    /// `hello`.
    pub kind: &'static str,
    /// The mission's name.
    pub name: String,
    /// Rows of the map, from the south.
    pub rows: u32,
    /// Columns, from the west.
    pub columns: u32,
    /// Edge of a cell, meters.
    pub cell_meters: f64,
    /// One byte per cell, 1 if traversable; Base64.
    pub ground: String,
    /// Probability from which an object is found.
    pub detection_threshold: f64,
    /// Number of objects, if known.
    pub objects: Option<usize>,
    /// Where the map lies on the earth, if known.
    pub earth: Option<EarthFrame>,
    /// The areas drawn on the map.
    pub areas: Vec<AreaFrame>,
    /// End of a recording, seconds; absent for a running mission.
    pub end: Option<f64>,
    /// Times of a recording at which objects were declared, seconds.
    pub finds: Vec<f64>,
}

impl Hello {
    /// The first message for a view, and the end of its recording.
    #[must_use]
    pub fn new(view: &View, end: Option<f64>) -> Self {
        let (about, terrain) = (view.about(), view.terrain());
        let ground: Vec<u8> =
            terrain.grid().cells().map(|cell| u8::from(terrain.is_traversable(cell))).collect();
        Self {
            kind: "hello",
            name: about.name.clone(),
            rows: terrain.grid().rows(),
            columns: terrain.grid().columns(),
            cell_meters: terrain.cell_meters(),
            ground: STANDARD.encode(ground),
            detection_threshold: about.detection_threshold,
            objects: about.objects.as_ref().map(Vec::len),
            earth: about.earth.as_ref().map(|earth| EarthFrame::of(&earth.frame)),
            areas: about.earth.as_ref().map(AreaFrame::all).unwrap_or_default(),
            end,
            finds: Vec::new(),
        }
    }
}

/// A further message to a page. Absent fields have not changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// `frame`.
    pub kind: &'static str,
    /// Whether it contains the whole state.
    pub is_whole: bool,
    /// Mission time, seconds.
    pub time: f64,
    /// The belief, one [`level`] per cell; Base64.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<String>,
    /// How thoroughly each cell was searched, one [`searched_level`] per cell; Base64. Present with `levels`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub searched: Option<String>,
    /// Cells of which a level has changed: `[number, level, searched level]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<(u32, u8, u8)>,
    /// One byte per cell, 1 if it is searched and out of reach; Base64.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out_of_reach: Option<String>,
    /// The operator's zones: runs of cells `[first, count, zone]`, 1 if they are skipped and 2 if they are no-go. Absent if
    /// nothing has changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zones: Option<Vec<[u32; 3]>>,
    /// The operator's marks that count, in the order in which they were made. Absent if nothing has changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marked: Option<Vec<MarkFrame>>,
    /// How thoroughly each segment was searched, and the whole search last. Absent if nothing has changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segments: Option<Vec<SegmentRow>>,
    /// Robots, by number.
    pub robots: Vec<RobotFrame>,
    /// Declared objects.
    pub declared: Vec<DeclaredFrame>,
    /// Finds that the operator has dismissed and that are not declared any more.
    pub dismissed: Vec<DismissedFrame>,
    /// The operator's last commands, the newest first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orders: Option<Vec<OrderFrame>>,
    /// Probability of detection of the whole search, 0 to 1.
    pub pod: f64,
    /// Expected remaining objects.
    pub expected: f64,
    /// Where the subjects are, if their number is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subject: Option<SubjectFrame>,
    /// Entropy of the map, nats.
    pub entropy: f64,
    /// Recall if the objects are known, 0 to 1; otherwise the number of declared objects.
    pub progress: f64,
    /// Messages of robots per second of mission time.
    pub messages: f64,
    /// Number of observations of robots so far.
    pub observations: u64,
    /// Number of operator marks so far.
    pub marks: u64,
    /// Whether the operator has paused the search.
    pub is_paused: bool,
    /// Whether the operator has called the robots back to their bases.
    pub is_called_back: bool,
    /// The robots that are not back yet, if the mission is ending.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ending: Option<Vec<u16>>,
    /// Number of cells that the operator has added.
    pub added: usize,
    /// The curves up to here, `[seconds, entropy, progress]`; only in a whole frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curve: Vec<[f64; 3]>,
}

/// Where subjects are, as expected numbers; what they leave is in searched cells that are not declared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SubjectFrame {
    /// How many there are.
    pub number: u32,
    /// In declared cells.
    pub found: f64,
    /// Outside of the searched cells.
    pub rest_of_world: f64,
}

/// The state of a robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotFrame {
    /// Its number.
    pub robot: u16,
    /// Its state.
    pub state: State,
    /// What the operator wants of it: `resume`, `go`, `return` or `pause`.
    pub order: &'static str,
    /// Whether several processes have its number.
    pub is_doubled: bool,
    /// For how long it has entered no cell although it drives, seconds, if that is longer than usual.
    pub stands_for: Option<u64>,
    /// Its cell's number; unknown before its first message.
    pub cell: Option<u32>,
    /// Cells entered since the last frame, or the last ones in a whole frame.
    pub trail: Vec<u32>,
    /// Cells still to be entered.
    pub plan: Vec<u32>,
    /// When it is expected in each of them, seconds of mission time; empty if its speed is unknown, or it does not drive.
    pub expected: Vec<u64>,
    /// Distance driven, meters.
    pub meters: f64,
}

/// A declared object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeclaredFrame {
    /// Its cell's number.
    pub cell: u32,
    /// Its probability now.
    pub probability: f64,
    /// Time of its declaration, seconds.
    pub since: f64,
    /// The robot whose observation made it reach the detection threshold.
    pub robot: Option<u16>,
    /// What the operator has decided: `confirmed`, or `dismissed` if it was declared again after that.
    pub operator: Option<&'static str>,
    /// Where it is, if a robot knows it better than by its cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<PositionFrame>,
    /// A robot's picture of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<PictureFrame>,
}

/// The position of an object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PositionFrame {
    /// Meters east and north of the map's south-western corner, to the decimeter.
    pub meters: MapPoint,
    /// The largest distance of the object from there with a probability of 95 %, meters, rounded up.
    pub accuracy_meters: f64,
}

impl PositionFrame {
    fn of(view: &View, cell: Cell) -> Option<Self> {
        let position = view.fold().position(cell)?;
        let (east, north) = position.meters();
        Some(Self {
            meters: [east, north].map(|meters| (10.0 * meters).round() / 10.0),
            accuracy_meters: (10.0 * position.accuracy_meters()).ceil() / 10.0,
        })
    }
}

/// A find that the operator has dismissed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DismissedFrame {
    /// Its cell's number.
    pub cell: u32,
    /// Time of its dismissal, seconds.
    pub since: f64,
    /// The robot whose observation had made it reach the detection threshold.
    pub robot: Option<u16>,
    /// Where it is, if a robot knows it better than by its cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<PositionFrame>,
    /// A robot's picture of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<PictureFrame>,
}

/// A mark of the operator.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarkFrame {
    /// Its name, as the command `withdraw` takes it: a number that may be too long for a browser's.
    pub id: String,
    /// When it was made, seconds.
    pub time: f64,
    /// The operator's words; may be empty.
    pub note: String,
    /// A clue's cell, by number; a search of others has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<u32>,
    /// A clue's likelihood ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
    /// A clue's standard error a direction, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_meters: Option<f64>,
    /// The cells of a search of others: runs `[first, count]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<Vec<[u32; 2]>>,
    /// Its probability of detection, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pod: Option<f64>,
}

/// A command of the operator, and the robots that have it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderFrame {
    /// When it was given, seconds.
    pub time: f64,
    /// `resume`, `go`, `return`, `pause`, `area`, `open`, `skip`, `no_go`, `searched`, `clue`, `withdraw`, `confirmed`, `dismissed` or `undone`.
    pub what: &'static str,
    /// The robot that it is for; that of all robots has none.
    pub robot: Option<u16>,
    /// Its cell's number, if it is about one.
    pub cell: Option<u32>,
    /// Number of cells that it is about.
    pub cells: usize,
    /// Robots that are known to have received it.
    pub has: Vec<u16>,
    /// Robots of which that is not known.
    pub waits: Vec<u16>,
}

/// The state that a page shows.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// [`level`] and [`searched_level`], shape `[cells]`; empty before the first frame.
    levels: Vec<[u8; 2]>,
    /// Of the reach, and number of added cells; `None` before the first frame.
    reach: Option<(u32, usize)>,
    steps: BTreeMap<RobotId, u64>,
    orders: Option<Vec<OrderFrame>>,
    zones: Option<Zones>,
    marks: Option<Marks>,
    segments: Option<Vec<SegmentRow>>,
}

/// The belief in a cell, in 255 steps of its log-odds from [`LEAST_NATS`] (1) to [`MOST_NATS`] (255); 0 where nothing is
/// searched. That in subjects of known number is their posterior.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
pub fn level(view: &View, subject: Option<&SubjectPosterior>, cell: Cell) -> u8 {
    if !view.terrain().is_searched(cell) {
        return 0;
    }
    let log_odds = match subject.map(|subject| subject.probability(cell)) {
        Some(probability) => (probability / (1.0 - probability)).ln(),
        None => view.belief().log_odds_nats(cell),
    };
    let log_odds = log_odds.clamp(LEAST_NATS, MOST_NATS);
    1 + ((log_odds - LEAST_NATS) / (MOST_NATS - LEAST_NATS) * 254.0).round() as u8
}

/// How thoroughly a cell was searched: 0 if it was never observed, otherwise 1 plus its probability of detection in
/// percent.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share from 0 to 1")]
pub fn searched_level(view: &View, cell: Cell) -> u8 {
    view.pod(cell).map_or(0, |pod| 1 + (100.0 * pod).round() as u8)
}

impl Frame {
    /// The changes between a shown state and a view.
    pub fn next(view: &View, shown: &mut Shown) -> Self {
        let is_whole = shown.levels.is_empty();
        let subject = view.subject();
        let Cells { levels, searched, changes } = cells(view, subject.as_ref(), &mut shown.levels);
        let status = view.status();
        let added = status.map_or(0, |status| status.directive.added.len());
        let order = status.map_or(TeamOrder::default(), |status| status.directive.order);
        let (observations, marks) = view.counts();
        Self {
            kind: "frame",
            is_whole,
            time: view.now().as_seconds(),
            levels,
            searched,
            changes,
            out_of_reach: out_of_reach(view, added, &mut shown.reach),
            zones: zones(view, &mut shown.zones),
            marked: marked(view, &mut shown.marks),
            segments: segments(view, subject.as_ref(), &mut shown.segments),
            robots: robots(view, &mut shown.steps),
            declared: declared(view, subject.as_ref()),
            dismissed: dismissed(view),
            orders: orders(view, &mut shown.orders),
            pod: view.total_pod(),
            expected: status.map_or(0.0, |status| status.expected_remaining),
            subject: view.standing().map(|Standing { number, found, rest_of_world, .. }| SubjectFrame {
                number,
                found,
                rest_of_world,
            }),
            entropy: view.entropy_nats(),
            progress: view.progress(),
            messages: view.messages_per_second(),
            observations,
            marks,
            is_paused: order == TeamOrder::Pause,
            is_called_back: order == TeamOrder::Return,
            ending: view.ending().map(|robots| robots.into_iter().map(RobotId::number).collect()),
            added,
            curve: if is_whole { view.curve().to_vec() } else { Vec::new() },
        }
    }
}

fn segments(
    view: &View,
    subject: Option<&SubjectPosterior>,
    shown: &mut Option<Vec<SegmentRow>>,
) -> Option<Vec<SegmentRow>> {
    let rows = view.segments(subject);
    if shown.as_deref() == Some(rows) {
        return None;
    }
    Some(shown.insert(rows.to_vec()).clone())
}

/// The levels of all cells, or those that have changed.
#[derive(Default)]
struct Cells {
    levels: Option<String>,
    searched: Option<String>,
    changes: Vec<(u32, u8, u8)>,
}

fn cells(view: &View, subject: Option<&SubjectPosterior>, shown: &mut Vec<[u8; 2]>) -> Cells {
    let terrain: &Terrain = view.terrain();
    let of = |cell| [level(view, subject, cell), searched_level(view, cell)];
    let levels = terrain.grid().cells().map(of).collect();
    let before = std::mem::replace(shown, levels);
    let pairs = (0..).zip(shown.iter().zip(&before));
    let changes: Vec<(u32, u8, u8)> = pairs
        .filter(|(_, (now, before))| now != before)
        .map(|(number, (&[level, searched], _))| (number, level, searched))
        .collect();
    if before.is_empty() || changes.len() > shown.len() / SHARE {
        let encode = |of: usize| Some(STANDARD.encode(shown.iter().map(|it| it[of]).collect::<Vec<u8>>()));
        Cells { levels: encode(0), searched: encode(1), changes: Vec::new() }
    } else {
        Cells { changes, ..Cells::default() }
    }
}

fn out_of_reach(view: &View, added: usize, shown: &mut Option<(u32, usize)>) -> Option<String> {
    let now = (view.reach()?.version(), added);
    if shown.replace(now) == Some(now) {
        return None;
    }
    let cells = view.terrain().grid().cells();
    let bytes: Vec<u8> = cells.map(|cell| u8::from(view.is_out_of_reach(cell))).collect();
    Some(STANDARD.encode(bytes))
}

fn zones(view: &View, shown: &mut Option<Zones>) -> Option<Vec<[u32; 3]>> {
    let zones = view.fold().zones();
    if shown.as_ref() == Some(zones) {
        return None;
    }
    *shown = Some(zones.clone());
    let closed = zones.iter().map(|(cell, entry)| (cell, entry.value)).filter(|it| it.1 != Zone::Open);
    Some(runs(closed).into_iter().map(|run| [run.first, run.count, run.value.number().into()]).collect())
}

fn marked(view: &View, shown: &mut Option<Marks>) -> Option<Vec<MarkFrame>> {
    let marks = view.fold().marks();
    if shown.as_ref() == Some(marks) {
        return None;
    }
    *shown = Some(marks.clone());
    let cell_meters = view.terrain().cell_meters();
    Some(marks.standing().map(|(id, marked)| MarkFrame::of(id, &marked, cell_meters)).collect())
}

impl MarkFrame {
    fn of(id: MarkId, marked: &Marked, cell_meters: f64) -> Self {
        let clue = if let Mark::Clue(clue) = &marked.mark { Some(clue) } else { None };
        let search = if let Mark::Searched(search) = &marked.mark { Some(search) } else { None };
        let cells = search.map(|search| runs(search.cells.iter().map(|&cell| (cell, ()))));
        Self {
            id: id.to_string(),
            time: MissionTime(id).as_seconds(),
            note: marked.note.clone(),
            cell: clue.map(|clue| clue.cell.number()),
            ratio: clue.map(|clue| clue.ratio()),
            radius_meters: clue.map(|clue| clue.radius_cells() * cell_meters),
            cells: cells.map(|runs| runs.iter().map(|run| [run.first, run.count]).collect()),
            pod: search.map(Searched::probability_of_detection),
        }
    }
}

fn robots(view: &View, shown: &mut BTreeMap<RobotId, u64>) -> Vec<RobotFrame> {
    let status = view.status();
    let numbers = |cells: &mut dyn Iterator<Item = Cell>| cells.map(Cell::number).collect();
    let frame = |(robot, walk, track, state): (RobotId, &crate::view::Walk, _, State)| {
        let track: dragnet_coordinator::track::Track = track;
        let before = shown.insert(robot, walk.steps).unwrap_or(0);
        let new = usize::try_from(walk.steps - before).unwrap_or(usize::MAX).min(walk.trail.len());
        RobotFrame {
            robot: robot.number(),
            state,
            order: order_word(view.orders().current(robot)),
            is_doubled: status.is_some_and(|status| status.doubled.contains(&robot)),
            stands_for: view.stands_for(robot, state).map(|lasts| lasts.as_secs()),
            cell: track.pose.map(|(cell, _)| cell.number()),
            trail: numbers(&mut walk.trail.iter().skip(walk.trail.len() - new).copied()),
            plan: numbers(&mut track.plan.iter().flat_map(|plan| plan.path.iter().copied())),
            expected: view.expected_seconds(robot, &track, state),
            meters: walk.path_meters,
        }
    };
    view.robots().map(frame).collect()
}

fn declared(view: &View, subject: Option<&SubjectPosterior>) -> Vec<DeclaredFrame> {
    let declared = view.declared().iter().map(|object| DeclaredFrame {
        cell: object.cell.number(),
        probability: match subject {
            Some(subject) => subject.probability(object.cell),
            None => view.belief().probability(object.cell),
        },
        since: object.time_ns as f64 / 1e9,
        robot: finder(view, object.cell),
        operator: view.fold().verdicts().decision(object.cell).and_then(Decision::word),
        position: PositionFrame::of(view, object.cell),
        picture: PictureFrame::of(view, object.cell),
    });
    declared.collect()
}

fn dismissed(view: &View) -> Vec<DismissedFrame> {
    let dismissed = view.fold().finds().into_iter().filter(|find| !find.is_declared);
    let frame = |find: Find| DismissedFrame {
        cell: find.cell.number(),
        since: find.since.as_seconds(),
        robot: finder(view, find.cell),
        position: PositionFrame::of(view, find.cell),
        picture: PictureFrame::of(view, find.cell),
    };
    dismissed.map(frame).collect()
}

fn finder(view: &View, cell: Cell) -> Option<u16> {
    match view.finder(cell)? {
        Source::Robot(robot) => Some(robot.number()),
        Source::Operator => None,
    }
}

fn orders(view: &View, shown: &mut Option<Vec<OrderFrame>>) -> Option<Vec<OrderFrame>> {
    let robots: Vec<RobotId> = view.robots().map(|(robot, ..)| robot).collect();
    let orders: Vec<OrderFrame> = view.orders().iter().map(|order| order_frame(order, &robots)).collect();
    if shown.as_ref() == Some(&orders) {
        return None;
    }
    *shown = Some(orders);
    shown.clone()
}

/// The command for an order.
const fn order_word(order: RobotOrder) -> &'static str {
    match order {
        RobotOrder::Search => "resume",
        RobotOrder::Go(_) => "go",
        RobotOrder::Return => "return",
        RobotOrder::Pause => "pause",
    }
}

/// The command for a zone.
const fn zone_word(zone: Zone) -> &'static str {
    match zone {
        Zone::Open => "open",
        Zone::Skip => "skip",
        Zone::NoGo => "no_go",
    }
}

/// The command for a mark, and the cell of a clue.
fn mark_word(marked: &Marked) -> (&'static str, Option<Cell>) {
    let (what, cell) = match &marked.mark {
        Mark::Searched(_) => ("searched", None),
        Mark::Clue(clue) => ("clue", Some(clue.cell)),
    };
    (if marked.is_withdrawn { "withdraw" } else { what }, cell)
}

fn order_frame(Acknowledged { time, order, has }: &Acknowledged, robots: &[RobotId]) -> OrderFrame {
    let (what, cell) = match order {
        Order::Team(_, TeamOrder::End) => ("end", None),
        Order::Team(_, order) => (order_word((*order).into()), None),
        Order::Robot(_, NumberedOrder { value: order, .. }) => {
            (order_word(*order), if let RobotOrder::Go(there) = order { Some(*there) } else { None })
        }
        Order::Area(_) => ("area", None),
        Order::Zone(zone, _) => (zone_word(zone.value), None),
        Order::Mark(_, entry) => mark_word(&entry.value),
        Order::Verdict(cell, verdict) => (verdict.decision.word().unwrap_or("undone"), Some(*cell)),
    };
    let cells = match order {
        Order::Team(..) | Order::Robot(..) => 0,
        Order::Area(cells) | Order::Zone(_, cells) => cells.len(),
        Order::Mark(_, entry) => entry.value.mark.cell_count(),
        Order::Verdict(..) => 1,
    };
    let concerned = robots.iter().filter(|&&robot| order.concerns(robot));
    let (has, waits) = concerned.partition::<Vec<RobotId>, _>(|robot| has.contains(robot));
    let numbers = |robots: Vec<RobotId>| robots.into_iter().map(RobotId::number).collect();
    OrderFrame {
        time: time.as_seconds(),
        what,
        robot: if let Order::Robot(robot, _) = order { Some(robot.number()) } else { None },
        cell: cell.map(Cell::number),
        cells,
        has: numbers(has),
        waits: numbers(waits),
    }
}
