"""Pictures: arrays, windows and plots, and the tables of recordings."""

import importlib
import pickle
import subprocess
import sys

import gymnasium as gym
import matplotlib
import numpy as np
import pandas
import pytest
from conftest import small
from gymnasium.utils.env_checker import check_env

import dragnet
from dragnet.legend import legend
from dragnet.picture import SCALE
from dragnet.plan import shortest_path

matplotlib.use("agg")

BLUE = [31, 119, 180]


@pytest.fixture(scope="module")
def recording(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("recording")
    arguments = ["run", "ice_cream_cone", "--over", "memory", "--seed", "3", "--record", "search.mcap"]
    subprocess.run([program, *arguments], check=True, cwd=folder, capture_output=True)
    return folder / "search.mcap"


def pixel(image, scenario, cell, down=0, right=0):
    """A pixel of a cell, from its middle; the north is on top."""
    rows, columns = scenario.shape
    row, column = divmod(int(cell), columns)
    return image[(rows - 1 - row) * SCALE + SCALE // 2 + down, column * SCALE + SCALE // 2 + right].tolist()


def test_a_picture_shows_walls_paths_and_objects_with_the_north_on_top():
    env = dragnet.SearchEnv(small(), render_mode="rgb_array")
    env.reset(seed=1)
    image = env.render()
    rows, columns = env.scenario.shape
    assert image.dtype == np.uint8
    assert image.shape[0] > rows * SCALE, "a legend below"
    assert image.shape[1:] == (columns * SCALE, 3)
    assert pixel(image, env.scenario, env.path[-1]) == BLUE
    blocked = np.flatnonzero(~env.scenario.traversable)
    assert len(blocked)
    assert max(pixel(image, env.scenario, blocked[0])) < 80


def test_a_legend_has_as_many_lines_as_its_width_makes_of_it():
    sample = np.zeros((SCALE, SCALE, 3), dtype=np.uint8)
    entries = [("ROBOT 1", sample), ("BLOCKED", sample)]
    wide, narrow = legend(entries, 300), legend(entries, 80)
    assert wide.shape[1:] == (300, 3)
    assert narrow.shape == (2 * wide.shape[0], 80, 3)
    assert (narrow[: wide.shape[0]] == 0).any()
    assert (narrow[wide.shape[0] :] == 0).any()


def test_pictures_of_an_episode_have_one_size():
    env = dragnet.SearchEnv(small(), render_mode="rgb_array", control="step")
    _, info = env.reset(seed=1)
    sizes = {env.render().shape}
    for _ in range(5):
        *_, info = env.step(int(info["action_mask"].argmax()))
        sizes.add(env.render().shape)
    assert len(sizes) == 1


@pytest.mark.parametrize("moves", [4, 8])
def test_the_planned_path_is_the_one_that_the_robot_then_takes(moves):
    env, random = dragnet.SearchEnv(small(moves=moves)), np.random.default_rng(0)
    longest = 0
    for seed in range(8):
        env.reset(seed=seed)
        while env.termination_reason is None:
            goal = int(random.choice(np.flatnonzero(env.action_masks())))
            path = shortest_path(env.belief()["distance"], moves, goal)
            passed = len(env.path)
            env.step(goal)
            taken = env.path[passed:]
            assert path[: len(taken)].tolist() == taken.tolist()
            longest = max(longest, len(taken))
    assert longest > 6
    out_of_reach = int(np.flatnonzero(~env.scenario.traversable)[0])
    assert len(shortest_path(env.belief()["distance"], moves, out_of_reach)) == 0


def test_the_plan_that_a_policy_has_is_shown_until_the_robot_leaves_it():
    env = dragnet.SearchEnv(small(), control="step", render_mode="rgb_array")
    env.reset(seed=1)
    bare = env.render()
    decision = dragnet.Policy("path", env.scenario, seed=1)(env.belief())
    assert len(decision.path) > 2
    env.show_plan(decision.path)
    shown = env.render()
    # An arm of the goal's cross, and a dot on the way there.
    assert pixel(shown, env.scenario, decision.waypoint, 2, 2) == BLUE
    assert pixel(bare, env.scenario, decision.waypoint, 2, 2) != BLUE
    assert pixel(shown, env.scenario, decision.path[0]) == BLUE
    env.step(decision.step)
    assert pixel(env.render(), env.scenario, decision.waypoint, 2, 2) == BLUE
    aside = next(step for step in np.flatnonzero(env.action_masks()) if step != decision.step)
    for step in (aside, aside):
        env.step(int(step))
    assert pixel(env.render(), env.scenario, decision.waypoint, 2, 2) != BLUE
    env.show_plan(decision.path)
    env.reset(seed=1)
    assert np.array_equal(env.render(), bare)


def test_a_robot_on_its_way_to_a_waypoint_has_a_goal_alone_and_in_a_batch():
    scenario = small()
    choices = {"robots": 2, "control": "waypoint", "render_mode": "rgb_array"}
    env, envs = dragnet.parallel_env(scenario, **choices), dragnet.TeamVectorEnv(scenario, 2, **choices)
    env.reset(seed=5)
    envs.reset(seed=5)
    distance = env.belief("robot_1")["distance"]
    goal = int(np.where(np.isfinite(distance), distance, 0).argmax())
    for _ in range(3):
        env.step({"robot_1": goal, "robot_2": goal})
        envs.step(np.full((2, 2), goal))
    image = env.render()
    assert pixel(image, scenario, goal, 2, 2) != pixel(image, scenario, goal, 0, 4), "a cross"
    assert np.array_equal(envs.render()[0], image)
    envs.reset(seed=5)
    env.reset(seed=5)
    assert np.array_equal(envs.render()[0], env.render())


def test_cells_of_a_plan_that_are_none_are_refused():
    env = dragnet.SearchEnv(small())
    env.reset(seed=0)
    with pytest.raises(ValueError, match="cell 168; allowed are 0 to 167"):
        env.show_plan([3, 168])
    with pytest.raises(TypeError, match="dtype float64"):
        env.show_plan([0.5])


def pygame():
    return importlib.import_module("pygame")


@pytest.mark.filterwarnings("error")
def test_a_window_shows_the_picture_after_each_step(monkeypatch):
    monkeypatch.setitem(dragnet.SearchEnv.metadata, "render_fps", 1000)
    env = gym.make("dragnet/Search-v0", scenario=small(), render_mode="human", control="step")
    _, info = env.reset(seed=1)
    *_, info = env.step(int(info["action_mask"].argmax()))
    pictured = dragnet.SearchEnv(small(), render_mode="rgb_array", control="step")
    _, info = pictured.reset(seed=1)
    pictured.step(int(info["action_mask"].argmax()))
    on_screen = pygame().surfarray.array3d(pygame().display.get_surface()).swapaxes(0, 1)
    assert np.array_equal(on_screen, pictured.render())
    assert env.render() is None
    env.close()
    env.close()
    assert pygame().display.get_surface() is None


@pytest.mark.filterwarnings("error")
def test_gymnasium_accepts_the_environment_with_a_window(monkeypatch):
    monkeypatch.setitem(dragnet.SearchEnv.metadata, "render_fps", 1000)
    check_env(gym.make("dragnet/Search-v0", scenario=small(), render_mode="human").unwrapped)


def test_a_team_has_a_window_and_copies_have_none():
    env = dragnet.parallel_env(small(), robots=2, render_mode="human")
    env.reset(seed=0)
    assert pygame().display.get_surface() is not None
    for twin in (env.clone(), pickle.loads(pickle.dumps(env))):
        assert twin.render_mode is None
        assert twin.digests == env.digests
        twin.close()
    assert pygame().display.get_surface() is not None
    env.close()


def test_a_window_without_pygame_and_one_of_many_environments_are_refused(monkeypatch):
    with pytest.raises(ValueError, match='render_mode="human"; allowed are None and "rgb_array"'):
        dragnet.SearchVectorEnv(small(), 2, render_mode="human")
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(gym.error.DependencyNotInstalled, match=r"pip install 'dragnet\[human\]'"):
        dragnet.SearchEnv(small(), render_mode="human")


def test_a_recording_is_plotted_with_belief_paths_and_finds(recording, tmp_path):
    axes = dragnet.plot(recording)
    assert {text.get_text() for text in axes.get_legend().get_texts()} == {"robot 1", "robot 2", "robot 3", "declared"}
    axes.figure.savefig(tmp_path / "search.png")
    assert (tmp_path / "search.png").read_bytes().startswith(b"\x89PNG")
    read = dragnet.read_recording(recording)
    again = matplotlib.figure.Figure().subplots()
    assert dragnet.plot(read, again) is again
    x, y = axes.lines[0].get_data()
    assert (x[-1], y[-1]) == read.position(read.path(1)[-1])
    with pytest.raises(TypeError, match="recording of type int; allowed is a Recording or the path of a file"):
        dragnet.plot(3)


def test_a_recording_is_read_as_tidy_data_frames(recording):
    read = dragnet.read_recording(recording)
    tables = ("cells", "observations", "readings", "plans", "heartbeats", "statuses", "declared")
    frames = {name: read.to_pandas(name) for name in tables}
    for name, frame in frames.items():
        assert isinstance(frame, pandas.DataFrame)
        assert len(frame) > 0, name
        assert not frame.isna().any(axis=None), name
    assert len(frames["cells"]) == read.traversable.size
    assert len(frames["readings"]) == len(read.readings["value"])
    assert len(frames["plans"]) == sum(len(plan["path"]) for plan in read.plans)
    assert len(frames["heartbeats"]) == len(read.heartbeats)
    seen = frames["readings"].groupby("observation").first()
    assert np.array_equal(seen["observed_from"], read.observations["cell"][seen.index])
    last = frames["declared"][frames["declared"]["time_seconds"] == frames["statuses"]["time_seconds"].iloc[-1]]
    assert set(last["cell"]) == set(read.statuses[-1]["declared"])
    placed = last.merge(frames["cells"], on="cell", suffixes=("", "_at_the_end"))
    assert np.allclose(placed["probability"], placed["probability_at_the_end"], atol=1e-4)
    assert tuple(placed[["x_meters", "y_meters"]].iloc[0]) == read.position(int(placed["cell"].iloc[0]))
    with pytest.raises(ValueError, match='table "reading"; allowed are "cells", "observations", "readings"'):
        read.to_pandas("reading")
