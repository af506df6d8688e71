//! A client without a certificate that holds connections open does not block others.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use dragnet_keys::register::Topology;
use serde_json::{Value, json};

use crate::eventually;
use crate::security::{Field, NAMES, Process};

/// Limit of open files of a process.
const FILES: usize = 256;
/// Number of connections that it holds to each.
const HELD: usize = 400;

/// A client that opens connections to a port over and over and sends nothing, until it is dropped: a separate process,
/// with its own open files.
struct Stranger(Child);

const CALLS: &str = "held=()
while exec {fd}<>/dev/tcp/127.0.0.1/$0; do
    held+=($fd)
    if (( ${#held[@]} == $1 )); then echo; fi
    if (( ${#held[@]} > $1 )); then fd=${held[0]}; exec {fd}>&-; held=(${held[@]:1}); sleep 0.005; fi
done";

impl Stranger {
    /// Returns once it holds all of its connections.
    fn call(endpoint: &str) -> Self {
        let address = endpoint.rsplit('/').next().unwrap();
        eventually("somebody listens", || TcpStream::connect(address).is_ok());
        let port = address.rsplit(':').next().unwrap();
        let mut bash = Command::new("bash");
        bash.args(["-c", CALLS, port, &HELD.to_string()]).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = bash.spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert_eq!(line, "\n");
        Self(child)
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The same with few open files.
fn cramped(command: &Command) -> Command {
    let mut sh = Command::new("sh");
    sh.args(["-c", &format!("ulimit -n {FILES}; exec \"$@\""), "sh"]);
    sh.arg(command.get_program()).args(command.get_args());
    sh
}

#[test]
fn silent_connections_do_not_block_participants() {
    let field = Field::new(Topology::Mesh);
    let (mut processes, mut strangers) = (Vec::new(), Vec::new());
    // The world comes first: all connect to those before them, which are under attack by then.
    for (place, name) in [3, 0, 1, 2].map(|it| NAMES[it]).into_iter().enumerate() {
        processes.push(Process::start(&mut cramped(&field.command(name, place))));
        strangers.push(Stranger::call(&field.endpoints[place]));
    }
    let start = Instant::now();
    let world = processes.remove(0);
    processes[0].logs(&["rejected a connection: 127.0.0.1 calls while 64 of its connections"]);
    let outcome: Value = serde_json::from_str(&world.output()).unwrap();
    assert_eq!((&outcome["beliefs_equal"], &outcome["recall"]), (&json!(true), &json!(1.0)), "{outcome}");
    eprintln!("searched after {:.1} s", start.elapsed().as_secs_f64());
}
