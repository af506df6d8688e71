"""Policies of one's own meet the same searches as ours."""

import numpy as np
import pandas
import pytest
from conftest import small

import dragnet


def without_times(table):
    return [{name: value for name, value in row.items() if not name.startswith("decision_ms")} for row in table]


class Ours:
    """A policy of ours as anybody could have written it."""

    def __init__(self, name, scenario, control="waypoint"):
        self.policy = dragnet.Policy(name, scenario)
        self.control = control
        self.seeds = []

    def reset(self, seed):
        self.seeds.append(seed)
        self.policy.reset(seed)

    def __call__(self, belief, mask):
        decision = self.policy(belief)
        assert mask.shape == ((4,) if self.control == "step" else (14 * 12,))
        if decision.step is None:
            return None
        return decision.step if self.control == "step" else np.array(decision.waypoint)


@pytest.mark.parametrize("name", ["greedy", "path", "random"])
def test_a_callable_has_the_trials_of_the_policy_that_it_is(name):
    """Objects, starts, noise and statistics are the same, to the bit."""
    scenario = small(budget_cells=60)
    mine = Ours(name, scenario)
    table = dragnet.compare(
        scenario, {"mine": mine, name: name}, seeds=[3, 5, 8, 9], baseline=name, robots=1, observation="belief"
    )
    assert mine.seeds == [3, 5, 8, 9]
    first, second = without_times(table)
    assert first.pop("policy") == "mine"
    assert second.pop("policy") == name
    assert first == second
    (difference,) = table.differences
    assert (difference["policy"], difference["baseline"]) == ("mine", name)
    for measure in ("cells_to_full_recall", "average_recall", "auc_f1"):
        assert difference[f"{measure}_mean"] == difference[f"{measure}_low"] == difference[f"{measure}_high"] == 0.0
        assert difference[f"{measure}_verdict"] is None


def test_a_callable_decides_step_by_step():
    scenario = small("robots.policy = { name = 'path', replan_after_cells = 1 }", budget_cells=60)
    table = dragnet.compare(
        scenario, {"mine": Ours("path", scenario, "step")}, seeds=4, observation="belief", control="step"
    )
    # A policy named in the scenario keeps its parameters there only: ours decides anew in every cell, too.
    alone = dragnet.SearchEnv(scenario, control="step")
    reached = []
    for seed in range(4):
        _, info = alone.reset(seed=seed)
        policy = dragnet.Policy("path", scenario, seed=seed)
        over = False
        while not over:
            step = policy(alone.belief()).step
            if step is None:
                break
            *_, terminated, truncated, info = alone.step(step)
            over = terminated or truncated
        if alone.termination_reason == "found":
            reached.append(info["path_cells"])
    assert table[0]["cells_to_full_recall_reached"] == len(reached) > 0
    assert table[0]["cells_to_full_recall_mean"] == pytest.approx(np.mean(reached))


@pytest.mark.parametrize("kind", ["dict", "planes", "graph", "belief"])
@pytest.mark.parametrize("frame", ["map", "robot"])
@pytest.mark.parametrize("control", ["step", "waypoint"])
def test_a_callable_sees_what_the_environment_shows(kind, frame, control):
    scenario = small(budget_cells=30)
    choices = {"observation": kind, "frame": frame, "control": control}
    env = dragnet.SearchEnv(scenario, **choices)
    expected, info = env.reset(seed=6)
    turn = 0

    def decide(observation, mask):
        nonlocal expected, info, turn
        assert np.array_equal(mask, info["action_mask"])
        if isinstance(observation, dict):
            assert list(observation) == list(expected)
            for name, part in observation.items():
                assert np.array_equal(part, expected[name]), name
        else:
            assert np.array_equal(observation, expected)
        assert observation in env.observation_space
        turn += 1
        action = np.flatnonzero(mask)[turn * 7 % int(mask.sum())]
        expected, *_, info = env.step(action)
        return action

    dragnet.compare(scenario, {"mine": decide}, seeds=[6], **choices)
    assert turn > 3
    assert env.termination_reason is not None


def test_robots_of_a_team_ask_one_callable_each_with_its_own_observation():
    places = []

    def decide(observation, mask):
        places.append(observation["position"].tolist())
        return int(np.flatnonzero(mask)[len(places) % int(mask.sum())])

    table = dragnet.compare(small(budget_cells=20), {"mine": decide, "tour": "tour"}, seeds=2, robots=3)
    assert [(row["policy"], row["robots"]) for row in table] == [("mine", 3), ("tour", 3)]
    assert len({tuple(place) for place in places[:3]}) == 3, "three starts"


def test_one_that_rests_ends_its_search_and_counts_as_its_budget():
    table = dragnet.compare(small(budget_cells=33), {"idle": lambda observation, mask: None}, seeds=3)
    assert table[0]["cells_to_full_recall_reached"] == 0
    assert table[0]["cells_to_full_recall_restricted_mean"] == 33.0
    assert table[0]["cells_to_full_recall_mean"] is None


def test_a_mapping_names_policies_and_scenarios_keep_their_order():
    scenarios = [small(budget_cells=20), dragnet.Scenario.load("paper/figure_four").with_budget_cells(20)]
    table = dragnet.compare(scenarios, {"a": "greedy", "b": "path(path_length_weight=1)"}, seeds=2, baseline="b")
    assert [(row["scenario"], row["policy"]) for row in table] == [
        (scenario.name, name) for scenario in scenarios for name in "ab"
    ]
    assert [(row["policy"], row["baseline"]) for row in table.differences] == [("a", "b")] * 2
    plain = dragnet.compare(scenarios, ["greedy", "path(path_length_weight=1)"], seeds=2)
    drop = {"policy"}
    assert [[value for name, value in row.items() if name not in drop] for row in without_times(table)] == [
        [value for name, value in row.items() if name not in drop] for row in without_times(plain)
    ]


def test_a_table_is_a_data_frame():
    table = dragnet.compare(small(), ["greedy", "random"], seeds=2)
    frame = table.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == table.columns
    assert frame.set_index("policy").loc["random", "auc_f1_mean"] == table[1]["auc_f1_mean"]
