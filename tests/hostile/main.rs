//! With any input, no participant panics, nothing impossible counts, and memory stays within its limits.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod alone;
mod messages;
mod scenarios;
mod spoil_bytes;
mod spoil_text;
mod world;

use std::path::Path;

use dragnet_proto::marks::Marks;
use dragnet_proto::replica::Replica;
use dragnet_proto::validation::Limits;
use dragnet_proto::verdict::Verdicts;
use dragnet_scenario::Scenario;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::observation::Ends;

/// A scenario from its text.
fn scenario(text: &str) -> Scenario {
    Scenario::from_text(Path::new("test.toml"), text.to_owned()).unwrap()
}

/// The evidence is that of the known observations, all of which are valid.
fn check(replica: &Replica, belief: &Belief, scenario: &Scenario, limits: &Limits) {
    let mut expected = scenario.prior().clone();
    for version in replica.log().versions().iter() {
        let known = replica.log().since(version.origin, 0);
        assert_eq!(known.len() as u64, version.next, "nothing is released");
        let mut before = None;
        for observation in known {
            let ends = before.map(|last| Ends { first: &known[0], last });
            assert_eq!(limits.check(observation, ends), Ok(()));
            observation.readings.iter().for_each(|reading| expected.add(reading));
            before = Some(&**observation);
        }
    }
    Verdicts::default().take(replica.knowledge().verdicts().iter(), &mut expected);
    let (marks, grid, prior) =
        (replica.knowledge().marks(), limits.terrain().grid(), expected.shared_prior());
    Marks::default().merge_into(MissionTime(u64::MAX), marks, grid, &prior, &mut expected);
    assert_eq!(belief.digest(), expected.digest());
}
