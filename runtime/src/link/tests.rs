use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_search::observation::RobotId;

use super::*;
use crate::session::{Endpoints, free_endpoints, open};

const TEXT: &str = "name = 'one'\nmap = { shape = 'all_traversable', rows = 12, columns = 12 }\nobjects.count = 1\n\
                    robots.count = 3\nmission = { budget_seconds = 1e6, detection_threshold = 0.95 }\n";

/// A participant with this scenario; with none it tells none.
async fn join(me: Participant, endpoints: &Endpoints, text: Option<&str>) -> Link {
    let scenario = Scenario::from_text(Path::new("one.toml"), text.unwrap_or(TEXT).to_owned()).unwrap();
    let session = open(endpoints).await.unwrap();
    let mut link = Link::join(session, "one".parse().unwrap(), me, Codec::of(&scenario)).await.unwrap();
    if text.is_some() {
        link.set_scenario(ScenarioDigest::of(&scenario));
    }
    link.announce().await.unwrap();
    link
}

/// How the scenarios of others differ, as a participant learns until these participants are there and so many differ.
async fn told(link: &mut Link, present: &[Participant], count: usize) -> Vec<(Participant, String)> {
    const PATIENCE: Duration = Duration::from_mins(1);
    let mut told = Vec::new();
    let mut take = |incoming| match incoming {
        Incoming::OtherScenario(participant, difference) => told.push((participant, difference.to_string())),
        other => panic!("{other:?}"),
    };
    link.wait_for(present, PATIENCE, &mut take).await.unwrap();
    // A participant that joins may learn that others are there before it learns their scenarios.
    while told.len() < count {
        let incoming = tokio::time::timeout(PATIENCE, link.receive()).await.unwrap();
        if let Some(Incoming::OtherScenario(participant, difference)) = incoming {
            told.push((participant, difference.to_string()));
        }
    }
    told
}

#[tokio::test(flavor = "multi_thread")]
async fn another_scenario_is_reported_on_both_sides_and_the_same_or_none_is_not() {
    let robot = |number| Participant::Robot(RobotId::new(number).unwrap());
    let all = free_endpoints(5).unwrap();
    // Each connects to all before it.
    let place = |place: usize| Endpoints {
        listen: vec![all[place].clone()],
        connect: all[..place].to_vec(),
        ..Endpoints::default()
    };
    let mut coordinator = join(Participant::Coordinator, &place(0), Some(TEXT)).await;
    let mut same = join(robot(1), &place(1), Some(&TEXT.replace("'one'", "'copy'"))).await;
    let _silent = join(robot(2), &place(2), None).await;
    let present = [Participant::Coordinator, robot(1), robot(2)];
    assert_eq!(told(&mut coordinator, &present[1..], 0).await, []);
    assert_eq!(told(&mut same, &[present[0], present[2]], 0).await, []);

    let mut wrong = join(robot(3), &place(3), Some(&TEXT.replace("0.95", "0.9"))).await;
    let what = "another detection threshold or rate of radios".to_owned();
    assert_eq!(told(&mut coordinator, &[robot(3)], 1).await, [(robot(3), what.clone())]);
    assert_eq!(told(&mut same, &[robot(3)], 1).await, [(robot(3), what.clone())]);
    let mut of_all = told(&mut wrong, &present, 2).await;
    of_all.sort();
    assert_eq!(of_all, [(robot(1), what.clone()), (Participant::Coordinator, what)]);

    // It is reported once, and no more after a start with the right scenario.
    drop(wrong);
    let again = Duration::from_secs(1);
    while let Ok(incoming) = tokio::time::timeout(again, coordinator.receive()).await {
        assert!(matches!(incoming, Some(Incoming::Left(..))), "{incoming:?}");
    }
    let _right = join(robot(3), &place(4), Some(TEXT)).await;
    assert_eq!(told(&mut coordinator, &[robot(3)], 0).await, []);
}
