"""The same world as the command line's: path, belief and measures, to the bit."""

import csv
import json
import subprocess

import numpy as np
import pytest
from conftest import ROOT, SCENARIOS, small

import dragnet

SCENARIO = SCENARIOS / "ice_cream_cone.toml"


def play(policy: str, seed: int) -> tuple[dragnet.SearchEnv, dict]:
    """An episode as the robots of the field search."""
    env = dragnet.SearchEnv(SCENARIO, end="resting")
    decide = dragnet.Policy(policy, env.scenario, seed=seed)
    _, info = env.reset(seed=seed)
    over = False
    while not over:
        _, _, terminated, truncated, info = env.step(decide(env.belief()).waypoint)
        over = terminated or truncated
    return env, info


def run(program: str, folder, policy: str, seed: int) -> tuple[dict, dragnet.Recording]:
    recording = folder / f"{policy}-{seed}.mcap"
    command = [program, "run", SCENARIO, "--robots", "1", "--policy", policy, "--seed", str(seed), "--json"]
    done = subprocess.run([*command, "--record", recording], check=True, capture_output=True, text=True)
    return json.loads(done.stdout), dragnet.read_recording(recording)


@pytest.mark.parametrize(
    ("policy", "seeds"),
    [
        ("path", range(20)),
        ("greedy", range(2)),
        ("nats", range(2)),
        ("guts", [0]),
        ("random", range(2)),
        ("gnn", range(2)),
    ],
)
def test_an_episode_is_that_of_dragnet_run(program, tmp_path, policy, seeds):
    for seed in seeds:
        env, info = play(policy, seed)
        told, recording = run(program, tmp_path, policy, seed)
        assert env.path.tolist() == recording.path(1).tolist(), f"seed {seed}"
        assert env.digest == told["belief_digest"] == recording.digest
        assert info["f1"] == told["f1"]
        assert info["recall"] == told["recall"]
        assert info["path_cells"] == pytest.approx(told["path_cells"][0], abs=1e-9)
        assert info["time_seconds"] == told["mission_time_s"]


@pytest.mark.parametrize("moves", [4, 8])
def test_steps_along_the_way_to_waypoints_see_the_same(moves):
    """Steps that follow a policy's decisions see what a robot sees that goes to its waypoints."""
    scenario = small(moves=moves)
    far, near = dragnet.SearchEnv(scenario), dragnet.SearchEnv(scenario, control="step")
    decide = dragnet.Policy("path", scenario)
    far.reset(seed=4)
    near.reset(seed=4)
    over = False
    while not over:
        before = len(far.path)
        _, gain, terminated, truncated, _ = far.step(decide(far.belief()).waypoint)
        over = terminated or truncated
        gains = 0.0
        for start, end in zip(far.path[before - 1 : -1], far.path[before:], strict=True):
            rows, columns = np.divmod([start, end], scenario.shape[1])
            offset = (int(rows[1] - rows[0]), int(columns[1] - columns[0]))
            _, reward, *ends, _ = near.step(dragnet.OFFSETS[moves].index(offset))
            gains += reward
        assert gains == pytest.approx(gain, abs=1e-9)
        assert near.digest == far.digest
        assert any(ends) == over


def test_without_a_scenario_a_policy_takes_the_defaults():
    env = dragnet.SearchEnv(SCENARIO)
    env.reset(seed=2)
    belief = env.belief()
    for name in ("path", "greedy", "coverage", "nats", "guts", "gnn", "path-additive"):
        with_it, without = dragnet.Policy(name, env.scenario)(belief), dragnet.Policy(name)(belief)
        assert with_it.waypoint == without.waypoint
        assert np.allclose(with_it.scores, without.scores)
        assert with_it.scores.shape == env.scenario.shape
        assert with_it.path[-1] == with_it.waypoint


def test_a_comparison_is_that_of_dragnet_compare(program, tmp_path):
    policies = ["path", "path(path_length_weight=1)", "greedy", "random"]
    command = [
        program,
        "compare",
        SCENARIO,
        "--policies",
        ",".join(policies),
        "--seeds",
        "5",
        "--out",
        tmp_path / "out",
    ]
    subprocess.run(command, check=True, capture_output=True, cwd=ROOT)
    ours = dragnet.compare(SCENARIO, policies, seeds=5)
    for name, table in [("summary.csv", ours), ("differences.csv", ours.differences)]:
        theirs = list(csv.DictReader((tmp_path / "out" / name).read_text().splitlines()))
        assert table.columns == list(theirs[0])
        for mine, its in zip(csv.DictReader(table.to_csv().splitlines()), theirs, strict=True):
            for column in table.columns:
                if column.startswith("decision_ms"):
                    assert float(mine[column]) > 0.0
                elif column in ("scenario", "map", "policy", "baseline") or column.endswith("_verdict"):
                    assert mine[column] == its[column]
                else:
                    assert float(mine[column]) == float(its[column]), column
    assert [row["policy"] for row in ours.differences] == policies[1:]
    with pytest.raises(ValueError, match="baseline=tour; allowed are path, greedy"):
        dragnet.compare(SCENARIO, ["path", "greedy"], seeds=1, baseline="tour")
    fewer = dragnet.compare(SCENARIO, ["path"], seeds=[7, 8], robots=1, density=0.02, budget_cells=50)
    assert (fewer[0]["robots"], fewer[0]["seeds"], fewer[0]["budget_cells"]) == (1, 2, 50.0)


def test_a_recording_is_read_as_arrays(program, tmp_path):
    told, recording = run(program, tmp_path, "path", 3)
    assert recording.ending == "complete"
    assert recording.traversable.shape == recording.log_odds.shape == (30, 30)
    assert len(recording.observations["cell"]) == told["observations_sent"]
    assert np.all(np.diff(recording.observations["time_seconds"]) >= 0)
    readings = recording.readings
    assert set(np.unique(readings["observation"])) == set(range(told["observations_sent"]))
    first = readings["observation"] == 0
    assert recording.observations["cell"][0] in readings["cell"][first]
    llr = np.zeros(900)
    np.add.at(llr, readings["cell"], (readings["value"] - 0.5).astype(np.float64) / readings["variance"])
    with np.errstate(divide="ignore"):
        prior = np.log(recording.prior / (1.0 - recording.prior.astype(np.float64)))
    searched = recording.searched
    assert np.allclose(recording.log_odds[searched], (prior + llr.reshape(30, 30))[searched], atol=0.01)
    assert len(recording.plans) >= told["decisions"]
    found = np.flatnonzero(recording.log_odds.ravel() > np.log(0.95 / 0.05))
    assert set(recording.statuses[-1]["declared"]) == set(found)
    whole = (tmp_path / "path-3.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) * 3 // 4])
    cut = dragnet.read_recording(tmp_path / "cut.mcap")
    assert cut.ending != "complete"
    assert cut.summary == {}
