//! A robot's published observations survive its death: real processes, killed at any moment, and a full disk.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{self, Child, Stdio};
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::command::Command;
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::message::{Activity, Message};
use dragnet_proto::state_machine::Event;
use dragnet_runtime::journal::{Journal, Subject};
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Observation, Origin, RobotId};
use tokio::sync::{mpsc, watch};
use xxhash_rust::xxh3::xxh3_64_with_seed;

use crate::field::{DRAGNET, Field, Process};
use crate::witness::{self, Knowledge};

const ROBOTS: usize = 4;
const KILLS: u64 = 200;

/// A search that goes on when all is found: readings are so vague that there is always something left to observe.
pub(crate) fn endless(robots: usize) -> String {
    format!(
        "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 30\ncolumns = 30\n[sensor]\nnoise_variance = 20.0\n[objects]\ncount = 4\n\
         [robots]\ncount = {robots}\npolicy = \"random\"\n[mission]\nbudget_seconds = 1e6\nstop_when_expected_remaining = 0\n"
    )
}

/// Waits, with a time limit, until the coordinator has this.
async fn learned<'a>(
    knowledge: &'a mut watch::Receiver<Knowledge>,
    what: &str,
    is_known: impl FnMut(&Knowledge) -> bool,
) -> watch::Ref<'a, Knowledge> {
    let known = tokio::time::timeout(Duration::from_mins(1), knowledge.wait_for(is_known)).await;
    known.unwrap_or_else(|_| panic!("the coordinator waits in vain: {what}")).unwrap()
}

/// By which an observation is known.
type Name = (Origin, u64);

fn by_name(observations: &[Arc<Observation>]) -> BTreeMap<Name, Arc<Observation>> {
    observations
        .iter()
        .map(|observation| ((observation.origin, observation.sequence), Arc::clone(observation)))
        .collect()
}

/// Kills a robot again and again, at some moment after a publication, and restarts it each time.
async fn kill_repeatedly(field: &Field, number: usize, mut knowledge: watch::Receiver<Knowledge>) -> Process {
    let robot = RobotId::new(u16::try_from(number).unwrap()).unwrap();
    let mut process = field.robot(number);
    let mut last = None;
    for kill in 0..KILLS / ROBOTS as u64 {
        let what = format!("robot {number} after {kill} deaths");
        last = learned(&mut knowledge, &what, |knowledge| knowledge.latest(robot) > last).await.latest(robot);
        let moment = xxh3_64_with_seed(&kill.to_le_bytes(), robot.number().into()) % 40_000;
        tokio::time::sleep(Duration::from_micros(moment)).await;
        process.kill();
        process = field.robot(number);
    }
    learned(&mut knowledge, "a robot after its last death", |knowledge| knowledge.latest(robot) > last).await;
    process
}

/// The observations in a robot's journal.
fn read(field: &Field, number: usize, journal: &Path) -> Vec<Arc<Observation>> {
    let scenario = field.scenario();
    let mission = "field".parse().unwrap();
    let robot = RobotId::new(u16::try_from(number).unwrap()).unwrap();
    let subject = Subject { mission: &mission, robot, terrain: scenario.terrain() };
    Journal::open(journal, subject, 0).unwrap().1.observations
}

/// The state of all, once it is equal.
async fn settled(knowledge: &mut watch::Receiver<Knowledge>, robots: usize) -> Knowledge {
    learned(knowledge, "equal beliefs", |knowledge| knowledge.is_shared_by(robots)).await.clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn robots_that_are_killed_200_times_lose_no_published_observation() {
    let field = Field::new(&endless(ROBOTS), ROBOTS, 5);
    let (sender, mut knowledge) = watch::channel(Knowledge::default());
    let received = knowledge.clone();
    let coordinator = witness::coordinate(&field, sender);
    let tormented = async {
        let world = field.world();
        let [one, two, three, four] =
            [1, 2, 3, 4].map(|number| kill_repeatedly(&field, number, received.clone()));
        let robots = tokio::join!(one, two, three, four);
        // No new observations from now on.
        world.kill();
        let shared = settled(&mut knowledge, ROBOTS).await;
        drop((knowledge, received));
        (robots, shared)
    };
    let ((), (robots, shared)) = tokio::join!(coordinator, tormented);
    <[Process; ROBOTS]>::from(robots).into_iter().for_each(Process::terminate);
    assert_eq!(shared.conflicting, 0, "a name stands for two observations");
    let said = by_name(&shared.observations);
    let lives: BTreeSet<Origin> = said.keys().map(|&(origin, _)| origin).collect();
    assert!(lives.len() as u64 >= KILLS + ROBOTS as u64, "only {} lives", lives.len());
    for number in 1..=ROBOTS {
        let journal = read(&field, number, &field.path(&format!("field-robot-{number}.journal")));
        assert_eq!(by_name(&journal), said, "robot {number}");
    }
}

/// A process whose files are on a small disk of its own, which can be filled.
pub(crate) struct SmallDisk {
    shell: Child,
    answers: BufReader<std::process::ChildStdout>,
}

/// Mounts the disk for this shell and its children only, runs the process, and executes commands.
const SHELL: &str = r#"
disk=$1; log=$2; shift 2
mount -t tmpfs -o size=2m tmpfs "$disk"
start() { "$@" 2>> "$log" & robot=$!; }
start "$@"
while read -r order; do
    case $order in
        fill) dd if=/dev/zero of="$disk/filler" bs=4k 2> /dev/null || true ;;
        free) rm "$disk/filler" ;;
        restart) kill -9 $robot; wait $robot || true; start "$@" ;;
        stop) kill $robot; wait $robot; cp "$disk"/* "$disk.copy" ;;
    esac
    echo done
done
kill -9 $robot 2> /dev/null || true
"#;

impl SmallDisk {
    /// Runs a command of the program, with settings that may name files on the disk. `None` where a process may not
    /// mount.
    pub(crate) fn start(
        field: &Field,
        command: &str,
        settings: impl FnOnce(&Path) -> PathBuf,
    ) -> Option<Self> {
        let mut unshare = process::Command::new("unshare");
        unshare.args(["--user", "--map-root-user", "--mount"]);
        if !unshare.arg("true").status().is_ok_and(|status| status.success()) {
            return None;
        }
        let disk = field.path("disk");
        std::fs::create_dir(&disk).unwrap();
        std::fs::create_dir(field.path("disk.copy")).unwrap();
        let settings = settings(&disk);
        let mut shell = process::Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "sh", "-ec", SHELL, "sh"])
            .args([&disk, &field.path("log")])
            .args([DRAGNET, command, "--config"])
            .arg(settings)
            .env("RUST_LOG", "info")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let answers = BufReader::new(shell.stdout.take().unwrap());
        Some(Self { shell, answers })
    }

    /// The path of a file of the disk from outside.
    pub(crate) fn seen(&self, file: &Path) -> PathBuf {
        PathBuf::from(format!("/proc/{}/root{}", self.shell.id(), file.display()))
    }

    pub(crate) fn order(&mut self, order: &str) {
        writeln!(self.shell.stdin.as_mut().unwrap(), "{order}").unwrap();
        let mut answer = String::new();
        self.answers.read_line(&mut answer).unwrap();
        assert_eq!(answer, "done\n", "{order}");
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        drop(self.shell.stdin.take());
        let _ = self.shell.wait();
    }
}

/// Waits for a line in a robot's log; meanwhile it continues to search.
async fn said(log: &Path, words: &str, knowledge: &mut watch::Receiver<Knowledge>) {
    let says = || std::fs::read_to_string(log).unwrap().contains(words);
    let waited = async {
        while !says() {
            let count = knowledge.borrow().observations.len();
            knowledge.wait_for(|knowledge| knowledge.observations.len() > count).await.unwrap();
        }
    };
    let waited = tokio::time::timeout(Duration::from_mins(1), waited).await;
    assert!(waited.is_ok(), "no {words:?} in:\n{}", std::fs::read_to_string(log).unwrap());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_on_a_full_disk_continues_reports_it_and_recovers() {
    let field = Field::new(&endless(2), 2, 6);
    let settings = |disk: &Path| field.robot_settings(1, Some(&disk.join("robot.journal")));
    let Some(mut cramped) = SmallDisk::start(&field, "agent", settings) else {
        crate::skip("a disk of its own needs a mount namespace, which this system does not give");
        return;
    };
    let (sender, mut knowledge) = watch::channel(Knowledge::default());
    let coordinator = witness::coordinate(&field, sender);
    let mission = async {
        let (world, other, log, robot) = (field.world(), field.robot(2), field.path("log"), RobotId::FIRST);
        learned(&mut knowledge, "a robot", |knowledge| knowledge.latest(robot).is_some()).await;
        cramped.order("fill");
        said(&log, "the robot goes on", &mut knowledge).await;
        // The disk is still full when it restarts.
        let first = knowledge.borrow().latest(robot);
        cramped.order("restart");
        learned(&mut knowledge, "a robot that starts again", |knowledge| knowledge.latest(robot) > first)
            .await;
        said(&log, "robot 1 goes on with", &mut knowledge).await;
        cramped.order("free");
        said(&log, "written again", &mut knowledge).await;
        world.kill();
        let shared = settled(&mut knowledge, 2).await;
        cramped.order("stop");
        other.terminate();
        drop(knowledge);
        shared
    };
    let ((), shared) = tokio::join!(coordinator, mission);
    assert_eq!(shared.conflicting, 0);
    let journal = read(&field, 1, &field.path("disk.copy/robot.journal"));
    assert_eq!(by_name(&journal), by_name(&shared.observations));
}

/// A first page that was never written to the disk, as after a power failure.
#[tokio::test(flavor = "multi_thread")]
async fn a_robot_whose_journal_has_lost_its_first_page_searches_on_with_a_new_one() {
    let field = Field::new(&endless(1), 1, 7);
    let journal = field.path("field-robot-1.journal");
    let (sender, mut knowledge) = watch::channel(Knowledge::default());
    let coordinator = witness::coordinate(&field, sender);
    let mission = async {
        let (world, robot, process) = (field.world(), RobotId::FIRST, field.robot(1));
        learned(&mut knowledge, "a robot", |knowledge| knowledge.latest(robot).is_some()).await;
        process.kill();
        let mut bytes = std::fs::read(&journal).unwrap();
        bytes[..4096].fill(0);
        std::fs::write(&journal, &bytes).unwrap();
        let last = knowledge.borrow().latest(robot);
        let process = field.robot(1);
        let what = "a robot with a new journal";
        learned(&mut knowledge, what, |knowledge| knowledge.latest(robot) > last).await;
        process.kill();
        world.kill();
        assert_eq!(std::fs::read(field.path("field-robot-1.journal.damaged")).unwrap(), bytes);
        drop(knowledge);
    };
    tokio::join!(coordinator, mission);
    assert!(!read(&field, 1, &journal).is_empty());
}

/// Whether the robot that was heard last does this.
fn does(wanted: Activity) -> impl Fn(&Knowledge) -> bool {
    move |knowledge| knowledge.beats.last().is_some_and(|beat| beat.activity == wanted)
}

/// What a coordinator hears that knows of no order: twenty heartbeats of the robot, which then ends.
async fn overheard(field: &Field, end: fn(Process)) -> Knowledge {
    let (sender, mut knowledge) = watch::channel(Knowledge::default());
    let coordinator = witness::coordinate(field, sender);
    let mission = async {
        let (world, process) = (field.world(), field.robot(1));
        let is_enough = |knowledge: &Knowledge| knowledge.beats.len() >= 20;
        let heard = learned(&mut knowledge, "heartbeats", is_enough).await.clone();
        world.kill();
        end(process);
        drop(knowledge);
        heard
    };
    tokio::join!(coordinator, mission).1
}

const PAUSE: Event<Message> = Event::Commanded(Command::Team(TeamOrder::Pause));

/// The operator's word outlives all processes but for a robot's disk: a robot that nobody tells anything stays paused.
#[tokio::test(flavor = "multi_thread")]
async fn a_paused_robot_stays_paused_when_everything_has_been_killed() {
    let field = Field::new(&endless(1), 1, 8);
    let (sender, mut knowledge) = watch::channel(Knowledge::default());
    let (operator, commands) = mpsc::channel(1);
    let coordinator = witness::coordinate_by(&field, sender, commands);
    let first = async {
        let (world, process) = (field.world(), field.robot(1));
        learned(&mut knowledge, "a robot that drives", does(Activity::Searching)).await;
        operator.send((None, PAUSE)).await.unwrap();
        learned(&mut knowledge, "a paused robot", does(Activity::Paused)).await;
        process.kill();
        world.kill();
        drop(knowledge);
    };
    tokio::join!(coordinator, first);

    let since = overheard(&field, Process::terminate).await;
    assert!(since.beats.iter().all(|beat| beat.activity == Activity::Paused), "{:?}", since.beats);
    let cells: BTreeSet<Cell> = since.beats.iter().map(|beat| beat.cell).collect();
    assert_eq!(cells.len(), 1, "it stands");
}

/// It would lose against older orders of robots that come later.
#[tokio::test(flavor = "multi_thread")]
async fn an_order_of_a_coordinator_that_has_just_started_is_dated_by_the_missions_time() {
    let field = Field::new(&endless(1), 1, 9);
    let begun_ns = overheard(&field, Process::kill).await.beats[19].time_ns;

    let (sender, mut knowledge) = watch::channel(Knowledge::default());
    let (operator, commands) = mpsc::channel(1);
    operator.send((None, PAUSE)).await.unwrap();
    let coordinator = witness::coordinate_by(&field, sender, commands);
    let again = async {
        let (world, process) = (field.world(), field.robot(1));
        let is_dated = |knowledge: &Knowledge| {
            does(Activity::Paused)(knowledge)
                && knowledge.beats.last().is_some_and(|beat| beat.directive.number > begun_ns)
        };
        learned(&mut knowledge, "a pause of now", is_dated).await;
        world.kill();
        process.terminate();
        drop(knowledge);
    };
    tokio::join!(coordinator, again);
}
