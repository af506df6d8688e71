use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use dragnet_coordinator::mission::Record;
use dragnet_coordinator::node::Listener;
use dragnet_coordinator::record::Header;
use dragnet_coordinator::record::encoder::telling;
use dragnet_scenario::map_file::MapOrigin;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::observation::{Observation, Origin, RobotId};
use dragnet_search::terrain::Terrain;

use super::*;
use crate::foxglove::feed::Sent;
use crate::foxglove::protocol::{Level, Subscription};

fn header(side: usize) -> Header {
    let rows = vec![".".repeat(side); side].join("\n");
    let terrain = Arc::new(Terrain::from_ascii(&rows, 5.0).unwrap());
    Header {
        start_unix_ns: 1_000,
        prior: Belief::uniform(&terrain, 0.5).unwrap(),
        terrain,
        origin: MapOrigin::default(),
        scenario: String::new(),
        earth: None,
        run: BTreeMap::new(),
    }
}

/// A mission that has begun.
struct Told {
    header: Header,
    feed: Arc<Mutex<Feed>>,
    listener: Listener,
    now: MissionTime,
}

impl Told {
    fn new(side: usize) -> Self {
        let (header, feed) = (header(side), Arc::new(Mutex::new(Feed::default())));
        let put = Arc::clone(&feed);
        let listener = telling(&header, Box::new(move |message| put.lock().unwrap().put(message)));
        Self { header, feed, listener, now: MissionTime::START }
    }

    /// The next record, a second later.
    fn tell(&mut self, record: &Record) {
        self.now = self.now + Duration::from_secs(1);
        (self.listener)(self.now, record);
    }

    fn pose(&mut self, robot: RobotId, cell: u32) {
        let cell = self.header.terrain.grid().cell_numbered(cell).unwrap();
        self.tell(&Record::Pose { robot, cell, time: self.now });
    }

    fn belief(&mut self, probability: f64) {
        self.tell(&Record::Belief(Arc::new(Belief::uniform(&self.header.terrain, probability).unwrap())));
    }

    fn observation(&mut self, sequence: u64) {
        let from = self.header.terrain.grid().cell_numbered(0).unwrap();
        let (origin, time_ns) = (Origin::first(RobotId::FIRST), self.now.0);
        let observation =
            Observation { origin, sequence, time_ns, from, readings: Vec::new(), positions: Box::default() };
        self.tell(&Record::Observation(Arc::new(observation)));
    }

    fn feed(&self) -> MutexGuard<'_, Feed> {
        self.feed.lock().unwrap()
    }
}

/// A client, and the topics that were advertised to it, by number.
struct Watched {
    client: Client,
    topics: Vec<String>,
}

impl Watched {
    fn new(feed: &Feed) -> Self {
        let (client, hello) = Client::new("now", feed);
        let mut watched = Self { client, topics: Vec::new() };
        assert!(matches!(hello[0], Outgoing::Hello { .. }), "{hello:?}");
        watched.learn(&hello);
        watched
    }

    fn learn(&mut self, messages: &[Outgoing]) {
        for message in messages {
            if let Outgoing::Advertise { first, topics } = message {
                assert_eq!(*first as usize, self.topics.len(), "no topic twice, and none left out");
                self.topics.extend(topics.iter().map(|topic| topic.topic.clone()));
            }
        }
    }

    /// Subscribes to all topics; the number of a subscription is that of its topic and 100.
    fn subscribe(&mut self, feed: &Feed) {
        let ids = 0..u32::try_from(self.topics.len()).unwrap();
        let subscriptions = ids.map(|channel_id| Subscription { id: channel_id + 100, channel_id }).collect();
        assert_eq!(self.client.take(Request::Subscribe { subscriptions }, feed), []);
    }

    /// Everything that it gets until it has everything.
    fn all(&mut self, feed: &Feed) -> Vec<Outgoing> {
        let mut all = Vec::new();
        loop {
            let next = self.client.next(feed);
            self.learn(&next);
            if next.is_empty() {
                return all;
            }
            all.extend(next);
        }
    }

    /// The messages among all that it gets, each with its topic.
    fn messages(&mut self, feed: &Feed) -> Vec<(String, Sent)> {
        let messages = self.all(feed).into_iter().filter_map(|message| match message {
            Outgoing::Data(id, sent) => Some((id, sent)),
            _ => None,
        });
        let messages: Vec<(u32, Sent)> = messages.collect();
        let named = |(id, sent): (u32, Sent)| {
            assert_eq!(id, sent.channel + 100);
            (self.topics[sent.channel as usize].clone(), sent)
        };
        messages.into_iter().map(named).collect()
    }
}

const SECOND: RobotId = RobotId::new(2).unwrap();

fn topics(messages: &[(String, Sent)]) -> Vec<&str> {
    messages.iter().map(|(topic, _)| topic.as_str()).collect()
}

#[test]
fn a_client_that_comes_late_gets_the_newest_of_each_state_and_no_event() {
    let mut told = Told::new(4);
    told.pose(RobotId::FIRST, 0);
    told.pose(SECOND, 1);
    told.observation(0);
    told.belief(0.9);
    told.pose(RobotId::FIRST, 2);
    let mut watched = Watched::new(&told.feed());
    watched.subscribe(&told.feed());
    let messages = watched.messages(&told.feed());
    assert_eq!(
        topics(&messages),
        ["/map", "/belief", "/belief/probability", "/robots/1/pose", "/tf", "/tf", "/robots/2/pose"],
        "a transform of each robot, and not the observation"
    );
    let seconds: Vec<u64> = messages.iter().map(|(_, sent)| sent.time_ns / 1_000_000_000).collect();
    assert_eq!(seconds, [0, 4, 4, 5, 5, 2, 2]);
    // Then each message, once.
    assert_eq!(watched.messages(&told.feed()), []);
    told.observation(1);
    told.pose(SECOND, 3);
    assert_eq!(topics(&watched.messages(&told.feed())), ["/robots/1/observation", "/robots/2/pose", "/tf"]);
}

#[test]
fn topics_appear_with_their_first_message() {
    let mut told = Told::new(4);
    let mut watched = Watched::new(&told.feed());
    assert_eq!(watched.topics, ["/map", "/belief", "/belief/probability"]);
    watched.subscribe(&told.feed());
    watched.messages(&told.feed());
    told.pose(SECOND, 3);
    assert_eq!(watched.messages(&told.feed()), [], "it has not subscribed to them");
    assert_eq!(watched.topics[3..], ["/robots/2/pose", "/tf"]);
}

#[test]
fn time_is_sent_before_what_happens_then_and_never_goes_back() {
    let mut told = Told::new(4);
    told.pose(RobotId::FIRST, 0);
    let (mut client, hello) = Client::new("now", &told.feed());
    assert_eq!(hello[1], Outgoing::Time(1_000_001_000));
    let subscriptions = vec![Subscription { id: 7, channel_id: 0 }, Subscription { id: 8, channel_id: 3 }];
    client.take(Request::Subscribe { subscriptions }, &told.feed());
    let next = client.next(&told.feed());
    assert!(matches!(&next[..], [Outgoing::Data(7, map), Outgoing::Data(8, _)] if map.time_ns == 1_000));
    told.pose(RobotId::FIRST, 1);
    let next = client.next(&told.feed());
    assert!(matches!(&next[..], [Outgoing::Time(2_000_001_000), Outgoing::Data(8, _)]), "{next:?}");
}

#[test]
fn a_client_that_is_too_slow_goes_on_with_the_newest_states() {
    let mut told = Told::new(1000);
    told.pose(SECOND, 3);
    let mut watched = Watched::new(&told.feed());
    watched.subscribe(&told.feed());
    assert_eq!(watched.messages(&told.feed()).len(), 5);
    // It gets nothing while beliefs of 5 MB pass.
    told.pose(SECOND, 4);
    told.observation(0);
    (1..=8).for_each(|tenths| told.belief(f64::from(tenths) / 10.0));
    assert!(told.feed().since(5).is_none(), "there were too many");
    let all = watched.all(&told.feed());
    let is_warning =
        |it: &Outgoing| matches!(it, Outgoing::Status(Level::Warning, why) if why.contains("too slow"));
    assert_eq!(all.iter().filter(|it| is_warning(it)).count(), 1, "once");
    let states: Vec<u64> = all
        .iter()
        .filter_map(|message| match message {
            Outgoing::Data(_, sent) => Some(sent.time_ns / 1_000_000_000),
            _ => None,
        })
        .collect();
    assert_eq!(states, [0, 11, 11, 2, 2], "the newest map, beliefs, pose and transform");
    // From then on it gets everything again.
    told.pose(SECOND, 5);
    told.pose(SECOND, 6);
    assert_eq!(watched.messages(&told.feed()).len(), 4);
}

#[test]
fn only_subscriptions_are_served() {
    for garbage in
        ["", "x", "{}", "[]", "null", "{\"op\":\"subscribe\"}", "{\"op\":\"advertise\",\"channels\":[]}"]
    {
        assert_eq!(Request::read(garbage), None, "{garbage}");
    }
    let ask = |text: &str| Request::read(text).unwrap();
    let told = Told::new(4);
    let mut client = Client::new("now", &told.feed()).0;
    let mut refused = |text: &str, reason: &str| {
        let answer = client.take(ask(text), &told.feed());
        let is_so = match (&answer[..], reason) {
            ([], "") => true,
            ([Outgoing::Status(Level::Error, why)], reason) => !reason.is_empty() && why.contains(reason),
            _ => false,
        };
        assert!(is_so, "{text}: {answer:?}");
    };
    let subscribe = |id: u32, channel: u32| {
        format!("{{\"op\":\"subscribe\",\"subscriptions\":[{{\"id\":{id},\"channelId\":{channel}}}]}}")
    };
    refused(&subscribe(5, 3), "there is no channel 3");
    refused(&subscribe(5, 1), "");
    refused(&subscribe(6, 1), "channel 1 is subscribed to already");
    refused(&subscribe(5, 2), "subscription 5 is in use");
    refused("{\"op\":\"unsubscribe\",\"subscriptionIds\":[5,77]}", "");
    refused(&subscribe(5, 2), "");
    let next = client.next(&told.feed());
    assert!(matches!(&next[..], [Outgoing::Data(5, sent)] if sent.channel == 2), "{next:?}");
}

#[test]
fn messages_are_those_of_the_protocol() {
    let text = |outgoing: Outgoing| match Message::from(outgoing) {
        Message::Text(text) => serde_json::from_str::<serde_json::Value>(&text).unwrap(),
        other => panic!("{other:?}"),
    };
    let hello = text(Outgoing::Hello { session: "7".to_owned() });
    assert_eq!(hello["op"], "serverInfo");
    assert_eq!(hello["capabilities"], serde_json::json!(["time"]), "clients can publish nothing");
    let told = Told::new(4);
    let map = &text(told.feed().advertise(0).0)["channels"][0];
    assert_eq!((&map["id"], &map["topic"], &map["encoding"]), (&0.into(), &"/map".into(), &"cdr".into()));
    assert_eq!(
        (&map["schemaName"], &map["schemaEncoding"]),
        (&"nav_msgs/msg/OccupancyGrid".into(), &"ros2msg".into())
    );
    assert_eq!(text(Outgoing::refusal())["level"], 2);
    let binary = |outgoing: Outgoing| match Message::from(outgoing) {
        Message::Binary(bytes) => bytes.to_vec(),
        other => panic!("{other:?}"),
    };
    assert_eq!(binary(Outgoing::Time(258)), [2, 2, 1, 0, 0, 0, 0, 0, 0]);
    let sent = Sent { number: 0, channel: 9, time_ns: 3, data: vec![8, 9].into() };
    assert_eq!(binary(Outgoing::Data(5, sent)), [1, 5, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 8, 9]);
}

/// A client that is connected and has subscribed to the probability of the belief.
fn connect(server: &Server) -> BufReader<TcpStream> {
    let mut socket = TcpStream::connect(server.address).unwrap();
    let head = "GET / HTTP/1.1\r\nHost: here\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
                Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
                Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
    socket.write_all(head.as_bytes()).unwrap();
    let request = "{\"op\":\"subscribe\",\"subscriptions\":[{\"id\":1,\"channelId\":2}]}";
    // A text frame, masked with zeros.
    let frame =
        [&[0x81, 0x80 | u8::try_from(request.len()).unwrap(), 0, 0, 0, 0], request.as_bytes()].concat();
    socket.write_all(&frame).unwrap();
    let mut socket = BufReader::new(socket);
    let mut lines = String::new();
    while !lines.ends_with("\r\n\r\n") {
        assert!(socket.read_line(&mut lines).unwrap() > 0, "{lines}");
    }
    assert!(lines.starts_with("HTTP/1.1 101") && lines.contains("foxglove.sdk.v1"), "{lines}");
    socket
}

/// The next binary frame with a message of a topic.
fn message(socket: &mut BufReader<TcpStream>) -> Vec<u8> {
    loop {
        let mut read = |bytes: usize| {
            let mut buffer = vec![0; bytes];
            socket.read_exact(&mut buffer).unwrap();
            buffer
        };
        let head = read(2);
        let length = match head[1] {
            126 => read(2).into_iter().fold(0, |sum, byte| sum << 8 | usize::from(byte)),
            127 => read(8).into_iter().fold(0, |sum, byte| sum << 8 | usize::from(byte)),
            short => usize::from(short),
        };
        let frame = read(length);
        if head[0] == 0x82 && frame[0] == 1 {
            return frame;
        }
    }
}

/// If the mission waited for the client, this test would never end.
#[test]
fn a_client_that_stops_to_read_stops_neither_the_mission_nor_others() {
    let (server, messages) =
        Server::start(&Settings { listen: ([127, 0, 0, 1], 0).into(), ..Settings::default() }).unwrap();
    let header = header(500);
    let mut listener = telling(&header, messages);
    let mut silent = connect(&server);
    assert_eq!(message(&mut silent).len(), message(&mut connect(&server)).len(), "both get the first belief");
    let belief =
        |probability| Record::Belief(Arc::new(Belief::uniform(&header.terrain, probability).unwrap()));
    // 60 MB: more than fits into the buffers in between.
    for second in 1..=48 {
        listener(MissionTime(second), &belief(0.1));
    }
    listener(MissionTime(49), &belief(0.9));
    let mut reading = connect(&server);
    let latest = message(&mut reading);
    assert_eq!(latest[5..13], 1_049_u64.to_le_bytes(), "the newest belief comes first");
    let last = f32::from_le_bytes(*latest.last_chunk().unwrap());
    assert!((last - 0.9).abs() < 1e-6, "{last}");
}
