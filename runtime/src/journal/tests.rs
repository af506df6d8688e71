mod damage;

use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::instructions::Instructions;
use dragnet_proto::message::{Activity, Heartbeat, Intent, ZoneReport};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::participant::Participant;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::Origin;

use super::*;

struct Shelf {
    folder: tempfile::TempDir,
    mission: Mission,
    terrain: Terrain,
}

impl Shelf {
    fn new() -> Self {
        let terrain = Terrain::from_ascii("....\n....", 1.0).unwrap();
        Self { folder: tempfile::tempdir().unwrap(), mission: "cone".parse().unwrap(), terrain }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("robot.journal")
    }

    fn subject(&self, robot: u16) -> Subject<'_> {
        Subject { mission: &self.mission, robot: RobotId::new(robot).unwrap(), terrain: &self.terrain }
    }

    fn open(&self, robot: u16, now_unix_ns: u64) -> Result<(Journal, Memory), JournalError> {
        Journal::open(&self.path(), self.subject(robot), now_unix_ns)
    }

    fn peek(&self, robot: u16) -> Result<Prospect, JournalError> {
        peek(&self.path(), self.subject(robot))
    }

    fn observation(&self, robot: u16, incarnation: u64, sequence: u64) -> Arc<Observation> {
        let from = self.terrain.grid().cells().next().unwrap();
        let origin = Origin { source: RobotId::new(robot).unwrap().into(), incarnation };
        let readings = vec![Reading { cell: from, value: 0.5, variance: 0.25 }];
        Arc::new(Observation { origin, sequence, time_ns: 7, from, readings, positions: Box::default() })
    }
}

fn memory_of(started_unix_ns: u64, observations: Vec<Arc<Observation>>) -> Memory {
    Memory { started_unix_ns, observations, instructions: Vec::new() }
}

#[test]
fn committed_observations_are_restored_and_pending_ones_are_not() {
    let shelf = Shelf::new();
    let committed = [(1, 0, 0), (1, 0, 1), (1, 9, 0), (2, 0, 4)]
        .map(|(robot, incarnation, sequence)| shelf.observation(robot, incarnation, sequence));
    let (mut journal, memory) = shelf.open(1, 100).unwrap();
    assert_eq!(memory, memory_of(100, Vec::new()));
    journal.note(committed.iter().rev().cloned().collect());
    journal.commit();
    journal.note(vec![shelf.observation(2, 0, 5)]);
    assert_eq!(journal.waiting(), 1);
    drop(journal);
    let (_, memory) = shelf.open(1, 200).unwrap();
    assert_eq!(memory, memory_of(100, committed.to_vec()));
}

#[test]
fn stored_observations_are_read_by_name() {
    let shelf = Shelf::new();
    let (mut journal, _) = shelf.open(1, 0).unwrap();
    let [ones, again, twos] = [(1, 0), (1, 9), (2, 0)].map(|(robot, incarnation)| {
        (0..100).map(|sequence| shelf.observation(robot, incarnation, sequence)).collect::<Vec<_>>()
    });
    journal.note([ones.clone(), again.clone(), twos.clone()].concat());
    let found =
        |journal: &Journal, of: &Arc<Observation>, most| journal.since(of.origin, of.sequence, most).unwrap();
    assert_eq!(found(&journal, &ones[0], 10), [], "it is noted only");
    journal.commit();
    assert_eq!(found(&journal, &ones[0], 64), ones[..64]);
    assert_eq!(found(&journal, &again[90], 64), again[90..]);
    assert_eq!(found(&journal, &twos[99], 64), twos[99..]);
    assert_eq!(found(&journal, &shelf.observation(2, 0, 100), 64), []);
    assert_eq!(found(&journal, &shelf.observation(3, 0, 0), 64), []);
}

#[test]
fn a_journal_of_another_robot_mission_or_map_is_rejected() {
    let mut shelf = Shelf::new();
    drop(shelf.open(1, 0).unwrap());
    let check = |shelf: &Shelf, robot, expected: &[&str]| {
        for error in [shelf.peek(robot).err(), shelf.open(robot, 0).err()] {
            let error = error.unwrap().to_string();
            assert!(expected.iter().all(|part| error.contains(part)), "{error}");
        }
    };
    check(&shelf, 2, &["robot.journal", "robot \"1\", not \"2\""]);
    let mission = std::mem::replace(&mut shelf.mission, "other".parse().unwrap());
    check(&shelf, 1, &["mission \"cone\", not \"other\""]);
    shelf.mission = mission;
    shelf.terrain = Terrain::from_ascii("....\n...#", 1.0).unwrap();
    check(&shelf, 1, &["map \"2 x 4 cells of 1 m"]);
}

#[test]
fn one_robot_does_not_run_twice() {
    let shelf = Shelf::new();
    let _first = shelf.open(1, 0).unwrap();
    let error = shelf.open(1, 0).err().unwrap().to_string();
    assert!(error.contains("running already"), "{error}");
}

#[test]
fn a_damaged_journal_is_set_aside_and_a_new_one_begun() {
    let shelf = Shelf::new();
    let (mut journal, _) = shelf.open(1, 0).unwrap();
    journal.note((0..200).map(|sequence| shelf.observation(1, 0, sequence)).collect());
    journal.commit();
    drop(journal);
    let mut bytes = std::fs::read(shelf.path()).unwrap();
    // Neither in the header nor in an empty page at the end: pages in use have checksums.
    let damaged: Vec<usize> = (4096..bytes.len()).filter(|&place| bytes[place] != 0).collect();
    for &place in &damaged {
        bytes[place] ^= 0x55;
    }
    assert!(!damaged.is_empty());
    std::fs::write(shelf.path(), &bytes).unwrap();
    let (_, memory) = shelf.open(1, 5).unwrap();
    assert_eq!(memory, memory_of(5, Vec::new()));
    assert_eq!(std::fs::read(shelf.folder.path().join("robot.journal.damaged")).unwrap(), bytes);
}

#[test]
fn the_last_instructions_of_each_kind_are_restored_and_written_only_when_they_change() {
    let shelf = Shelf::new();
    let from = Participant::Robot(RobotId::FIRST);
    let zones = |time_ns, zones: &Zones| Message::Zones(ZoneReport { from, time_ns, zones: zones.clone() });
    let heartbeat = |time_ns, directive: &Directive| {
        let intent =
            Intent { robot: RobotId::FIRST, incarnation: 0, decision: 0, time_ns, path: Vec::new().into() };
        Message::Heartbeat(Heartbeat {
            robot: RobotId::FIRST,
            time_ns,
            activity: Activity::Paused,
            cell: shelf.terrain.grid().cells().next().unwrap(),
            path_meters: 1.0,
            intent,
            versions: Vec::new().into(),
            digest: Digest(3),
            directive: directive.clone(),
        })
    };
    let (mut closed, mut paused) = (Zones::default(), Directive::default());
    let (mut journal, _) = shelf.open(1, 0).unwrap();
    closed.give(5, shelf.terrain.grid().cells().next().unwrap(), Zone::NoGo);
    journal.note_instructions(&zones(6, &closed));
    journal.note_instructions(&heartbeat(6, &paused));
    journal.commit();
    paused.give(7, TeamOrder::Pause);
    journal.note_instructions(&heartbeat(8, &paused));
    journal.commit();
    let size = || std::fs::read(shelf.path()).unwrap();
    let before = size();
    for time_ns in 9..30 {
        journal.note_instructions(&zones(time_ns, &closed));
        journal.note_instructions(&heartbeat(time_ns, &paused));
        journal.commit();
    }
    assert_eq!(size(), before, "nothing new was said");
    closed.give(31, shelf.terrain.grid().cells().nth(1).unwrap(), Zone::Skip);
    journal.note_instructions(&zones(32, &closed));
    drop(journal);
    let (_, memory) = shelf.open(1, 0).unwrap();
    let [directive, closed] = &memory.instructions[..] else { panic!("{:?}", memory.instructions) };
    assert_eq!(directive.instructions(), Some(Instructions::Directive(&paused)));
    let Some(Instructions::Zones(closed)) = closed.instructions() else { panic!("{closed:?}") };
    assert_eq!(closed.iter().count(), 1, "the second one was not committed");
}

#[test]
fn a_journal_of_an_earlier_version_has_no_instructions() {
    let shelf = Shelf::new();
    drop(shelf.open(1, 0).unwrap());
    let database = Database::open(shelf.path()).unwrap();
    assert_eq!(read_instructions(&database).unwrap(), []);
}
