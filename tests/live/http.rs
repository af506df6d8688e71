//! Access control, tested with plain sockets.

use std::io::{Read, Write};
use std::net::TcpStream;

use super::{Served, folder};

/// The answer to a request with these header lines: its status, its head and its body.
pub(super) fn ask(served: &Served, line: &str, headers: &[&str], body: &str) -> (u16, String, String) {
    let mut socket = TcpStream::connect(served.host()).unwrap();
    let host = format!("Host: {}", served.host());
    let given = headers.iter().any(|header| header.starts_with("Host:"));
    let mut head = vec![format!("{line} HTTP/1.1"), "Connection: close".to_owned()];
    head.extend((!given).then_some(host));
    head.extend(headers.iter().map(|&header| header.to_owned()));
    head.push(format!("Content-Length: {}", body.len()));
    // The server may reject the request before it has read all.
    let _ = socket.write_all(format!("{}\r\n\r\n{body}", head.join("\r\n")).as_bytes());
    let mut answer = Vec::new();
    let _ = socket.read_to_end(&mut answer);
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, head.to_lowercase(), body.to_owned())
}

const PAUSE: &str = r#"{"command":"pause"}"#;

#[test]
fn changing_the_mission_requires_the_token() {
    let served = Served::run();
    let bearer = format!("Authorization: Bearer {}", served.token());
    let command = |headers: &[&str], body: &str| {
        let (status, _, said) = ask(&served, "POST /command", headers, body);
        (status, said)
    };
    assert_eq!(served.token().len(), 32);
    assert_eq!(command(&[], PAUSE).0, 401);
    assert_eq!(command(&["Authorization: Bearer 0123456789abcdef0123456789abcdef"], PAUSE).0, 401);
    assert_eq!(command(&[&bearer], PAUSE).0, 200);
    let refused = |body: &str, status: u16, said: &str| {
        let (found, text) = command(&[&bearer], body);
        assert!(found == status && text.contains(said), "{body}: {found} {text}");
    };
    refused("pause", 400, "no command");
    refused(r#"{"command":"pause","now":true}"#, 400, "now");
    refused(r#"{"command":"clue","row":99,"column":0}"#, 422, "allowed are rows 0 to 17 and columns 0 to 25");
    refused(r#"{"command":"clue","row":0,"column":25}"#, 422, "nothing is searched near cell [0, 25]");
    refused(
        r#"{"command":"clue","row":9,"column":9,"radius_meters":1e5}"#,
        422,
        "a radius of 100000 m; allowed are 0 to",
    );
    refused(
        r#"{"command":"searched","corners":[[25,0],[26,0],[26,1],[25,1]]}"#,
        422,
        "no cell in it is searched",
    );
    refused(r#"{"command":"withdraw","mark":"7"}"#, 422, "that counts; the list of marks has their names");
    refused(
        r#"{"command":"mark","row":0,"column":0,"as":"clue"}"#,
        400,
        "is not known; allowed are pause, resume, return, end, go, clue",
    );
    refused(r#"{"command":"pause","robot":null}"#, 400, "null");
    refused(r#"{"command":"pause","robot":9}"#, 422, "there is no robot 9; the team has robots 1 to 3");
    refused(r#"{"command":"go","robot":1,"row":9,"column":9}"#, 422, "no robot can drive in cell [9, 9]");
    refused(r#"{"command":"go","robot":1,"row":99,"column":9}"#, 422, "rows 0 to");
    refused(r#"{"command":"search","corners":[[0,0],[3,3]]}"#, 422, "2 corners; allowed are 3 to 1000");
    refused(r#"{"command":"search","corners":[[0,0],[3,0],[3,3]]}"#, 422, "searched already");
    refused(r#"{"command":"find","row":1,"column":99,"as":"confirmed"}"#, 422, "columns 0 to 25");
    refused(r#"{"command":"find","row":1,"column":1,"as":"confirmed"}"#, 422, "no find in cell [1, 1]");
    refused(r#"{"command":"find","row":1,"column":1,"as":"dismissed"}"#, 422, "no find in cell [1, 1]");
    refused(r#"{"command":"find","row":1,"column":1,"as":"undone"}"#, 422, "nothing to undo");
    refused(r#"{"command":"find","row":1,"column":1,"as":"true"}"#, 400, "no command");
    let (status, ..) = ask(&served, "POST /command", &[&bearer], &"x".repeat(100_000));
    assert_eq!(status, 413);
}

#[test]
fn pages_of_others_are_not_answered() {
    let served = Served::run();
    let bearer = format!("Authorization: Bearer {}", served.token());
    let host = served.host();
    let upgrade = [
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
    ];
    for (line, body) in [("GET /", ""), ("GET /stream", ""), ("POST /command", PAUSE), ("GET /auth", "")] {
        for wrong in ["Host: evil.example", "Origin: http://evil.example", "Origin: null"] {
            let headers = [&[wrong, &bearer][..], &upgrade].concat();
            assert_eq!(ask(&served, line, &headers, body).0, 403, "{line} {wrong}");
        }
    }
    let (status, head, page) = ask(&served, "GET /", &[&format!("Origin: http://{host}")], "");
    assert_eq!(status, 200);
    assert!(page.contains("<title>Dragnet</title>") && !page.contains(served.token()));
    for part in ["default-src 'none'", "frame-ancestors 'none'", "nosniff", "no-store"] {
        assert!(head.contains(part), "{part}\n{head}");
    }
}

#[test]
fn a_page_listens_on_this_computer_only_by_default() {
    let served = Served::run();
    assert!(served.host().starts_with("127.0.0.1:"), "{}", served.address);
}

#[test]
fn a_coordinator_in_the_field_serves_a_page_with_the_token_of_a_file() {
    let folder = folder();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("token.txt", "a-token_of_a-person\n");
    write(
        "coordinator.toml",
        "[live]\nlisten = '127.0.0.1:0'\ntoken_file = 'token.txt'\n[common]\nmission = 'hall'\nscenario = 'hall.toml'\n",
    );
    let served = Served::start_in(folder, &["coordinator", "--config", "coordinator.toml"]);
    assert!(!served.address.contains("token"), "{}", served.address);
    let auth = |header: &str| ask(&served, "GET /auth", &[header], "").0;
    assert_eq!(auth("Authorization: Bearer a-token_of_a-person"), 204);
    assert_eq!(auth("Authorization: Bearer another_token_of_another"), 401);
    let (status, ..) = ask(&served, "POST /command", &["Authorization: Bearer a-token_of_a-person"], PAUSE);
    assert_eq!(status, 200);
}

#[test]
fn a_recording_cannot_be_changed() {
    let folder = folder();
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_dragnet"))
        .args(["run", "short.toml", "--record", "hall.mcap"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success());
    let served = Served::start_in(folder, &["replay", "hall.mcap", "--live"]);
    assert!(!served.address.contains("token"));
    assert_eq!(ask(&served, "POST /command", &[], PAUSE).0, 409);
}

/// A viewer: the status of its request, and the socket with the following bytes.
fn watch(served: &Served) -> (u16, TcpStream) {
    watch_as(served, &[])
}

fn watch_as(served: &Served, headers: &[&str]) -> (u16, TcpStream) {
    let mut socket = TcpStream::connect(served.host()).unwrap();
    let host = format!("Host: {}", served.host());
    let head = [
        "GET /stream HTTP/1.1",
        &host,
        "Connection: Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
    ];
    let head = [&head, headers].concat();
    write!(socket, "{}\r\n\r\n", head.join("\r\n")).unwrap();
    let mut status = [0; 12];
    socket.read_exact(&mut status).unwrap();
    (std::str::from_utf8(&status[9..]).unwrap().parse().unwrap(), socket)
}

#[test]
fn the_number_of_viewers_is_bounded_and_departures_make_room() {
    let served = Served::run();
    let idle: Vec<(u16, TcpStream)> = (0..31).map(|_| watch(&served)).collect();
    assert!(idle.iter().all(|&(status, _)| status == 101));
    let (status, mut reading) = watch(&served);
    assert_eq!(status, 101);
    assert_eq!(watch(&served).0, 503);
    // It receives the running search, whether or not the others read.
    reading.read_exact(&mut [0; 1 << 14]).unwrap();
    drop(idle);
    let mut tries = (0..100).map(|_| {
        std::thread::sleep(std::time::Duration::from_millis(100));
        watch(&served).0
    });
    assert!(tries.any(|status| status == 101));
}

/// Tries for a minute: a permit that is held for ever is held longer.
fn comes_true(mut is_so: impl FnMut() -> bool) -> bool {
    (0..600).any(|_| {
        let is_so = is_so();
        if !is_so {
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        is_so
    })
}

#[test]
fn viewers_that_do_not_read_do_not_block_others() {
    let served = Served::run();
    let silent: Vec<(u16, TcpStream)> = (0..32).map(|_| watch(&served)).collect();
    assert!(silent.iter().all(|&(status, _)| status == 101));
    assert_eq!(watch(&served).0, 503);
    // A viewer with the token gets a permit at once; one with a wrong token does not.
    let offer = |token: &str| format!("Sec-WebSocket-Protocol: dragnet, token.{token}");
    assert_eq!(watch_as(&served, &[&offer(served.token())]).0, 101);
    assert_eq!(watch_as(&served, &[&offer("0123456789abcdef0123456789abcdef")]).0, 503);
    // They neither read nor answer, and their sockets stay open.
    assert!(comes_true(|| watch(&served).0 == 101));
    drop(silent);
}

#[test]
fn requests_that_never_end_are_hung_up_on() {
    let served = Served::run();
    let open = |text: &str| {
        let mut socket = TcpStream::connect(served.host()).unwrap();
        socket.write_all(text.as_bytes()).unwrap();
        socket
    };
    let head = format!("POST /command HTTP/1.1\r\nHost: {}\r\n", served.host());
    let body = format!("{head}Authorization: Bearer {}\r\nContent-Length: 99\r\n\r\n{{", served.token());
    let sockets = ["", "GET / HTTP/1.1\r\nHo", &head, &body].map(open);
    for mut socket in sockets {
        socket.set_read_timeout(Some(std::time::Duration::from_mins(1))).unwrap();
        assert!(socket.read_to_end(&mut Vec::new()).is_ok(), "the server still waits");
    }
}

#[test]
fn one_address_does_not_take_all_places() {
    let served = Served::run();
    let crowd: Vec<TcpStream> = (0..100).map(|_| TcpStream::connect(served.host()).unwrap()).collect();
    let hung_up = |mut socket: &TcpStream| {
        socket.set_nonblocking(true).unwrap();
        !socket.read(&mut [0]).is_err_and(|error| error.kind() == std::io::ErrorKind::WouldBlock)
    };
    assert!(comes_true(|| crowd.iter().filter(|socket| hung_up(socket)).count() >= 36));
}
