use std::path::Path;
use std::time::Duration;

use dragnet_scenario::Scenario;

use super::*;
use crate::single_robot_env::features::{Company, Frame, Order};
use crate::single_robot_env::{SingleRobotEnv, Terms};

fn field(robots: u32, rest: &str) -> Arc<Field> {
    let text = format!(
        "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 24, columns = 24, cell_meters = 20.0 }}\n\
         sensor.radius = 2\nobjects.count = 9\nrobots = {{ count = {robots}, start = 'scattered' }}\n{rest}"
    );
    Arc::new(Field::new(Scenario::from_text(Path::new("a.toml"), text).unwrap()))
}

/// The first available step of each robot, counting from a different one each time.
fn moves(env: &TeamEnv, turn: usize) -> Vec<Move> {
    let step = |place| {
        let open = |step| env.field().neighbor(env.cell(place), (step + turn / 3) % 4);
        Move::To((0..4).find_map(open).unwrap())
    };
    (0..env.termination_reasons().len()).map(step).collect()
}

fn run(field: &Arc<Field>, crashes: &BTreeMap<RobotId, MissionTime>) -> (TeamEnv, u32) {
    let mut env = TeamEnv::new(Arc::clone(field), Reward::Entropy, crashes, 3).unwrap();
    let (mut turn, mut differing) = (0, 0);
    while env.termination_reasons().contains(&TerminationReason::Searching) {
        env.step(&moves(&env, turn)).unwrap();
        turn += 1;
        differing += u32::from(env.belief(0).digest() != env.belief(1).digest());
    }
    (env, differing)
}

/// Drawn step by step, observations are those that are drawn anew, whatever the network loses or delays.
#[test]
fn what_is_drawn_anew_is_what_was_drawn_step_by_step() {
    let network = format!("{BUDGET}network = {{ loss = 0.5, delay_seconds = 15.0, duplication = 0.2 }}\n");
    for (order, frame) in
        [(Order::Planes, Frame::Map), (Order::Named, Frame::Robot), (Order::Nodes, Frame::Robot)]
    {
        let field = field(3, &network);
        let grid = field.scenario().terrain().grid();
        let (layout, known) = (Layout::new(order, frame, Company::Team, grid), Layout::of_team(grid));
        let mut env = TeamEnv::new(Arc::clone(&field), Reward::Entropy, &BTreeMap::new(), 3).unwrap();
        let mut kept = vec![vec![f32::NAN; layout.drawn_len()]; 3];
        let mut kept_known = vec![f32::NAN; known.drawn_len()];
        (0..3).for_each(|place| env.draw(place, &layout, &mut kept[place]));
        env.draw_known(&known, &mut kept_known);
        for turn in 0..40 {
            env.step(&moves(&env, turn)).unwrap();
            for (place, kept) in kept.iter_mut().enumerate() {
                env.redraw(place, &layout, kept);
                let mut anew = vec![f32::NAN; layout.drawn_len()];
                layout.draw(&field, &env.view(place, &env.teammates(place)), &mut anew);
                assert_eq!(*kept, anew);
            }
            // Not every time: what changed meanwhile is kept.
            if turn % 7 == 6 {
                env.redraw_known(&known, &mut kept_known);
                let view = View { belief: env.merged(), ..env.view(0, &[]) };
                let mut anew = vec![f32::NAN; known.drawn_len()];
                known.draw(&field, &view, &mut anew);
                assert_eq!(kept_known, anew);
            }
        }
        assert!(env.belief(0).digest() != env.belief(1).digest());
    }
}

#[test]
fn rewards_add_up_to_the_entropy_that_was_removed() {
    let field = field(3, BUDGET);
    let mut env = TeamEnv::new(Arc::clone(&field), Reward::Entropy, &BTreeMap::new(), 3).unwrap();
    let entropy = |env: &TeamEnv| env.merged().entropy_nats(field.scenario().terrain());
    let before = entropy(&env);
    let mut removed = 0.0;
    for turn in 0..30 {
        removed += env.step(&moves(&env, turn)).unwrap();
        assert!((before - entropy(&env) - removed).abs() < 1e-9);
    }
    assert!(removed > 1.0);
}

const BUDGET: &str = "mission.budget_meters = 900.0\n";

#[test]
fn without_faults_all_beliefs_are_equal_after_each_move() {
    let (env, differing) = run(&field(3, BUDGET), &BTreeMap::new());
    assert_eq!(differing, 0);
    assert_eq!(env.belief(2).digest(), env.merged().digest());
    assert_eq!(env.received(0, 1), Some(env.cell(1)));
}

#[test]
fn lost_and_late_observations_count_later() {
    let network = format!("{BUDGET}network = {{ loss = 0.5, delay_seconds = 15.0 }}\n");
    let (_, differing) = run(&field(3, &network), &BTreeMap::new());
    assert!(differing > 10, "{differing}");
}

#[test]
fn a_crashed_robot_is_out_and_the_others_go_on() {
    let at = MissionTime::START + Duration::from_secs(95);
    let (env, _) = run(&field(3, BUDGET), &BTreeMap::from([(RobotId::new(2).unwrap(), at)]));
    assert_eq!(env.termination_reasons()[1], TerminationReason::Crashed);
    // Ten seconds per cell: it had entered nine.
    assert!((env.path_cells(1) - 9.0).abs() < 1e-9);
    assert!(env.path_cells(0) > 10.0);
}

#[test]
fn a_team_of_one_sees_what_one_robot_sees() {
    let field = field(1, BUDGET);
    let terms = Terms { end: End::AllFound, reward: Reward::Entropy };
    let mut single = SingleRobotEnv::new(Arc::clone(&field), terms, 8);
    let mut env = TeamEnv::new(Arc::clone(&field), Reward::Entropy, &BTreeMap::new(), 8).unwrap();
    let mut turn = 0;
    while single.ended().is_none() {
        let moves = moves(&env, turn);
        let Move::To(cell) = moves[0] else { unreachable!() };
        let (one, team) = (single.step(cell), env.step(&moves).unwrap());
        assert_eq!(one.to_bits(), team.to_bits());
        assert_eq!(single.track(), env.track(0));
        assert_eq!(single.belief().digest(), env.belief(0).digest());
        assert_eq!(single.now(), env.now());
        turn += 1;
    }
    assert_ne!(env.termination_reasons()[0], TerminationReason::Searching);
    assert!(turn > 10);
}
