//! An expert at work, watched decision by decision.

use std::sync::Arc;
use std::sync::mpsc;

use dragnet_agent::agent::{Agent, Orders};
use dragnet_learn::demonstration::{Recorder, Source, Trajectory};
use dragnet_proto::message::{Message, Participant};
use dragnet_proto::participant::{MindError, Reaction, Stimulus};
use dragnet_proto::scenario::Scenario;
use dragnet_proto::time::MissionTime;
use dragnet_search::evidence::Digest;
use dragnet_search::policy::Policy;

use crate::crew::{Crew, LocalCrew};
use crate::episode;
use crate::simulation::{Attendance, End, Rules};

/// Runs a scenario until all is found, the budget is spent or enough has been seen. Every robot has an expert, and the
/// decisions of all are taken down.
///
/// # Errors
/// Never, as long as robots of this process cannot fail.
pub fn watch(
    scenario: &Scenario,
    seed: u64,
    source: Source,
    scenario_digest: String,
    expert: impl Fn() -> Box<dyn Policy + Send>,
) -> Result<Trajectory, MindError> {
    let (sink, taken) = mpsc::channel();
    let orders = Orders::of_team(scenario, seed).into_iter();
    let mut robots: Vec<Agent> = orders
        .map(|orders| {
            let recorder = Recorder::new(expert(), source.explore, sink.clone());
            Agent::with_policy(orders, Box::new(recorder))
        })
        .collect();
    let rules = Rules { end: End::AllFound, coordinator: Attendance::Absent };
    let mut crew =
        Audience { crew: LocalCrew::new(&mut robots, None), decisions_left: source.most_decisions };
    match episode::run_with(scenario, seed, rules, &mut crew, &mut |_, _| ()) {
        Ok(_) | Err(Stop::Enough) => {}
        Err(Stop::Failed(error)) => return Err(error),
    }
    Ok(Trajectory {
        source,
        scenario: scenario.name().to_owned(),
        scenario_digest,
        seed,
        terrain: Arc::new(scenario.terrain().clone()),
        moves: scenario.moves(),
        sensor: Arc::new(scenario.sensor().clone()),
        decisions: taken.try_iter().collect(),
    })
}

/// A crew that leaves when it has decided so many times.
struct Audience<'a> {
    crew: LocalCrew<'a>,
    decisions_left: u32,
}

enum Stop {
    Enough,
    Failed(MindError),
}

impl Crew for Audience<'_> {
    type Parcel = Message;
    type Error = Stop;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Result<Reaction<Message>, Stop> {
        if self.decisions_left == 0 {
            return Err(Stop::Enough);
        }
        let reaction = self.crew.step(who, now, stimulus).map_err(Stop::Failed)?;
        if reaction.decision.is_some() {
            self.decisions_left -= 1;
        }
        Ok(reaction)
    }

    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, Stop> {
        self.crew.digest(who, now).map_err(Stop::Failed)
    }
}
