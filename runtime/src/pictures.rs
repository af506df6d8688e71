//! Pictures of finds over Zenoh: a robot answers queries for its own, the coordinator asks for those of declared objects.
//!
//! The coordinator asks all robots what they have of a cell, which costs some 100 bytes each, and then one of them for the
//! picture, one query at a time. If the mission's rate is limited, it asks for parts, so slowly that they take a quarter of it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use dragnet_coordinator::mission::Record;
use dragnet_coordinator::node::Listener;
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Key, Mission, Selection, Topic};
use dragnet_proto::picture::{Assembly, Picture, PictureFacts, PicturePart, PictureRequest};
use dragnet_proto::state_machine::Event;
use dragnet_scenario::Places;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use image::{ImageFormat, ImageReader};
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use zenoh::qos::Priority;
use zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable};
use zenoh::{Session, Wait};

use crate::RuntimeError;
use crate::link::Link;
use crate::vehicle::FindPicture;
use crate::wall_clock::Report;

/// The most pictures that a robot keeps; the worst are dropped.
const MOST_PICTURES: usize = 256;
/// The longest side of a picture, pixels.
const MOST_PIXELS: u32 = 1024;
/// The most replies to a query that count.
const MOST_REPLIES: usize = 1024;
/// How long the coordinator waits for replies.
const PATIENCE: Duration = Duration::from_secs(3);
/// How long it waits before it asks again for the picture of a find that has none,
const ASK: Duration = Duration::from_secs(2);
/// and for a better one.
const ASK_AGAIN: Duration = Duration::from_secs(10);
/// The part of a limited rate that pictures take.
const SHARE: f64 = 0.25;
/// The fewest bytes that are asked for at a time, so that the facts beside them cost less.
const LEAST_BYTES: usize = 256;

/// A robot's pictures of its finds.
#[derive(Debug)]
pub(crate) struct Shelf {
    robot: RobotId,
    kept: Mutex<Kept>,
}

#[derive(Debug, Default)]
struct Kept {
    /// Mission time at an instant; a vehicle has another clock.
    clock: Option<(MissionTime, Instant)>,
    pictures: BTreeMap<Cell, Picture>,
}

impl Shelf {
    pub(crate) fn new(robot: RobotId) -> Self {
        Self { robot, kept: Mutex::default() }
    }

    /// It is this time of the mission.
    pub(crate) fn note(&self, now: MissionTime) {
        self.kept().clock = Some((now, Instant::now()));
    }

    /// Keeps a picture that was taken this long ago, in place of the one of its cell.
    pub(crate) fn put(&self, age: Duration, found: FindPicture) {
        let mut kept = self.kept();
        let Some((noted, at)) = kept.clock else { return };
        let now = noted + at.elapsed();
        let facts = PictureFacts {
            robot: self.robot,
            time_ns: now.since(MissionTime::START).saturating_sub(age).as_nanos().try_into().unwrap_or(0),
            cell: found.cell,
            camera: found.camera,
            label: found.label,
            score: found.score,
            quality: found.quality,
        };
        kept.pictures.insert(found.cell, Picture { facts, jpeg: found.jpeg.into() });
        let quality = |(_, picture): &(&Cell, &Picture)| picture.facts.quality;
        if kept.pictures.len() > MOST_PICTURES {
            let worst = kept.pictures.iter().min_by(|a, b| quality(a).total_cmp(&quality(b)));
            if let Some(cell) = worst.map(|(&cell, _)| cell) {
                kept.pictures.remove(&cell);
            }
        }
    }

    fn part(&self, request: PictureRequest) -> Option<PicturePart> {
        Some(self.kept().pictures.get(&request.cell)?.part(request.first, request.most))
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Answers queries for a robot's pictures until the returned value is dropped. Queries for something else get no answer.
///
/// # Errors
/// If Zenoh fails.
pub(crate) async fn serve(
    session: &Session,
    mission: &Mission,
    codec: &Codec,
    shelf: Arc<Shelf>,
) -> Result<Queryable<()>, RuntimeError> {
    let key = mission.key(Topic::Picture(shelf.robot)).to_string();
    let (grid, own) = (codec.grid(), key.clone());
    let answer = move |query: Query| {
        let request = PictureRequest::parse(query.parameters().as_str(), grid).ok();
        if let Some(part) = request.and_then(|request| shelf.part(request)) {
            // A coordinator that is gone asks again when it is back.
            let _ = query.reply(&own, convert::encode_picture(&part)).wait();
        }
    };
    session.declare_queryable(key).callback(answer).await.map_err(RuntimeError::zenoh("offer pictures"))
}

/// A listener that tells for which cells pictures are wanted, the declared ones, and the receiver of that.
pub(crate) fn wanted() -> (Listener, watch::Receiver<BTreeSet<Cell>>) {
    let (wanted, receiver) = watch::channel(BTreeSet::new());
    let listener = move |_: MissionTime, record: &Record| {
        if let Record::Status(status) = record {
            let declared: BTreeSet<Cell> = status.declared.iter().map(|object| object.cell).collect();
            wanted.send_if_modified(|known| {
                let is_new = *known != declared;
                *known = declared;
                is_new
            });
        }
    };
    (Box::new(listener), receiver)
}

/// Asks robots for pictures of finds.
pub(crate) struct Fetcher {
    session: Session,
    mission: Mission,
    codec: Codec,
    places: Places,
    wanted: watch::Receiver<BTreeSet<Cell>>,
    reports: mpsc::Sender<Report>,
    /// Of each wanted cell, the quality of its picture, if it has one, and when it is asked for next.
    asked: BTreeMap<Cell, (Option<f32>, Instant)>,
}

impl Fetcher {
    /// It asks over the coordinator's link. `places` are those of the log.
    pub(crate) fn new(
        link: &Link,
        places: Places,
        wanted: watch::Receiver<BTreeSet<Cell>>,
        reports: mpsc::Sender<Report>,
    ) -> Self {
        Self {
            session: link.session().clone(),
            mission: link.mission().clone(),
            codec: link.codec().clone(),
            places,
            wanted,
            reports,
            asked: BTreeMap::new(),
        }
    }

    /// Passes on pictures until the coordinator ends.
    pub(crate) async fn run(mut self) {
        loop {
            self.update();
            let next =
                self.asked.iter().min_by_key(|(_, (_, due))| *due).map(|(&cell, &(_, due))| (cell, due));
            let due = next.map_or_else(|| Instant::now() + ASK_AGAIN, |(_, due)| due);
            tokio::select! {
                changed = self.wanted.changed() => {
                    if changed.is_err() {
                        return;
                    }
                    continue;
                }
                () = tokio::time::sleep_until(due) => {}
            }
            let Some((cell, _)) = next else { continue };
            let known = self.asked.get(&cell).and_then(|(quality, _)| *quality);
            let picture = self.picture_of(cell, known).await;
            let quality = picture.as_ref().map(|picture| picture.facts.quality).or(known);
            let pause = if quality.is_some() { ASK_AGAIN } else { ASK };
            self.asked.insert(cell, (quality, Instant::now() + pause));
            if let Some(Picture { facts, .. }) = &picture {
                let (me, place) = (Participant::Coordinator, self.places.on_earth(cell));
                tracing::info!("{me} has a picture of the object at {place}, from {}", facts.source());
            }
            if let Some(picture) = picture
                && self.reports.send((None, Event::Pictured(Arc::new(picture)))).await.is_err()
            {
                return;
            }
        }
    }

    fn update(&mut self) {
        let wanted = self.wanted.borrow_and_update().clone();
        self.asked.retain(|cell, _| wanted.contains(cell));
        for cell in wanted {
            self.asked.entry(cell).or_insert_with(|| (None, Instant::now()));
        }
    }

    /// The best picture of a cell that robots have, if it is better than the known one.
    async fn picture_of(&self, cell: Cell, known: Option<f32>) -> Option<Picture> {
        let all = self.mission.expression(Selection::Pictures);
        let offers = self.ask(&all, PictureRequest { cell, first: 0, most: 0 }).await;
        let best = offers.into_iter().max_by(|a, b| a.facts.quality.total_cmp(&b.facts.quality))?;
        if known.is_some_and(|known| best.facts.quality < PictureFacts::BETTER * known) {
            return None;
        }
        let key = self.mission.key(Topic::Picture(best.facts.robot)).to_string();
        let (most, pause) = self.pace();
        let mut assembly = Assembly::of(&best);
        loop {
            let parts = self.ask(&key, assembly.next(most)).await;
            // What is not complete is asked for anew later.
            let true = parts.iter().any(|part| assembly.add(part)) else { return None };
            if let Some(picture) = assembly.whole() {
                return is_picture(&picture.jpeg).then_some(picture);
            }
            tokio::time::sleep(pause).await;
        }
    }

    /// How many bytes to ask for at a time, and how long to pause in between.
    fn pace(&self) -> (usize, Duration) {
        let Some(rate) = self.codec.bytes_per_second() else { return (Picture::MAX_BYTES, Duration::ZERO) };
        let rate = rate * SHARE;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 20,000")]
        let most = (rate.round() as usize).clamp(LEAST_BYTES, Picture::MAX_BYTES);
        (most, Duration::from_secs_f64((most as f64 / rate).min(3600.0)))
    }

    /// The valid replies to a query for pictures: of the cell, each under the key of its robot.
    async fn ask(&self, key: &str, request: PictureRequest) -> Vec<PicturePart> {
        let asked = self
            .session
            .get(format!("{key}?{request}"))
            .target(QueryTarget::All)
            .consolidation(ConsolidationMode::None)
            .priority(Priority::Background)
            .timeout(PATIENCE)
            .await;
        // Without a network there are no pictures for now.
        let Ok(replies) = asked else { return Vec::new() };
        let mut parts = Vec::new();
        while let Ok(reply) = replies.recv_async().await {
            let Ok(sample) = reply.result() else { continue };
            let key = sample.key_expr().as_str().parse();
            let Ok(Key { topic: Topic::Picture(robot), .. }) = key else { continue };
            match self.codec.decode_picture(&sample.payload().to_bytes()) {
                Ok(part) if part.facts.robot == robot && part.facts.cell == request.cell => parts.push(part),
                Ok(_) => {
                    tracing::warn!("rejected a picture of robot {robot}: it is of another robot or cell");
                }
                Err(error) => tracing::warn!("rejected a picture of robot {robot}: {error}"),
            }
            if parts.len() >= MOST_REPLIES {
                break;
            }
        }
        parts
    }
}

/// Whether a file is an image that browsers show.
fn is_picture(jpeg: &[u8]) -> bool {
    let size = ImageReader::with_format(Cursor::new(jpeg), ImageFormat::Jpeg).into_dimensions();
    size.is_ok_and(|(width, height)| width.max(height) <= MOST_PIXELS)
}
