//! Several hosts on one computer, with processes on them.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::field::DRAGNET;

/// In user namespaces, so that no privilege is needed where the system provides them; everything ends with the shell.
const ISOLATED: [&str; 8] =
    ["--user", "--map-root-user", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"];

/// The hosts, and a folder that all of them share.
pub(crate) struct Hosts {
    folder: TempDir,
    shell: Child,
    answers: BufReader<ChildStdout>,
}

impl Hosts {
    /// `None` where a process may not have its own network.
    pub(crate) fn new() -> Option<Self> {
        let mut probe = Command::new("unshare");
        probe.args(ISOLATED).args(["sh", "-c", "mount -t tmpfs tmpfs /run && ip netns add probe"]);
        let probe = probe.stdout(Stdio::null()).stderr(Stdio::null()).status();
        if !probe.is_ok_and(|status| status.success()) {
            crate::skip("this system gives no network namespaces (or has no `unshare` and `ip`)");
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let mut shell = Command::new("unshare")
            .args(ISOLATED)
            .args(["bash", concat!(env!("CARGO_MANIFEST_DIR"), "/tests/system/hosts.sh")])
            .arg(folder.path())
            .env("RUST_LOG", "info,zenoh=error")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let answers = BufReader::new(shell.stdout.take().unwrap());
        Some(Self { folder, shell, answers })
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// The log of a process.
    pub(crate) fn log(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(&format!("{name}.log"))).unwrap_or_default()
    }

    /// A command of `hosts.sh`.
    pub(crate) fn order(&mut self, order: &str) {
        writeln!(self.shell.stdin.as_mut().unwrap(), "{order}").unwrap();
        let mut answer = String::new();
        self.answers.read_line(&mut answer).unwrap();
        assert_eq!(answer, "done\n", "{order}");
    }

    /// A process of the program under test on the host of the same name.
    pub(crate) fn start(&mut self, name: &str, arguments: &str) {
        self.order(&format!("start {name} {name} {DRAGNET} {arguments}"));
    }

    /// Waits for a condition.
    pub(crate) fn until(&self, what: &str, mut is_so: impl FnMut(&Self) -> bool) {
        let start = Instant::now();
        while !is_so(self) {
            assert!(start.elapsed() < Duration::from_mins(2), "in vain until {what}\n{}", self.logs());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn logs(&self) -> String {
        let is_log = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "log");
        let files = std::fs::read_dir(self.folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let reported =
            |path: &Path| format!("== {}\n{}", path.display(), std::fs::read_to_string(path).unwrap());
        files.filter(is_log).map(|path| reported(&path)).collect()
    }
}

impl Drop for Hosts {
    fn drop(&mut self) {
        drop(self.shell.stdin.take());
        let _ = self.shell.kill();
        let _ = self.shell.wait();
    }
}
