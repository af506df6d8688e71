//! What a vehicle's cameras have seen of its finds: of each track the best crop, and of each find a picture of it.
//!
//! Detections are assigned to tracks later than their image arrives, so the crops of the last frames wait for that. Images of
//! a camera whose detector is another program wait for its boxes, which name the same stamp, or boxes for their image.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use dragnet_proto::picture::{Picture, PictureFacts};
use dragnet_ros2::input::{DetectedBox, Image};
use dragnet_search::cell::Cell;
use dragnet_vehicle::pilot::{Assigned, Pilot};
use dragnet_vehicle::tracker::track::TrackId;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{self, FilterType};
use image::{ExtendedColorType, RgbImage};

/// The most bytes of images that wait for their boxes, about ten of 1920 x 1080 pixels.
const MOST_IMAGE_BYTES: usize = 64 << 20;
/// Largest difference between the stamps of an image and of its boxes, nanoseconds.
const SAME_NS: u64 = 50_000_000;
/// The most frames whose crops wait for their tracks.
const MOST_FRAMES: usize = 64;
/// The most crops of a frame, the largest ones.
const MOST_CROPS: usize = 4;
/// The longer side of a picture, pixels.
const SIDE_PIXELS: u32 = 320;
/// The part of a box that is shown around it on each side.
const MARGIN: f64 = 0.5;
/// Qualities of JPEG, 1 to 100, of which the first is taken that is small enough.
const JPEG_QUALITIES: [u8; 4] = [85, 70, 50, 30];

/// A part of an image with a box in its middle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crop {
    image: RgbImage,
    label: String,
    score: f32,
    quality: f32,
}

/// A crop by the number of its box in the frame.
pub(crate) type BoxCrop = (usize, Crop);

/// A frame with boxes.
struct Frame {
    camera: Arc<str>,
    time_ns: u64,
    /// Its boxes, as long as their image is not here.
    waiting: Option<Boxes>,
    /// The tracks of boxes that wait, by the number of the box.
    assigned: Vec<(usize, TrackId)>,
    crops: Vec<BoxCrop>,
}

impl Frame {
    fn new(camera: &Arc<str>, time_ns: u64) -> Self {
        let (waiting, assigned, crops) = (None, Vec::new(), Vec::new());
        Self { camera: Arc::clone(camera), time_ns, waiting, assigned, crops }
    }
}

/// Boxes of another program.
struct Boxes {
    stamp_unix_ns: i64,
    detected: Vec<DetectedBox>,
    /// Of the images that they refer to.
    size: Option<[u32; 2]>,
}

/// The best crop of a track.
struct Best {
    camera: Arc<str>,
    time_ns: u64,
    crop: Crop,
}

/// A picture of a find, by the vehicle's time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FindPicture {
    /// When it was taken, nanoseconds.
    pub(crate) time_ns: u64,
    pub(crate) cell: Cell,
    pub(crate) camera: String,
    pub(crate) label: String,
    pub(crate) score: f32,
    pub(crate) quality: f32,
    pub(crate) jpeg: Vec<u8>,
}

/// The pictures of a vehicle.
#[derive(Default)]
pub(super) struct Pictures {
    detected_elsewhere: BTreeSet<Arc<str>>,
    /// Of these the cameras whose boxes wait for images in vain.
    unmatched: BTreeSet<Arc<str>>,
    /// The oldest first.
    images: VecDeque<(Arc<str>, Image)>,
    /// The oldest first.
    frames: VecDeque<Frame>,
    by_track: BTreeMap<TrackId, Best>,
    /// Quality of the picture of each find.
    taken: BTreeMap<Cell, f32>,
}

impl Pictures {
    /// Pictures by cameras of which these have their images and another program's boxes.
    pub(super) fn new(detected_elsewhere: BTreeSet<Arc<str>>) -> Self {
        Self { detected_elsewhere, ..Self::default() }
    }

    /// Whether a camera's boxes come from another program, so that its images are for pictures alone.
    pub(super) fn are_for(&self, camera: &str) -> bool {
        self.detected_elsewhere.contains(camera)
    }

    /// An image of such a camera: for boxes that wait for it, or it waits for its boxes.
    pub(super) fn take_image(&mut self, camera: Arc<str>, image: Image) {
        let apart_ns = |waiting: &Boxes| waiting.stamp_unix_ns.abs_diff(image.stamp_unix_ns);
        let is_near = |frame: &&mut Frame| {
            frame.camera == camera
                && frame.waiting.as_ref().is_some_and(|waiting| apart_ns(waiting) <= SAME_NS)
        };
        let near = self.frames.iter_mut().filter(is_near);
        if let Some(frame) = near.min_by_key(|frame| frame.waiting.as_ref().map(apart_ns)) {
            self.unmatched.remove(&camera);
            let Some(Boxes { detected, size, .. }) = frame.waiting.take() else { return };
            frame.crops = crops(&image, &detected, size);
            // Meanwhile they may have got their tracks.
            let assigned = std::mem::take(&mut frame.assigned);
            let (camera, time_ns) = (Arc::clone(&frame.camera), frame.time_ns);
            for (detection, track) in assigned {
                self.assign(&Assigned { camera: camera.to_string(), time_ns, detection, track });
            }
            return;
        }
        self.images.push_back((camera, image));
        let bytes =
            |images: &VecDeque<(Arc<str>, Image)>| images.iter().map(|(_, it)| it.rgb.len()).sum::<usize>();
        while self.images.len() > 1 && bytes(&self.images) > MOST_IMAGE_BYTES {
            self.images.pop_front();
        }
    }

    /// An external detector's boxes: their image is here, or they wait for it. `size` is that of the images that boxes refer
    /// to, columns and rows, if it is known.
    pub(super) fn take_boxes(
        &mut self,
        camera: &Arc<str>,
        time_ns: u64,
        stamp_unix_ns: i64,
        boxes: &[DetectedBox],
        size: Option<[u32; 2]>,
    ) {
        if !self.are_for(camera) || boxes.is_empty() {
            return;
        }
        let apart_ns = |image: &Image| image.stamp_unix_ns.abs_diff(stamp_unix_ns);
        let of_camera = self.images.iter().filter(|(name, _)| name == camera).map(|(_, image)| image);
        let nearest =
            of_camera.min_by_key(|image| apart_ns(image)).filter(|image| apart_ns(image) <= SAME_NS);
        if let Some(image) = nearest {
            let crops = crops(image, boxes, size);
            self.unmatched.remove(camera);
            self.put(camera, time_ns, crops);
        } else {
            let waiting = Some(Boxes { stamp_unix_ns, detected: boxes.to_vec(), size });
            self.push(Frame { waiting, ..Frame::new(camera, time_ns) });
        }
        // Boxes come in the order of images: no earlier one is needed.
        self.images.retain(|(name, image)| name != camera || image.stamp_unix_ns >= stamp_unix_ns);
    }

    /// Crops wait for the tracks of their boxes.
    pub(super) fn put(&mut self, camera: &Arc<str>, time_ns: u64, crops: Vec<BoxCrop>) {
        if !crops.is_empty() {
            self.push(Frame { crops, ..Frame::new(camera, time_ns) });
        }
    }

    fn push(&mut self, frame: Frame) {
        if self.frames.len() == MOST_FRAMES
            && let Some(Frame { camera, waiting: Some(_), .. }) = self.frames.pop_front()
        {
            self.unmatched.insert(camera);
        }
        self.frames.push_back(frame);
    }

    /// Whether the boxes of a camera wait for images in vain.
    pub(super) fn lack(&self, camera: &str) -> bool {
        self.unmatched.contains(camera)
    }

    /// The pilot has handled an event: keeps the better crops of the tracks that it has.
    pub(super) fn follow(&mut self, pilot: &Pilot) {
        if !self.by_track.is_empty() {
            // Numbers of tracks begin anew after a jump of the vehicle's pose.
            let is_track = |id| pilot.tracks().iter().any(|track| track.id() == id);
            let is_find = |id| pilot.finds().any(|find| find.track == id);
            self.by_track.retain(|&id, _| is_track(id) || is_find(id));
        }
        if pilot.tracks().is_empty() {
            self.frames.iter_mut().for_each(|frame| frame.assigned.clear());
        }
        for assigned in pilot.assigned() {
            self.assign(assigned);
        }
    }

    fn assign(&mut self, Assigned { camera, time_ns, detection, track }: &Assigned) {
        let is_same = |frame: &&mut Frame| *frame.camera == **camera && frame.time_ns == *time_ns;
        let Some(frame) = self.frames.iter_mut().rfind(is_same) else { return };
        if frame.waiting.is_some() {
            frame.assigned.push((*detection, *track));
            return;
        }
        let Some(place) = frame.crops.iter().position(|(number, _)| number == detection) else { return };
        let (_, crop) = frame.crops.swap_remove(place);
        if self.by_track.get(track).is_none_or(|best| crop.quality > best.crop.quality) {
            let best = Best { camera: Arc::clone(&frame.camera), time_ns: *time_ns, crop };
            self.by_track.insert(*track, best);
        }
    }

    /// Pictures of finds that are new, or clearly better than before.
    pub(super) fn news(&mut self, pilot: &Pilot) -> Vec<FindPicture> {
        let mut news = Vec::new();
        for find in pilot.finds() {
            let Some(Best { camera, time_ns, crop }) = self.by_track.get(&find.track) else { continue };
            if self.taken.get(&find.cell).is_some_and(|&taken| crop.quality < PictureFacts::BETTER * taken) {
                continue;
            }
            self.taken.insert(find.cell, crop.quality);
            news.extend(jpeg(&crop.image).map(|jpeg| FindPicture {
                time_ns: *time_ns,
                cell: find.cell,
                camera: short(camera),
                label: crop.label.clone(),
                score: crop.score,
                quality: crop.quality,
                jpeg,
            }));
        }
        news
    }
}

/// The largest boxes of an image, each with its surroundings.
pub(crate) fn crops(image: &Image, boxes: &[DetectedBox], size: Option<[u32; 2]>) -> Vec<BoxCrop> {
    let own = [image.width_pixels, image.height_pixels];
    let [across, down] = size.unwrap_or(own);
    let scale = [f64::from(own[0]) / f64::from(across), f64::from(own[1]) / f64::from(down)];
    let area = |it: &DetectedBox| (it.right - it.left) * (it.bottom - it.top);
    let mut largest: Vec<(usize, &DetectedBox)> =
        boxes.iter().enumerate().filter(|(_, it)| area(it).is_finite() && area(it) > 0.0).collect();
    largest.sort_by(|(_, one), (_, other)| area(other).total_cmp(&area(one)));
    largest.truncate(MOST_CROPS);
    largest.into_iter().filter_map(|(number, it)| Some((number, crop(image, it, scale)?))).collect()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "within the image, whose sides are below 2^24; scores are 0 to 1"
)]
fn crop(image: &Image, detected: &DetectedBox, scale: [f64; 2]) -> Option<Crop> {
    let [width, height] = [image.width_pixels, image.height_pixels];
    let span = |from: f64, to: f64, scale: f64, most: u32| {
        let around = (to - from) * MARGIN;
        let [from, to] =
            [(from - around) * scale, (to + around) * scale].map(|it| it.clamp(0.0, f64::from(most)));
        let (from, to) = (from.floor() as u32, to.ceil() as u32);
        (to > from).then(|| (from, to - from))
    };
    let (left, columns) = span(detected.left, detected.right, scale[0], width)?;
    let (top, rows) = span(detected.top, detected.bottom, scale[1], height)?;
    let row = |row: u32| {
        let first = (row as usize * width as usize + left as usize) * 3;
        image.rgb.get(first..first + columns as usize * 3)
    };
    let mut rgb = Vec::with_capacity(columns as usize * rows as usize * 3);
    for number in top..top + rows {
        rgb.extend_from_slice(row(number)?);
    }
    let score = detected.hypothesis.as_ref().map_or(1.0, |hypothesis| hypothesis.score as f32);
    let area = (detected.right - detected.left) * scale[0] * (detected.bottom - detected.top) * scale[1];
    Some(Crop {
        image: reduced(RgbImage::from_raw(columns, rows, rgb)?),
        label: detected.hypothesis.as_ref().map_or_else(String::new, |hypothesis| short(&hypothesis.class)),
        score,
        quality: area.sqrt() as f32 * score,
    })
}

/// A large image is made smaller.
fn reduced(image: RgbImage) -> RgbImage {
    let (width, height) = image.dimensions();
    let side = width.max(height);
    if side <= SIDE_PIXELS {
        return image;
    }
    let reduce = |pixels: u32| (pixels * SIDE_PIXELS / side).max(1);
    imageops::resize(&image, reduce(width), reduce(height), FilterType::Triangle)
}

/// The image as a file that is small enough.
fn jpeg(image: &RgbImage) -> Option<Vec<u8>> {
    let (width, height) = image.dimensions();
    let small_enough = JPEG_QUALITIES.into_iter().find_map(|quality| {
        let mut file = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut file, quality);
        encoder.encode(image, width, height, ExtendedColorType::Rgb8).ok()?;
        (file.len() <= Picture::MAX_BYTES).then_some(file)
    });
    // Noise: nothing else of this size takes as many bytes.
    small_enough.or_else(|| {
        let half = (width > 1 && height > 1)
            .then(|| imageops::resize(image, width / 2, height / 2, FilterType::Triangle));
        half.and_then(|half| jpeg(&half))
    })
}

/// The beginning of a name, as long as a picture's may be.
fn short(name: &str) -> String {
    name[..name.floor_char_boundary(PictureFacts::MAX_NAME_BYTES)].to_owned()
}

#[cfg(test)]
mod tests {
    use dragnet_ros2::input::Hypothesis;
    use image::ImageReader;

    use super::*;

    /// Gray, with a red figure at columns 100 to 140 and rows 60 to 120.
    fn image(stamp_unix_ns: i64) -> Image {
        let picture = RgbImage::from_fn(640, 480, |column, row| {
            let is_figure = (100..140).contains(&column) && (60..120).contains(&row);
            image::Rgb(if is_figure { [220, 30, 20] } else { [110, 110, 110] })
        });
        Image {
            stamp_unix_ns,
            frame: String::new(),
            width_pixels: 640,
            height_pixels: 480,
            rgb: picture.into_raw(),
        }
    }

    fn figure(score: f64) -> DetectedBox {
        let hypothesis = Some(Hypothesis { class: "person".to_owned(), score });
        DetectedBox { left: 100.0, top: 60.0, right: 140.0, bottom: 120.0, hypothesis }
    }

    fn decoded(file: &[u8]) -> RgbImage {
        let reader = ImageReader::with_format(std::io::Cursor::new(file), image::ImageFormat::Jpeg);
        reader.decode().unwrap().into_rgb8()
    }

    #[test]
    fn a_crop_shows_its_box_in_the_middle_with_its_surroundings() {
        let crops = crops(&image(0), &[figure(0.5)], None);
        let [(0, crop)] = crops.as_slice() else { panic!("{crops:?}") };
        assert_eq!((crop.label.as_str(), crop.score), ("person", 0.5));
        assert!((crop.quality - 0.5 * (40.0_f32 * 60.0).sqrt()).abs() < 1e-3, "{}", crop.quality);
        let shown = decoded(&jpeg(&crop.image).unwrap());
        assert_eq!(shown.dimensions(), (80, 120));
        let is_red = |column, row| shown.get_pixel(column, row).0[0] > 180;
        assert!(is_red(40, 60) && is_red(25, 35) && !is_red(5, 60) && !is_red(40, 10));
    }

    #[test]
    fn boxes_of_a_smaller_image_are_scaled_and_those_outside_are_left_out() {
        let half = DetectedBox { left: 50.0, top: 30.0, right: 70.0, bottom: 60.0, hypothesis: None };
        let outside = DetectedBox { left: 900.0, top: 30.0, right: 990.0, bottom: 60.0, hypothesis: None };
        let no_number = DetectedBox { left: f64::NAN, ..half.clone() };
        let crops = crops(&image(0), &[no_number, outside, half], Some([320, 240]));
        let [(2, crop)] = crops.as_slice() else { panic!("{crops:?}") };
        assert_eq!(crop.image.dimensions(), (80, 120));
        assert_eq!((crop.label.as_str(), crop.score), ("", 1.0));
    }

    #[test]
    fn the_largest_boxes_of_an_image_are_shown() {
        let grown = |by: u32| DetectedBox { right: 140.0 + f64::from(by), ..figure(0.9) };
        let boxes: Vec<DetectedBox> = (0..9).map(grown).collect();
        let numbers: Vec<usize> = crops(&image(0), &boxes, None).iter().map(|(number, _)| *number).collect();
        assert_eq!(numbers, [8, 7, 6, 5]);
    }

    /// Boxes with these stamps and images in this order; returns the number of crops of each frame.
    fn matched(events: &[(i64, bool)]) -> Vec<usize> {
        let (front, back): (Arc<str>, Arc<str>) = ("front".into(), "back".into());
        let mut pictures = Pictures::new([Arc::clone(&front), Arc::clone(&back)].into());
        for &(milliseconds, is_image) in events {
            let stamp = milliseconds * 1_000_000;
            if is_image {
                pictures.take_image(Arc::clone(&back), image(stamp));
                pictures.take_image(Arc::clone(&front), image(stamp));
            } else {
                pictures.take_boxes(&front, stamp.unsigned_abs(), stamp, &[figure(0.9)], None);
            }
        }
        pictures.frames.iter().map(|frame| frame.crops.len()).collect()
    }

    #[test]
    fn boxes_meet_the_image_of_their_stamp_whichever_comes_first() {
        let (boxes, image) = (|at| (at, false), |at| (at, true));
        assert_eq!(matched(&[image(100), image(200), image(300), boxes(210)]), [1]);
        assert_eq!(matched(&[boxes(210), image(100), image(200), image(300)]), [1]);
        assert_eq!(matched(&[boxes(100), boxes(200), image(200), image(100)]), [1, 1]);
        assert_eq!(matched(&[image(100), boxes(20), boxes(160)]), [0, 0], "too early and too late");
        assert_eq!(
            matched(&[image(100), image(200), boxes(200), boxes(100)]),
            [1, 0],
            "earlier images are gone"
        );
    }

    #[test]
    fn boxes_that_have_their_tracks_still_get_their_image() {
        let front: Arc<str> = "front".into();
        let mut pictures = Pictures::new([Arc::clone(&front)].into());
        pictures.take_boxes(&front, 7, 100, &[figure(0.9)], None);
        let track = TrackId(3);
        pictures.assign(&Assigned { camera: "front".to_owned(), time_ns: 7, detection: 0, track });
        assert!(pictures.by_track.is_empty());
        pictures.take_image(Arc::clone(&front), image(100));
        assert_eq!(pictures.by_track.keys().collect::<Vec<_>>(), [&track]);
        assert!(pictures.images.is_empty(), "it waits no more");
    }

    #[test]
    fn boxes_without_images_are_noticed() {
        let front: Arc<str> = "front".into();
        let mut pictures = Pictures::new([Arc::clone(&front)].into());
        for time_ns in 0..=MOST_FRAMES as u64 {
            assert!(!pictures.lack("front"));
            pictures.take_boxes(&front, time_ns, time_ns.cast_signed(), &[figure(0.9)], None);
        }
        assert!(pictures.lack("front"));
        pictures.take_image(front, image(60));
        assert!(!pictures.lack("front"));
        pictures.take_boxes(&"left".into(), 5, 5, &[figure(0.9)], None);
        assert_eq!(pictures.frames.len(), MOST_FRAMES, "a camera without images");
    }

    #[test]
    fn a_picture_is_small_enough_whatever_it_shows() {
        let noise = RgbImage::from_fn(2000, 1500, |column, row| {
            let hash = (u64::from(column) << 32 | u64::from(row)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            image::Rgb([hash >> 40, hash >> 48, hash >> 56].map(|bits| bits.to_le_bytes()[0]))
        });
        let large = Image {
            stamp_unix_ns: 0,
            frame: String::new(),
            width_pixels: 2000,
            height_pixels: 1500,
            rgb: noise.clone().into_raw(),
        };
        let whole = DetectedBox { left: 0.0, top: 0.0, right: 2000.0, bottom: 1500.0, hypothesis: None };
        let crops = crops(&large, &[whole], None);
        assert_eq!(crops[0].1.image.dimensions(), (320, 240));
        let part = imageops::crop_imm(&noise, 0, 0, 640, 640).to_image();
        let file = jpeg(&part).unwrap();
        assert!(file.len() <= Picture::MAX_BYTES && decoded(&file).width() >= 160, "{}", file.len());
    }

    #[test]
    fn a_long_name_is_cut_between_letters() {
        assert_eq!(short("person"), "person");
        assert_eq!(short(&"ä".repeat(40)), "ä".repeat(32));
    }
}
