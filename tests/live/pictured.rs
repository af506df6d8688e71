//! A robot that finds an object and has a picture of it, for the page in headless Chromium.

use std::io::Cursor;
use std::sync::Arc;

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::message::{Audience, Message};
use dragnet_proto::picture::{Picture, PictureFacts, PictureRequest};
use dragnet_runtime::link::{Incoming, Link};
use dragnet_runtime::session::{Endpoints, open};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::evidence::Reading;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, Origin, RobotId};
use image::{ImageFormat, Rgb, RgbImage};
use zenoh::Wait;

/// Number of its observations, all in the south-western cell: enough for a find.
const OBSERVATIONS: u64 = 12;

/// A person in red on a meadow.
fn picture(scenario: &Scenario, quality: f32) -> Picture {
    let is_person = |column: u32, row: u32| {
        let is_head = column.abs_diff(60).pow(2) + row.abs_diff(50).pow(2) < 150;
        is_head || (column.abs_diff(60) < 18 && (64..130).contains(&row))
    };
    let drawn = RgbImage::from_fn(120, 160, |column, row| {
        Rgb(if is_person(column, row) { [200, 40, 30] } else { [60, 110, 50] })
    });
    let mut jpeg = Cursor::new(Vec::new());
    drawn.write_to(&mut jpeg, ImageFormat::Jpeg).unwrap();
    let facts = PictureFacts {
        robot: RobotId::FIRST,
        time_ns: 1_500_000_000,
        cell: scenario.terrain().grid().cell_numbered(0).unwrap(),
        camera: "front".to_owned(),
        label: "person".to_owned(),
        score: 0.91,
        quality,
    };
    Picture { facts, jpeg: jpeg.into_inner().into() }
}

/// Robot 1 of the coordinator's mission `hall`, which finds the object once the operator has given an order.
pub(crate) async fn find(scenario: Scenario, coordinator: String) {
    let endpoints = Endpoints { connect: vec![coordinator], ..Endpoints::default() };
    let session = open(&endpoints).await.unwrap();
    let (codec, robot) = (Codec::of(&scenario), RobotId::FIRST);
    let picture = picture(&scenario, 80.0);
    let (grid, key) = (scenario.terrain().grid(), "dragnet/hall/robots/1/picture");
    let answer = move |query: zenoh::query::Query| {
        let request = PictureRequest::parse(query.parameters().as_str(), grid).unwrap();
        if request.cell == picture.facts.cell {
            let part = picture.part(request.first, request.most);
            query.reply(key, convert::encode_picture(&part)).wait().unwrap();
        }
    };
    let _pictures = session.declare_queryable(key).callback(answer).await.unwrap();
    let participant = Participant::Robot(robot);
    let mut link = Link::join(session, "hall".parse().unwrap(), participant, codec).await.unwrap();
    link.announce().await.unwrap();
    // The page is open once its operator has given an order.
    let is_order = |received: &Incoming| matches!(received, Incoming::Message { message: Message::MissionStatus(status), .. } if status.directive.number > 0);
    while !is_order(&link.receive().await.unwrap()) {}
    let cell = grid.cell_numbered(0).unwrap();
    let variance = scenario.sensor().variance(0);
    let (east, north) = scenario.terrain().center_meters(cell);
    let position = ObjectPosition::new(cell, [east, north + 1.0], [0.01, 0.0, 0.04]);
    for sequence in 0..OBSERVATIONS {
        let observation = Observation {
            origin: Origin::first(robot),
            sequence,
            time_ns: 1_000_000_000,
            from: cell,
            readings: vec![Reading { cell, value: 1.0, variance }],
            // North of the middle of its cell.
            positions: position.filter(|_| sequence == 0).into_iter().collect(),
        };
        let message = Message::Observation(Arc::new(observation));
        link.publish(sequence, Audience::All, &message).await.unwrap();
    }
    // Until the test ends.
    while link.receive().await.is_some() {}
}
