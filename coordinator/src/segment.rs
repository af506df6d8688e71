//! How thoroughly each segment was searched: its part of the probability before and now, the probability of detection by
//! what was actually observed, and the effort of the robots in it.
//!
//! A segment is an area, region or last known position of the map; one more is the whole search. Exports, `inspect` and the
//! live page show these numbers, all from [`Segments::table`].
//!
//! With the track length `L` of the robots in a segment of the area `A`, and the sweep width `W` of
//! [`dragnet_search::sweep`] at the segment's mean prior, the effort is `Z = W L` and the coverage `C = Z / A` (Koopman,
//! Search and Screening, 1980; IAMSAR Manual, volume II, chapter 4, which calls `Z` the search effort). They are what was
//! planned and driven; the probability of detection follows from the readings themselves, and counts what others have
//! searched too.

use std::path::Path;

use dragnet_scenario::map_file::{Area, Earth, Georeference, Purpose};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::sensor::Sensor;
use dragnet_search::subjects::{SubjectPosterior, Subjects};
use dragnet_search::sweep::sweep_width_cells;
use dragnet_search::terrain::Terrain;
use serde::Serialize;

use crate::fold::MissionFold;
use crate::playback::Playback;

/// The name of the row of the whole search.
pub const IN_ALL: &str = "in all";

/// The segments of a mission, and what their numbers follow from.
#[derive(Clone, Debug)]
pub struct Segments {
    areas: Vec<Area>,
    frame: Option<Georeference>,
    /// Probability that a subject is in the area at all, before the search; 1 if their number is not known.
    inside: f64,
    /// Total number of expected objects.
    expected_objects: f64,
    detection_threshold: f64,
    /// The sensor of each robot, by [`RobotId::index`]; empty if they are unknown.
    sensors: Vec<Sensor>,
    /// Of each area the share of each searched cell that counts, if any does.
    shares: Vec<Option<Vec<(Cell, f64)>>>,
}

/// How thoroughly a segment was searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Number of its searched cells.
    pub cells: usize,
    /// Their area, as far as they are the segment's, square meters; `None` for a place, which has no border.
    pub area_square_meters: Option<f64>,
    /// Probability of area: that an object is here, 0 to 1. As drawn; for a search area by the prior.
    pub poa: f64,
    /// Probability of detection: the mean over its cells, weighted by the probability that the area's object is there.
    pub pod: f64,
    /// Probability that a subject is inside now, 0 to 1, if their number is known; `None` for a place, which has no
    /// border.
    pub now: Option<f64>,
    /// The effort of the robots in it; `None` for a place, and in recordings that do not say what their sensors are.
    pub effort: Option<Effort>,
}

/// The effort of robots in a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Length of their tracks in its searched cells, `L`, meters.
    pub track_meters: f64,
    /// Sweep width `W`, meters: of unlike sensors the mean, weighted by the length of their tracks.
    pub sweep_width_meters: f64,
}

/// The numbers of a segment, as they are written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SegmentRow {
    /// Its name.
    pub name: String,
    /// Its kind, as map files name it; [`IN_ALL`] for the whole search.
    pub kind: &'static str,
    /// Number of its searched cells.
    pub cells: usize,
    /// See [`Coverage::area_square_meters`].
    pub area_square_meters: Option<f64>,
    /// Probability of area before the search.
    pub poa: f64,
    /// See [`Coverage::now`].
    pub poa_now: Option<f64>,
    /// Probability of detection.
    pub pod: f64,
    /// Probability of success, `POA POD`.
    pub pos: f64,
    /// Sweep width `W`, meters.
    pub sweep_width_meters: Option<f64>,
    /// Track length `L`, meters.
    pub track_meters: Option<f64>,
    /// Effort `Z = W L`: the area that was effectively swept, square meters.
    pub effort_square_meters: Option<f64>,
    /// Coverage `C = Z / A`.
    pub coverage: Option<f64>,
}

/// The segments at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Of each area in their order; `None` if robots cannot enter it or none of its cells is searched.
    pub areas: Vec<Option<Coverage>>,
    /// The whole search.
    pub total: Coverage,
}

impl Coverage {
    /// Probability of success, `POA POD`.
    #[must_use]
    pub fn pos(&self) -> f64 {
        self.poa * self.pod
    }

    /// Its numbers as they are written.
    #[must_use]
    pub fn row(&self, name: &str, kind: &'static str) -> SegmentRow {
        let Self { cells, area_square_meters, poa, pod, now, effort } = *self;
        let swept = effort.map(|effort| effort.square_meters());
        SegmentRow {
            name: name.to_owned(),
            kind,
            cells,
            area_square_meters,
            poa,
            poa_now: now,
            pod,
            pos: self.pos(),
            sweep_width_meters: effort.map(|effort| effort.sweep_width_meters),
            track_meters: effort.map(|effort| effort.track_meters),
            effort_square_meters: swept,
            coverage: swept.zip(area_square_meters).map(|(swept, area)| swept / area),
        }
    }
}

impl Effort {
    /// The area that was effectively swept, `Z = W L`, square meters.
    #[must_use]
    pub fn square_meters(&self) -> f64 {
        self.track_meters * self.sweep_width_meters
    }
}

impl Segments {
    /// The segments of a mission, of which the position on the earth and the robots' sensors may be unknown.
    #[must_use]
    pub fn new(
        earth: Option<&Earth>,
        fold: &MissionFold,
        subjects: Option<Subjects>,
        detection_threshold: f64,
        sensors: Vec<Sensor>,
    ) -> Self {
        let by_prior =
            || fold.terrain().searched_cells().map(|cell| fold.belief().prior_probability(cell)).sum();
        let expected = || earth.map_or_else(by_prior, |it| it.expected_objects);
        let mut segments = Self {
            areas: earth.map(|earth| earth.areas.clone()).unwrap_or_default(),
            frame: earth.map(|earth| earth.frame),
            inside: subjects.map_or(1.0, |subjects| 1.0 - subjects.rest_of_world()),
            expected_objects: subjects.map_or_else(expected, |subjects| f64::from(subjects.number())),
            detection_threshold,
            sensors,
            shares: Vec::new(),
        };
        segments.cover(fold.terrain());
        segments
    }

    /// The map has changed: cells are searched from now on.
    pub fn cover(&mut self, terrain: &Terrain) {
        let Some(frame) = self.frame else { return };
        self.shares = self.areas.iter().map(|area| shares(area, &frame, terrain)).collect();
        let mut searched = vec![0.0; terrain.grid().cell_count()];
        let is_search = |area: &Area| matches!(area.purpose, Purpose::Search(_));
        for (_, shares) in self.areas.iter().zip(&self.shares).filter(|(area, _)| is_search(area)) {
            shares.iter().flatten().for_each(|(cell, share)| searched[cell.index()] += share);
        }
        // A cell that several search areas touch belongs to each by the share that it covers.
        for (_, shares) in self.areas.iter().zip(&mut self.shares).filter(|(area, _)| is_search(area)) {
            shares.iter_mut().flatten().for_each(|(cell, share)| *share /= searched[cell.index()]);
        }
    }

    /// The segments after the records of a fold, with the probability of detection of each cell (shape `[cells]`, see
    /// [`MissionFold::probability_of_detection`]) and the posterior of the subjects, if their number is known.
    #[must_use]
    pub fn table(&self, fold: &MissionFold, pod: &[f64], subject: Option<&SubjectPosterior>) -> Table {
        let sum = Sum { segments: self, fold, pod, now: subject, tracks: self.tracks(fold) };
        let area = |(area, shares): (&Area, &Option<Vec<(Cell, f64)>>)| {
            let shares = shares.as_deref()?;
            Some(match area.purpose.poa() {
                Some(poa) => {
                    sum.region(poa * self.inside, matches!(area.purpose, Purpose::Prior { .. }), shares)
                }
                None => sum.cells(shares.iter().copied()),
            })
        };
        Table {
            areas: self.areas.iter().zip(&self.shares).map(area).collect(),
            total: sum.cells(fold.terrain().searched_cells().map(|cell| (cell, 1.0))),
        }
    }

    /// The numbers of all segments as they are written, those of the whole search last.
    #[must_use]
    pub fn rows(&self, table: &Table) -> Vec<SegmentRow> {
        let areas = self.areas.iter().zip(&table.areas);
        areas
            .filter_map(|(area, coverage)| Some(coverage.as_ref()?.row(&area.name, area.purpose.word())))
            .chain([table.total.row(IN_ALL, IN_ALL)])
            .collect()
    }

    /// The tracks of robots of each kind of sensor: length in each cell, cells, shape `[cells]`.
    fn tracks(&self, fold: &MissionFold) -> Vec<(&Sensor, Vec<f64>)> {
        let cells = fold.terrain().grid().cell_count();
        let mut tracks: Vec<(&Sensor, Vec<f64>)> = Vec::new();
        let team = u16::try_from(self.sensors.len()).unwrap_or(u16::MAX);
        for (robot, sensor) in RobotId::first(team).zip(&self.sensors) {
            let known = tracks.iter().position(|(other, _)| *other == sensor);
            let index = known.unwrap_or_else(|| {
                tracks.push((sensor, vec![0.0; cells]));
                tracks.len() - 1
            });
            for (cell, length) in fold.visits().track_cells(robot) {
                tracks[index].1[cell.index()] += length;
            }
        }
        tracks
    }
}

/// The numbers of all segments of a recorded mission at a time, or at its end.
#[must_use]
pub fn rows_of(playback: &Playback, until: Option<MissionTime>) -> Vec<SegmentRow> {
    let mut fold = MissionFold::of(playback);
    let until = until.unwrap_or_else(|| playback.end());
    for (_, record) in playback.records.iter().take_while(|(time, _)| *time <= until) {
        fold.take(record);
    }
    let (subjects, threshold) = (playback.subjects(), playback.detection_threshold());
    let sensors = playback.sensors().unwrap_or_default();
    let segments = Segments::new(playback.earth.as_ref(), &fold, subjects, threshold, sensors);
    let pod = fold.probabilities_of_detection(threshold);
    let subject = subjects.map(|it| it.posterior(fold.belief()));
    segments.rows(&segments.table(&fold, &pod, subject.as_ref()))
}

/// Sums over cells.
struct Sum<'a> {
    segments: &'a Segments,
    fold: &'a MissionFold,
    pod: &'a [f64],
    /// Posterior of the subjects.
    now: Option<&'a SubjectPosterior>,
    tracks: Vec<(&'a Sensor, Vec<f64>)>,
}

impl Sum<'_> {
    /// A region or place with a probability of area of its own, and the share of each of its cells.
    fn region(&self, poa: f64, has_border: bool, shares: &[(Cell, f64)]) -> Coverage {
        let whole: f64 = shares.iter().map(|(_, share)| share).sum();
        let detected: f64 = shares.iter().map(|(cell, share)| share * self.pod[cell.index()]).sum();
        let by_cells = has_border.then(|| self.cells(shares.iter().copied()));
        Coverage {
            cells: shares.len(),
            area_square_meters: by_cells.and_then(|it| it.area_square_meters),
            poa,
            pod: detected / whole,
            now: by_cells.and_then(|it| it.now),
            effort: by_cells.and_then(|it| it.effort),
        }
    }

    /// Cells with the share of each that counts.
    fn cells(&self, cells: impl Iterator<Item = (Cell, f64)>) -> Coverage {
        let (mut count, mut whole, mut mass, mut detected, mut now) = (0, 0.0, 0.0, 0.0, 0.0);
        let mut tracks = vec![0.0; self.tracks.len()];
        for (cell, share) in cells {
            let held = share * self.fold.belief().prior_probability(cell);
            count += 1;
            whole += share;
            mass += held;
            detected += held * self.pod[cell.index()];
            now += self.now.map_or(0.0, |now| share * now.of_each(cell));
            for (length, (_, lengths)) in tracks.iter_mut().zip(&self.tracks) {
                *length += share * lengths[cell.index()];
            }
        }
        let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
        let edge = self.fold.terrain().cell_meters();
        Coverage {
            cells: count,
            area_square_meters: Some(whole * edge * edge),
            poa: share(mass, self.segments.expected_objects),
            pod: share(detected, mass),
            now: self.now.map(|_| now),
            effort: self.effort(&tracks, share(mass, whole)),
        }
    }

    /// The effort of tracks of these lengths, cells, in cells of this mean prior probability.
    fn effort(&self, lengths: &[f64], prior: f64) -> Option<Effort> {
        let (edge, log_odds_nats) = (self.fold.terrain().cell_meters(), (prior / (1.0 - prior)).ln());
        let width =
            |sensor| edge * sweep_width_cells(sensor, log_odds_nats, self.segments.detection_threshold);
        let widths: Vec<f64> = self.tracks.iter().map(|&(sensor, _)| width(sensor)).collect();
        let length: f64 = lengths.iter().sum();
        let swept: f64 = lengths.iter().zip(&widths).map(|(length, width)| length * width).sum();
        let mean = widths.iter().sum::<f64>() / widths.len() as f64;
        let sweep_width_meters = if length > 0.0 { swept / length } else { mean };
        (!widths.is_empty()).then_some(Effort { track_meters: length * edge, sweep_width_meters })
    }
}

/// The share of each searched cell that an area covers, or for a place its weight there; all above 0.
fn shares(area: &Area, frame: &Georeference, terrain: &Terrain) -> Option<Vec<(Cell, f64)>> {
    if matches!(area.purpose, Purpose::NoGo(..)) {
        return None;
    }
    area.weights(Path::new("areas.geojson"), frame, terrain).ok().map(|weights| weights.shares)
}
