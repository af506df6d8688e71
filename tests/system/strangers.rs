//! Who has no certificate opens connections, says nothing, and keeps nobody out.

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpStream};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use dragnet_keys::register::Topology;
use serde_json::{Value, json};

use crate::eventually;
use crate::security::{Field, NAMES, Process};

/// So many files may a process have open.
const FILES: usize = 256;
/// So many connections a stranger holds to each.
const HELD: usize = 400;

/// A stranger that opens connections to an endpoint over and over and says nothing, until it is dropped.
struct Stranger {
    is_over: Arc<AtomicBool>,
    calls: Option<JoinHandle<usize>>,
}

impl Stranger {
    /// Comes back once it holds as many as it will.
    fn call(endpoint: &str) -> Self {
        let address: SocketAddr = endpoint.rsplit('/').next().unwrap().parse().unwrap();
        eventually("somebody listens", || TcpStream::connect(address).is_ok());
        let is_over = Arc::new(AtomicBool::new(false));
        let open = move || TcpStream::connect_timeout(&address, Duration::from_millis(100)).ok();
        let mut held: VecDeque<TcpStream> = (0..HELD).filter_map(|_| open()).collect();
        let ends = Arc::clone(&is_over);
        let calls = std::thread::spawn(move || {
            let mut count = held.len();
            while !ends.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(5));
                if let Some(call) = open() {
                    held.push_back(call);
                    count += 1;
                }
                held.drain(..held.len().saturating_sub(HELD));
            }
            count
        });
        Self { is_over, calls: Some(calls) }
    }

    /// How often it has called.
    fn end(mut self) -> usize {
        self.is_over.store(true, Ordering::Relaxed);
        self.calls.take().unwrap().join().unwrap()
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

/// The same, with few files.
fn cramped(command: &Command) -> Command {
    let mut sh = Command::new("sh");
    sh.args(["-c", &format!("ulimit -n {FILES}; exec \"$@\""), "sh"]);
    sh.arg(command.get_program()).args(command.get_args());
    sh
}

#[test]
fn silent_connections_to_all_keep_nobody_of_the_mission_out() {
    let field = Field::new(Topology::Mesh);
    let (mut processes, mut strangers) = (Vec::new(), Vec::new());
    // The world comes first: all call those before them, who are besieged by then.
    for (place, name) in [3, 0, 1, 2].map(|it| NAMES[it]).into_iter().enumerate() {
        processes.push(Process::start(&mut cramped(&field.command(name, place))));
        strangers.push(Stranger::call(&field.endpoints[place]));
    }
    let start = Instant::now();
    let world = processes.remove(0);
    processes[0].says(&["refused a connection: 127.0.0.1 calls while 64 of its connections"]);
    let outcome: Value = serde_json::from_str(&world.output()).unwrap();
    assert_eq!((&outcome["beliefs_equal"], &outcome["recall"]), (&json!(true), &json!(1.0)), "{outcome}");
    let counts: Vec<usize> = strangers.into_iter().map(Stranger::end).collect();
    eprintln!("searched after {:.1} s, called {counts:?} times", start.elapsed().as_secs_f64());
    assert!(counts.iter().all(|&count| count > FILES), "{counts:?}");
}
