//! The invariants of every participant, checked after every step.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::command::Command;
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::marks::Marks;
use dragnet_proto::message::{Activity, Message, ZoneReport};
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_proto::verdict::Verdicts;
use dragnet_proto::zones::Zone;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{Observation, Origin, RobotId};

use super::Violation;
use crate::faults::{Crash, Faults, Memory};

/// Below this probability a declaration may be withdrawn.
const WITHDRAWN_BELOW: f64 = 0.5;

/// Steps for which others may hold a robot: it gives several ways up, one after the other.
const HELD_STEPS: u32 = 12;

type Name = (Origin, u64);

/// The expected state of all participants, computed independently of them.
pub(super) struct Checks<'a> {
    scenario: &'a Scenario,
    /// Longest time that a robot may stay in one cell while it searches.
    patience: Duration,
    /// How many times as long as planned the slowest robot takes.
    slowest: f64,
    /// Whether the operator has zones: plans may change in the middle of a move, and bases be closed.
    has_zones: bool,
    /// Whether robots may drive home after their budget has ended.
    may_come_late: bool,
    /// Whether robots that broke down may stand where others have to pass: these wait, for as long as it takes.
    may_be_blocked: bool,
    /// Robots that have to be at their bases at the end.
    returning: Vec<RobotId>,
    shadows: BTreeMap<Participant, Shadow>,
    /// Every observation that was ever published, by name.
    published: BTreeMap<Name, Arc<Observation>>,
    count: u64,
}

/// The expected state of one participant.
struct Shadow {
    /// Of its stored observations, each counted once.
    belief: Belief,
    names: BTreeSet<Name>,
    /// The verdicts that it received or published, which the belief contains.
    verdicts: Verdicts,
    /// The marks likewise.
    marks: Marks,
    declared: BTreeSet<Cell>,
    /// What it did last.
    activity: Activity,
    /// When it entered its cell, or began to search or to return.
    moved: MissionTime,
    /// The time of its last event: it is woken for every heartbeat.
    awake: MissionTime,
}

impl<'a> Checks<'a> {
    pub(super) fn new(scenario: &'a Scenario, faults: &Faults) -> Self {
        let (terrain, mission) = (scenario.terrain(), scenario.mission());
        let slowest = faults.slowness.values().copied().fold(1.0, f64::max);
        let speeds = scenario.robots().iter().map(|robot| robot.class.speed_meters_per_second);
        let step = std::f64::consts::SQRT_2 * terrain.cell_meters() / speeds.fold(f64::INFINITY, f64::min);
        let team = u32::try_from(scenario.robots().len()).unwrap_or(u32::MAX);
        // It gives a way up that others do not clear in time, and may find the next one closed too.
        let held = if scenario.separation().is_kept() {
            Duration::from_secs_f64(step) * HELD_STEPS
        } else {
            Duration::ZERO
        };
        let has_zones = faults.commands.iter().any(|(_, command)| matches!(command, Command::Zone(..)));
        Self {
            scenario,
            has_zones,
            patience: Duration::from_secs_f64(step * slowest)
                + mission.stagger * team
                + 2 * mission.heartbeat
                + held,
            slowest,
            may_come_late: has_zones
                || scenario.mission().return_reserve.is_some()
                || faults.commands.iter().any(|(_, command)| {
                    matches!(
                        command,
                        Command::Team(TeamOrder::Return | TeamOrder::End)
                            | Command::Robot(_, RobotOrder::Return | RobotOrder::Go(_))
                    )
                }),
            may_be_blocked: scenario.separation().is_kept()
                && faults.crashes.keys().any(|it| matches!(it, Participant::Robot(_))),
            returning: returning(scenario, faults),
            shadows: BTreeMap::new(),
            published: BTreeMap::new(),
            count: 0,
        }
    }

    /// Number of checked steps.
    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    /// A participant restarts with only these observations and instructions.
    pub(super) fn restart<'m>(
        &mut self,
        participant: Participant,
        now: MissionTime,
        known: &[Arc<Observation>],
        instructions: impl IntoIterator<Item = &'m Message>,
    ) {
        self.shadows.remove(&participant);
        let shadow = self.shadow(participant, now);
        for observation in known {
            shadow.count(observation);
        }
        for message in instructions {
            self.learn(participant, now, message);
        }
    }

    fn shadow(&mut self, participant: Participant, now: MissionTime) -> &mut Shadow {
        let scenario = self.scenario;
        self.shadows.entry(participant).or_insert_with(|| Shadow {
            belief: scenario.prior().clone(),
            names: BTreeSet::new(),
            verdicts: Verdicts::default(),
            marks: Marks::default(),
            declared: BTreeSet::new(),
            activity: Activity::Searching,
            moved: now,
            awake: now,
        })
    }

    /// Records an event before it is handled.
    pub(super) fn before(&mut self, participant: Participant, now: MissionTime, event: &Event<Message>) {
        let shadow = self.shadow(participant, now);
        if matches!(event, Event::Start | Event::Sensed { .. }) {
            shadow.moved = now;
        }
        if let Event::Received { message, .. } = event {
            self.learn(participant, now, message);
        }
    }

    /// Verdicts and marks in a message count.
    fn learn(&mut self, participant: Participant, now: MissionTime, message: &Message) {
        let (grid, prior) = (self.scenario.terrain().grid(), self.scenario.prior().shared_prior());
        let shadow = self.shadow(participant, now);
        match message {
            Message::Verdicts(report) => {
                shadow.verdicts.merge(now, &report.verdicts, &mut shadow.belief);
            }
            Message::Marks(report) => {
                shadow.marks.merge_into(now, &report.marks, grid, &prior, &mut shadow.belief);
            }
            _ => {}
        }
    }

    /// A robot publishes the verdicts and marks that it received, and the coordinator also those that the operator gave it.
    fn check_by_hand(
        &mut self,
        participant: Participant,
        now: MissionTime,
        effects: &Effects<Message>,
    ) -> Result<(), Violation> {
        let (grid, prior) = (self.scenario.terrain().grid(), self.scenario.prior().shared_prior());
        let shadow = self.shadow(participant, now);
        let may_add = participant == Participant::Coordinator;
        for (_, message) in &effects.published {
            let is_known = match message {
                Message::Verdicts(report) => {
                    if may_add {
                        shadow.verdicts.take(report.verdicts.iter(), &mut shadow.belief);
                    }
                    report.verdicts == shadow.verdicts
                }
                Message::Marks(report) => {
                    if may_add {
                        shadow.marks.merge_into(now, &report.marks, grid, &prior, &mut shadow.belief);
                    }
                    report.marks == shadow.marks
                }
                _ => true,
            };
            if !is_known {
                let what = "it published other verdicts or marks than it received".to_owned();
                return Err(Violation::Broken { at: now, participant, what });
            }
        }
        Ok(())
    }

    /// Checks a participant's effects, belief and observations after an event.
    pub(super) fn after(
        &mut self,
        participant: Participant,
        now: MissionTime,
        effects: &Effects<Message>,
        digest: Digest,
        observations: u64,
    ) -> Result<(), Violation> {
        self.count += 1;
        self.check_by_hand(participant, now, effects)?;
        let broken = |what: String| Err(Violation::Broken { at: now, participant, what });
        let shadow = self.shadow(participant, now);
        for observation in &effects.kept {
            if !shadow.count(observation) {
                return broken(format!("{} counts twice", name_of(observation)));
            }
        }
        if digest != shadow.belief.digest() || observations != shadow.names.len() as u64 {
            let kept = shadow.names.len();
            return broken(format!("its evidence is not that of the {kept} observations that it kept"));
        }
        self.check_awake(participant, now, effects)?;
        self.check_published(participant, now, effects)
    }

    /// A robot is woken for every heartbeat, makes progress while it searches, and does not move while it is paused.
    fn check_awake(
        &mut self,
        participant: Participant,
        now: MissionTime,
        effects: &Effects<Message>,
    ) -> Result<(), Violation> {
        if participant == Participant::Coordinator {
            return Ok(());
        }
        let broken = |what: String| Err(Violation::Broken { at: now, participant, what });
        let (sleep, patience) = (2 * self.scenario.mission().heartbeat, self.patience);
        let has_zones = self.has_zones;
        let shadow = self.shadow(participant, now);
        // A robot that is called back, sent elsewhere or kept out in the middle of a move begins another.
        let is_sent = (has_zones || effects.activity == Activity::Sent) && effects.route.is_some();
        let has_changed =
            std::mem::replace(&mut shadow.activity, effects.activity) != effects.activity || is_sent;
        if has_changed || !effects.activity.is_under_way() {
            shadow.moved = now;
        }
        let is_held = matches!(effects.activity, Activity::Paused | Activity::Holding);
        if is_held && effects.route.as_ref().is_some_and(|it| !it.is_empty()) {
            return broken("it is paused or holds, and goes".to_owned());
        }
        let slept = now.since(std::mem::replace(&mut shadow.awake, now));
        let stood = now.since(shadow.moved);
        for (what, time, most) in
            [("nothing has woken it", slept, sleep), ("it searches, and has stood still", stood, patience)]
        {
            if time > most {
                let (time, most) = (time.as_secs_f64(), most.as_secs_f64());
                return broken(format!("{what} for {time:.1} s, longer than {most:.1} s"));
            }
        }
        Ok(())
    }

    fn check_published(
        &mut self,
        participant: Participant,
        now: MissionTime,
        effects: &Effects<Message>,
    ) -> Result<(), Violation> {
        let broken = |what: String| Err(Violation::Broken { at: now, participant, what });
        for (_, message) in &effects.published {
            match message {
                Message::Observation(observation) => {
                    let name = (observation.origin, observation.sequence);
                    if !self.shadow(participant, now).names.contains(&name) {
                        return broken(format!("it published {} and did not keep it", name_of(observation)));
                    }
                    let known = self.published.entry(name).or_insert_with(|| Arc::clone(observation));
                    if **known != **observation {
                        return broken(format!("it published another {}", name_of(observation)));
                    }
                }
                Message::MissionStatus(status) => {
                    let declared = status.declared.iter().map(|detection| detection.cell).collect();
                    let shadow = self.shadow(participant, now);
                    let withdrawn = shadow.declared.difference(&declared);
                    let believed = withdrawn.map(|&cell| (cell, shadow.belief.probability(cell)));
                    if let Some((cell, probability)) = believed.into_iter().find(|it| it.1 >= WITHDRAWN_BELOW)
                    {
                        let number = cell.number();
                        return broken(format!("it withdrew cell {number}, of probability {probability}"));
                    }
                    shadow.declared = declared;
                }
                Message::Zones(ZoneReport { zones, .. }) => {
                    let mut plans = effects.published.iter().filter_map(|(_, message)| match message {
                        Message::Heartbeat(beat) if beat.activity != Activity::Leaving => {
                            Some(&beat.intent.path)
                        }
                        _ => None,
                    });
                    let is_closed = |cell: &Cell| zones.of(*cell) == Some(Zone::NoGo);
                    if plans.any(|path| path.iter().any(is_closed)) {
                        return broken("it plans to enter a no-go zone that it knows".to_owned());
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The observations of each participant, as numbers of every origin.
    pub(super) fn known(&self) -> String {
        let of = |(participant, shadow): (&Participant, &Shadow)| {
            let mut runs: Vec<(Origin, u64, u64)> = Vec::new();
            for &(origin, sequence) in &shadow.names {
                match runs.last_mut() {
                    Some((of, _, last)) if (*of, *last + 1) == (origin, sequence) => *last = sequence,
                    _ => runs.push((origin, sequence, sequence)),
                }
            }
            let runs = runs.into_iter().map(|(Origin { source, incarnation }, first, last)| {
                format!("{source}@{incarnation}: {first} to {last}")
            });
            format!("{participant} knows {}", runs.collect::<Vec<_>>().join(", "))
        };
        self.shadows.iter().map(of).collect::<Vec<_>>().join("; ")
    }

    /// Checks the state at the end of the search: when it ended, and which robots are where they started.
    pub(super) fn end(&self, ended: MissionTime, at_start: &[bool]) -> Result<(), Violation> {
        if let Some(&robot) = self.returning.iter().find(|robot| !at_start[robot.index()]) {
            let what = "it has not returned to its base".to_owned();
            return Err(Violation::Broken { at: ended, participant: Participant::Robot(robot), what });
        }
        if self.may_be_blocked {
            return Ok(());
        }
        let budgets = self.scenario.robots().iter().map(|robot| robot.class.budget.time());
        let Some(budget) = budgets.collect::<Option<Vec<_>>>().and_then(|budgets| budgets.into_iter().max())
        else {
            return Ok(());
        };
        // A robot that restarts late rests at once, or drives home first: as far as it had come, in the time that it takes.
        let way_home = if self.may_come_late { budget.mul_f64(self.slowest) } else { Duration::ZERO };
        // Others may make it a longer one.
        let detours = if self.scenario.separation().is_kept() { way_home } else { Duration::ZERO };
        let most =
            MissionTime::START + budget + way_home + detours + self.patience + Duration::from_secs(200);
        if ended > most {
            let participant = Participant::Coordinator;
            let what = format!("the mission was to end by {:.0} s", most.as_seconds());
            return Err(Violation::Broken { at: ended, participant, what });
        }
        Ok(())
    }
}

/// Robots that are to return to their bases, which stay open, neither break down nor forget them, and are not held by the operator
/// or by others who rest in their way.
fn returning(scenario: &Scenario, faults: &Faults) -> Vec<RobotId> {
    let is_closed = |command: &Command| matches!(command, Command::Zone(Zone::NoGo, _));
    let may_be_shut = scenario.separation().is_kept() || faults.commands.iter().any(|(_, it)| is_closed(it));
    if scenario.mission().return_reserve.is_none() || may_be_shut {
        return Vec::new();
    }
    let returns = |robot: &RobotId| {
        let is_held = faults.commands.iter().any(|(_, command)| match command {
            Command::Team(order) => *order == TeamOrder::Pause,
            Command::Robot(whom, order) => whom == robot && *order == RobotOrder::Pause,
            _ => false,
        });
        if is_held {
            return false;
        }
        let keeps = |crash: &Crash| matches!(crash.back, Some((_, Memory::Kept)));
        let crash = faults.crashes.get(&Participant::Robot(*robot));
        crash.is_none_or(|crash| keeps(crash) && !faults.full.contains_key(robot))
    };
    scenario.robots().iter().map(|robot| robot.id).filter(returns).collect()
}

impl Shadow {
    /// Whether an observation had not been counted before.
    fn count(&mut self, observation: &Observation) -> bool {
        for reading in &observation.readings {
            self.belief.add(reading);
        }
        self.names.insert((observation.origin, observation.sequence))
    }
}

/// `observation 3 of robot 2`
fn name_of(observation: &Observation) -> String {
    let Origin { source, incarnation } = observation.origin;
    format!("observation {} of {source}, incarnation {incarnation}", observation.sequence)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_proto::message::Audience;
    use dragnet_search::evidence::Reading;
    use dragnet_search::observation::RobotId;

    use super::*;

    const ROBOT: Participant = Participant::Robot(RobotId::FIRST);
    const NOW: MissionTime = MissionTime(1_000_000_000);

    fn scenario() -> Scenario {
        let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 3, columns = 3 }\nsensor.radius = 1\n\
                    objects.count = 1\nmission.budget_seconds = 60.0\n";
        Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap()
    }

    fn observation(scenario: &Scenario, value: f32) -> Arc<Observation> {
        let cell = scenario.terrain().grid().cells().next().unwrap();
        let readings = vec![Reading { cell, value, variance: 0.01 }];
        Arc::new(Observation {
            origin: Origin::first(RobotId::FIRST),
            sequence: 0,
            time_ns: 0,
            from: cell,
            readings,
            positions: Box::default(),
        })
    }

    fn effects(kept: Vec<Arc<Observation>>, published: Vec<Message>) -> Effects<Message> {
        Effects {
            kept,
            published: published.into_iter().map(|message| (Audience::All, message)).collect(),
            ..Effects::default()
        }
    }

    /// The result of the checks for a robot with the evidence of `held`, after these effects at these times.
    fn verdict(held: &[f32], steps: &[(MissionTime, Effects<Message>)]) -> String {
        let scenario = scenario();
        let mut belief = scenario.prior().clone();
        for &value in held {
            belief.add(&observation(&scenario, value).readings[0]);
        }
        let mut checks = Checks::new(&scenario, &Faults::default());
        for (now, effects) in steps {
            let found = checks.after(ROBOT, *now, effects, belief.digest(), held.len() as u64);
            if let Err(violation) = found {
                return violation.to_string();
            }
        }
        "held".to_owned()
    }

    #[test]
    fn violated_invariants_are_found() {
        let scenario = scenario();
        let seen = |value| observation(&scenario, value);
        let reported = |value| Message::Observation(seen(value));
        let good = (NOW, effects(vec![seen(0.5)], vec![reported(0.5)]));
        let check = |held: &[f32], steps: &[(MissionTime, Effects<Message>)], expected: &str| {
            let found = verdict(held, steps);
            assert!(found.contains(expected), "{found}");
        };
        check(&[0.5], std::slice::from_ref(&good), "held");
        check(&[0.5], &[good.clone(), good.clone()], "observation 0 of robot 1, incarnation 0 counts twice");
        check(&[0.5, 0.5], std::slice::from_ref(&good), "its evidence is not that of the 1 observations");
        check(&[], &[(NOW, effects(Vec::new(), vec![reported(0.5)]))], "and did not keep it");
        let another = (NOW, effects(Vec::new(), vec![reported(0.7)]));
        check(&[0.5], &[good.clone(), another], "it published another observation 0");
        let cell = scenario.terrain().grid().cells().next();
        let paused =
            Effects { activity: Activity::Paused, route: cell.map(|cell| vec![cell]), ..good.1.clone() };
        check(&[0.5], &[(NOW, paused)], "it is paused or holds, and goes");
        let late = |seconds| (NOW + Duration::from_secs(seconds), effects(Vec::new(), Vec::new()));
        check(&[0.5], &[good.clone(), late(3599)], "nothing has woken it for 3599.0 s");
        let stands: Vec<_> = std::iter::once(good).chain((1..10).map(|beat| late(10 * beat))).collect();
        check(&[0.5], &stands, "it searches, and has stood still for 50.0 s");
    }
}
