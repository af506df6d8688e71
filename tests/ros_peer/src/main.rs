//! A robot's node by hiroz, an independent ROS 2 client with its own messages, hashes, keys and CDR.
//!
//! Usage: `ros_peer ENDPOINT DOMAIN NAMESPACE`, with the endpoint of a Zenoh router. Until its standard input closes it
//! publishes repeatedly as a robot's sensors, detector and navigation would, and prints received messages as JSON, a
//! line each: `{"topic": "goal", ...}`. Its first line is `{"hashes": {"nav_msgs/msg/Odometry": "RIHS01_...", ...}}`.

mod robot;
mod vision;

use std::io::Read;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use hiroz::Builder;
use hiroz::context::ZContextBuilder;

fn main() -> hiroz::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [endpoint, domain, namespace] = arguments.as_slice() else {
        return Err("usage: ros_peer ENDPOINT DOMAIN NAMESPACE".into());
    };
    let context = ZContextBuilder::default()
        .with_router_endpoint(endpoint.as_str())?
        .with_domain_id(domain.parse()?)
        .build()?;
    let node = context.create_node("robot").with_namespace(namespace).build()?;
    println!("{}", robot::hashes());
    let _ears = robot::listen(&node)?;
    let voices = robot::Voices::new(&node)?;
    let is_over = Arc::new(AtomicBool::new(false));
    let ending = Arc::clone(&is_over);
    thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        ending.store(true, Ordering::Relaxed);
    });
    while !is_over.load(Ordering::Relaxed) {
        voices.say()?;
        thread::sleep(Duration::from_millis(50));
    }
    context.shutdown()
}
