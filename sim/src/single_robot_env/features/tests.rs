use std::path::Path;
use std::sync::Arc;

use dragnet_scenario::Scenario;

use super::*;
use crate::simulation::End;
use crate::single_robot_env::{Control, Reward, SingleRobotEnv, Terms};

/// Rooms of 3 x 4 cells, the eastern one out of reach, with a corridor that is not searched.
fn field() -> Arc<Field> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.txt"), "..#.\n.,#.\n..#.\n").unwrap();
    let text = "name = 'a'\nmap = { file = 'a.txt', cell_meters = 10.0 }\nsensor.radius = 1\n\
                prior.probability = 0.25\nobjects.cells = [[2, 0], [0, 3]]\nrobots.start = [0, 1]\n\
                mission.budget_meters = 80.0\n";
    Arc::new(Field::new(Scenario::from_text(&folder.path().join("a.toml"), text.to_owned()).unwrap()))
}

fn env(field: &Arc<Field>) -> SingleRobotEnv {
    SingleRobotEnv::new(Arc::clone(field), Terms { end: End::AllFound, reward: Reward::Found }, 1)
}

fn layouts(field: &Field) -> Vec<Layout> {
    let grid = field.scenario().terrain().grid();
    let mut layouts = Vec::new();
    for order in [Order::Planes, Order::Named, Order::Nodes] {
        for frame in [Frame::Map, Frame::Robot] {
            for company in [Company::Alone, Company::Team] {
                layouts.push(Layout::new(order, frame, company, grid));
            }
        }
    }
    layouts
}

/// A feature of each cell, rows from the north, in tenths.
fn picture(layout: &Layout, numbers: &[f32], feature: Feature) -> String {
    let (rows, columns) = layout.shape();
    let at = |row: usize, column: usize| {
        let channel = layout.features().iter().position(|&it| it == feature).unwrap();
        match layout.order {
            Order::Planes | Order::Named => numbers[(channel * rows + row) * columns + column],
            Order::Nodes => numbers[(row * columns + column) * layout.features().len() + channel],
        }
    };
    let line = |row: usize| -> String {
        let cells: Vec<String> =
            (0..columns).map(|column| format!("{:>3}", (at(row, column) * 10.0).round())).collect();
        cells.concat()
    };
    (0..rows).rev().map(|row| line(row) + "\n").collect()
}

#[test]
fn features_are_what_they_say_in_both_orders() {
    let field = field();
    for order in [Order::Planes, Order::Nodes] {
        let layout = Layout::new(order, Frame::Map, Company::Team, field.scenario().terrain().grid());
        let mut numbers = vec![f32::NAN; layout.len()];
        let env = env(&field);
        let teammates = [field.scenario().terrain().grid().cell_numbered(8).unwrap()];
        layout.draw(&field, &View { teammates: &teammates, budget: 0.5, ..env.view() }, &mut numbers);
        let check = |feature, expected: &str| {
            assert_eq!(picture(&layout, &numbers, feature), expected, "{order:?} {feature:?}");
        };
        // Seen from [0, 1]: itself and its neighbors. What was not seen has its prior.
        check(Feature::Probability, "  3  3  0  3\n  3  0  0  3\n  0  0  0  3\n");
        check(Feature::Entropy, "  8  8  0  8\n  8  0  0  8\n  0  0  0  8\n");
        check(Feature::Observed, "  0  0  0  0\n  0  5  0  0\n  5  8  5  0\n");
        check(Feature::Traversable, " 10 10  0 10\n 10 10  0 10\n 10 10  0 10\n");
        check(Feature::Searched, " 10 10  0 10\n 10  0  0 10\n 10 10  0 10\n");
        // h is 3.5: 1 / 4.5, 2 / 5.5, 3 / 6.5.
        check(Feature::Distance, "  5  4 10 10\n  4  2 10 10\n  2  0 10 10\n");
        check(Feature::Robot, "  0  0  0  0\n  0  0  0  0\n  0 10  0  0\n");
        check(Feature::Budget, "  5  5  5  5\n  5  5  5  5\n  5  5  5  5\n");
        check(Feature::Teammates, " 10  0  0  0\n  0  0  0  0\n  0  0  0  0\n");
        if order == Order::Nodes {
            check(Feature::Row, "  5  5  5  5\n  3  3  3  3\n  0  0  0  0\n");
            check(Feature::Column, "  0  3  5  8\n  0  3  5  8\n  0  3  5  8\n");
        }
    }
}

#[test]
fn the_robot_is_in_the_middle_of_its_own_frame() {
    let field = field();
    let grid = field.scenario().terrain().grid();
    let env = env(&field);
    let planes = Layout::new(Order::Planes, Frame::Robot, Company::Alone, grid);
    let mut drawn = vec![f32::NAN; planes.drawn_len()];
    let mut numbers = vec![f32::NAN; planes.len()];
    planes.draw(&field, &env.view(), &mut drawn);
    planes.center(&env.view(), &drawn, &mut numbers);
    let open = "  0  0 10 10  0 10  0\n  0  0 10 10  0 10  0\n  0  0 10 10  0 10  0\n\
                \u{20} 0  0  0  0  0  0  0\n  0  0  0  0  0  0  0\n";
    assert_eq!(picture(&planes, &numbers, Feature::Traversable), open);
    let robot = picture(&planes, &numbers, Feature::Robot);
    assert_eq!(robot.lines().nth(2).unwrap(), "  0  0  0 10  0  0  0");
    let last = picture(&planes, &numbers, Feature::Distance);
    assert_eq!(last.lines().last().unwrap(), " 10 10 10 10 10 10 10", "beyond the edge is out of reach");
    let nodes = Layout::new(Order::Nodes, Frame::Robot, Company::Alone, grid);
    let mut numbers = vec![f32::NAN; nodes.len()];
    nodes.draw(&field, &env.view(), &mut numbers);
    assert_eq!(picture(&nodes, &numbers, Feature::Column), " -3  0  3  5\n -3  0  3  5\n -3  0  3  5\n");
}

#[test]
fn updated_features_equal_new_ones_and_all_are_in_their_range() {
    let text = "name = 'a'\nmap = { shape = 'ice_cream_cone', rows = 14, columns = 11, cell_meters = 30.0 }\n\
                sensor.radius = 3\nobjects.count = 4\nmission.budget_meters = 900.0\n";
    let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
    let field = Arc::new(Field::new(scenario));
    for layout in layouts(&field) {
        let mut env = env(&field);
        let mut kept = vec![f32::NAN; layout.drawn_len()];
        env.draw(&layout, &mut kept);
        let mut turn = 0;
        while env.ended().is_none() {
            let open = (0..4).find_map(|step| field.neighbor(env.cell(), (step + turn / 3) % 4));
            env.step(open.unwrap());
            // Several steps between two drawings.
            if turn % 4 != 1 {
                env.redraw(&layout, &mut kept);
                let mut anew = vec![f32::NAN; layout.drawn_len()];
                env.clone().draw(&layout, &mut anew);
                assert_eq!(kept, anew, "{layout:?}");
                assert!(kept.iter().all(|number| (-1.0..=1.0).contains(number)));
            }
            turn += 1;
        }
        assert!(turn > 20);
        assert!(env.budget() < 0.05);
    }
}

#[test]
fn every_belief_has_features_from_0_to_1() {
    for step in -30_000..=30_000 {
        let log_odds = f64::from(step) / 100.0;
        let (probability, entropy) = probability_and_entropy(log_odds);
        let exact = dragnet_search::belief::probability(log_odds);
        assert!((f64::from(probability) - exact).abs() < 1e-7, "{log_odds}");
        assert!((0.0..=1.0).contains(&probability) && (0.0..=1.0).contains(&entropy), "{log_odds}");
    }
    for infinite in [f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(probability_and_entropy(infinite).1.to_bits(), 0.0_f32.to_bits());
    }
}

#[test]
fn a_mask_is_1_where_an_action_has_a_target() {
    let field = field();
    let grid = field.scenario().terrain().grid();
    for control in [Control::Waypoint, Control::Step] {
        let mut met = [0, 0];
        for from in grid.cells() {
            let mut mask = vec![7; field.action_count(control)];
            field.draw_mask(control, from, &mut mask);
            for (action, &is_open) in mask.iter().enumerate() {
                let target = field.target(control, from, action);
                assert_eq!(is_open, i8::from(target.is_some()), "{control:?} {from:?} {action}");
                met[usize::from(target.is_some())] += 1;
            }
        }
        assert!(met[0] > 0 && met[1] > 0);
    }
}
