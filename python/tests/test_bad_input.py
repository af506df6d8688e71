"""Whatever comes in, an exception says what is wrong with it; the interpreter lives on."""

import threading
from typing import get_args

import numpy as np
import pytest
from conftest import SCENARIOS, small

import dragnet
from dragnet import choices


def refused(error, message, call, *arguments, **named):
    with pytest.raises(error, match=message):
        call(*arguments, **named)


def test_scenarios():
    refused(FileNotFoundError, "nothing.toml", dragnet.SearchEnv, "nothing.toml")
    refused(TypeError, "scenario of type int", dragnet.SearchEnv, 3)
    refused(ValueError, "line 1: missing field `map`", dragnet.Scenario.from_text, "name = ''")
    refused(ValueError, "line 2", dragnet.Scenario.from_text, "name = 'a'\nmap = 7")
    refused(ValueError, "robots.count", small().with_robots, 0)
    refused(ValueError, "density", small().with_density, float("nan"))
    refused(OverflowError, r"(?s)out of range.*count", small().with_robots, -1)
    refused(TypeError, "Scenario.load", dragnet.Scenario, "a.toml")


@pytest.mark.parametrize("name", ["control", "reward", "end", "masked_action", "observation", "frame", "render_mode"])
def test_choices(name):
    for make in (dragnet.SearchEnv, dragnet.SearchVectorEnv):
        refused(ValueError, f'{name}="sideways"; allowed are', make, small(), **{name: "sideways"})
    if name != "end":
        for make in (dragnet.parallel_env, dragnet.TeamVectorEnv):
            refused(ValueError, f'{name}="sideways"; allowed are', make, small(), **{name: "sideways"})


def test_the_types_of_choices_are_the_choices():
    """A checker of types allows what is allowed, and nothing else."""
    literals = {
        "control": choices.Control,
        "reward": choices.Reward,
        "end": choices.End,
        "masked_action": choices.MaskedAction,
        "observation": choices.ObservationKind,
        "frame": choices.Frame,
    }
    for name, literal in literals.items():
        for value in get_args(literal):
            dragnet.SearchEnv(small(), **{name: value})
        allowed = {f'"{value}"' for value in get_args(literal)}
        with pytest.raises(ValueError, match=name) as raised:
            dragnet.SearchEnv(small(), **{name: ""})
        assert set(str(raised.value).partition("allowed are ")[2].split(", ")) == allowed


@pytest.mark.parametrize("control", ["waypoint", "step"])
def test_actions(control):
    env = dragnet.SearchEnv(small(), control=control, masked_action="error")
    refused(RuntimeError, "before the first reset", env.step, 0)
    _, info = env.reset(seed=0)
    seed = 0
    while info["action_mask"].all():
        seed += 1
        _, info = env.reset(seed=seed)
    masked = int(np.flatnonzero(info["action_mask"] == 0)[0])
    before = env.digest
    refused(ValueError, f"action {masked}: it is masked", env.step, masked)
    for action in (-1, env.action_space.n, 2**62):
        refused(ValueError, "no such action", env.step, action)
    for action in (1.0, "1", None, float("nan"), np.array([1, 2])):
        refused(TypeError, "allowed is an integer", env.step, action)
    refused(OverflowError, "too large", env.step, 2**70)
    assert env.digest == before, "nothing happened"
    for seed in (-1, 2**64):
        refused((ValueError, Exception), "seed|[Ss]eed", env.reset, seed=seed)


def test_options_are_refused_by_name():
    refused(ValueError, "option 'map'; allowed is none", dragnet.SearchEnv(small()).reset, options={"map": 1})
    env = dragnet.SearchVectorEnv(small(), 2)
    refused(ValueError, "option 'mask'; allowed is reset_mask", env.reset, options={"mask": 1})
    for mask in ([True, False], np.array([1, 0]), np.array([True])):
        refused(ValueError, r"array of booleans of shape \(2,\)", env.reset, options={"reset_mask": mask})
    refused(ValueError, "at least one", env.reset, options={"reset_mask": np.zeros(2, dtype=bool)})
    refused(RuntimeError, "first reset", env.reset, options={"reset_mask": np.array([True, False])})
    env.reset(options={"reset_mask": np.ones(2, dtype=bool)})
    env.reset(options={})
    with pytest.warns(UserWarning, match="option 'mask' has no effect"):
        dragnet.parallel_env(small()).reset(options={"mask": 1})


def test_steps_after_the_end():
    env = dragnet.SearchEnv(small(budget_cells=3), control="step")
    _, info = env.reset(seed=0)
    over = False
    while not over:
        *_, terminated, truncated, info = env.step(int(np.argmax(info["action_mask"])))
        over = terminated or truncated
    refused(RuntimeError, "after the end", env.step, 0)
    env.reset()
    team = dragnet.parallel_env(small())
    refused(RuntimeError, "call reset", team.step, {})


def test_vectors():
    refused(ValueError, "num_envs=0", dragnet.SearchVectorEnv, small(), 0)
    env = dragnet.SearchVectorEnv(small(), 3, control="step")
    refused(RuntimeError, "before the first reset", env.step, [0, 0, 0])
    _, info = env.reset(seed=0)
    refused(ValueError, r"shape \(2,\)", env.step, [0, 0])
    refused(ValueError, r"shape \(3, 1\)", env.step, np.zeros((3, 1), dtype=np.int64))
    refused(TypeError, "dtype float64", env.step, np.zeros(3))
    refused(TypeError, "dtype float64", env.step, [0, 1, np.nan])
    good = info["action_mask"].argmax(axis=1)
    before = [env._native.digest(place) for place in range(3)]
    refused(ValueError, "environment 1.*no such action", env.step, [good[0], 9, good[2]])
    assert [env._native.digest(place) for place in range(3)] == before, "no lane has moved"
    refused(ValueError, "2 seeds", env.reset, seed=[1, 2])
    observation, info = env.reset()
    good = info["action_mask"].argmax(axis=1)
    observation["action_mask"].flags.writeable = False
    refused(RuntimeError, "cannot be written", env.step, good)


def test_teams():
    stranger = "robot 7; allowed are the robots' numbers, 1 to 2"
    refused(ValueError, stranger, dragnet.parallel_env, small(), robots=2, crashes={7: 1.0})
    refused(ValueError, "seconds", dragnet.parallel_env, small(), robots=2, crashes={1: float("nan")})
    env = dragnet.parallel_env(small(), robots=2, masked_action="error")
    env.reset(seed=0)
    refused(KeyError, "robot_3", env.observation_space, "robot_3")
    refused(KeyError, "robot_3", env.belief, "robot_3")
    refused(ValueError, "allowed is one for each", env.step, {"robot_1": 0})
    refused(ValueError, "allowed is one for each", env.step, {"robot_1": 0, "robot_2": 0, "robot_3": 0})
    refused(TypeError, "action of robot_2", env.step, {"robot_1": 0, "robot_2": 0.5})
    refused(ValueError, "robot_1.*action 99", env.step, {"robot_1": 99, "robot_2": 0})


def test_vectors_of_teams():
    for count, error in ((0, ValueError), (-1, ValueError), (2.5, TypeError), ("two", TypeError)):
        for make in (dragnet.TeamVectorEnv, dragnet.SearchVectorEnv):
            refused(error, f"num_envs.*{count}.*; allowed is", make, small(), count)
    for make in (dragnet.TeamVectorEnv, dragnet.SearchVectorEnv):
        refused((MemoryError, ValueError), "num_envs|allocate|too big|too large", make, small(), 2**44)
    refused(ValueError, "robots.count", dragnet.TeamVectorEnv, small(), robots=0)
    refused(ValueError, "robot 7; allowed are", dragnet.TeamVectorEnv, small(), robots=2, crashes={7: 1.0})
    refused(TypeError, "scenario of type int", dragnet.TeamVectorEnv, 3)
    env = dragnet.TeamVectorEnv(small(), 3, robots=2, masked_action="error")
    refused(RuntimeError, "before the first reset", env.step, np.zeros((3, 2), dtype=int))
    refused(RuntimeError, "before the first reset", env.state)
    refused(RuntimeError, "before the first reset", env.belief)
    _, infos = env.reset(seed=0)
    good = infos["action_mask"].argmax(axis=2)
    before = [env._native.digests(place) for place in range(3)]
    shape = r"; allowed is \(3, 2\)"
    for wrong in (0, [0, 0, 0], good.T, good[:, :1], good[..., None], np.zeros((3, 3), dtype=int)):
        refused(ValueError, f"actions of shape .*{shape}", env.step, wrong)
    refused(ValueError, f"rows of different lengths.*{shape[2:]}", env.step, [[0, 0], [0], [0, 0]])
    for wrong in (good.astype(float), [[0, 0], [0, np.nan], [0, 0]], good > 0, [[0, 0], [None, 0], [0, 0]]):
        refused(TypeError, "actions of dtype .*; allowed are integers", env.step, wrong)
    refused(TypeError, "dtype .U.*; allowed are integers", env.step, [["0", "0"]] * 3)
    for action in (-1, 4, 2**62):
        wrong = good.copy()
        wrong[1, 1] = action
        where = r"environment 1, robot_2 at row \d+, column \d+"
        refused(ValueError, f"{where}: action {action}: no such action: they are 0 to 3; allowed are", env.step, wrong)
    place, robot, masked = np.argwhere(infos["action_mask"] == 0)[0]
    wrong = good.copy()
    wrong[place, robot] = masked
    refused(ValueError, f"environment {place}, robot_{robot + 1} .*action {masked}: it is masked", env.step, wrong)
    refused(ValueError, "option 'seed'; allowed is reset_mask", env.reset, options={"seed": 1})
    refused(ValueError, r"booleans of shape \(3,\)", env.reset, options={"reset_mask": np.ones((3, 2), dtype=bool)})
    refused(ValueError, "2 seeds; allowed is 3", env.reset, seed=[1, 2])
    refused(TypeError, "seed 0.5 of type float", env.reset, seed=[1, 0.5, 2])
    refused(TypeError, "seed 0.5 of type float", env.reset, seed=0.5)
    refused(TypeError, "seed 'one' of type str", env.reset, seed="one")
    for seed in (-1, 2**64, [0, -1, 2], 2**64 - 1):
        refused(ValueError, "allowed are 0 to", env.reset, seed=seed)
    assert [env._native.digests(place) for place in range(3)] == before, "nothing happened"
    env.step(good)
    assert [env._native.digests(place) for place in range(3)] != before
    env.close()
    for name, call in (("step", lambda: env.step(good)), ("reset", env.reset), ("render", env.render)):
        refused(RuntimeError, f"{name} of an environment that is closed; make a new one", call)
    for name in ("state", "belief", "action_masks"):
        refused(RuntimeError, f"{name} of an environment that is closed", getattr(env, name))


def test_policies():
    refused(ValueError, 'unknown policy "gnm"; allowed are random, coverage', dragnet.Policy, "gnm")
    refused(ValueError, "weights", dragnet.Policy, "path", weights="a.safetensors")
    env = dragnet.SearchEnv(small())
    observation, _ = env.reset(seed=0)
    refused(ValueError, r"belief without 'log_odds'; allowed is what belief\(\)", dragnet.Policy("path"), observation)
    refused(TypeError, "belief of type ndarray", dragnet.Policy("path"), np.zeros(3))
    observation = env.belief()
    for policy in (dragnet.Policy("path"), dragnet.Policy("path", env.scenario)):
        for name in ("log_odds", "precision", "weighted_sum"):
            broken = observation | {name: np.full_like(observation[name], np.nan)}
            refused(ValueError, f"{name}.*NaN at", policy, broken)
            refused(
                TypeError, f"{name}.*dtype float32", policy, observation | {name: observation[name].astype(np.float32)}
            )
            refused(ValueError, f"{name}.*shape", policy, observation | {name: observation[name][0]})
            refused(TypeError, f"{name}.*list", policy, observation | {name: observation[name].tolist()})
        refused(ValueError, "precision below 0", policy, observation | {"precision": -1.0 - observation["precision"]})
        refused(
            ValueError, "weighted_sum inf", policy, observation | {"weighted_sum": observation["weighted_sum"] + np.inf}
        )
        refused(ValueError, "position", policy, observation | {"position": np.array([-1, 0])})
        refused(ValueError, "position", policy, observation | {"position": np.array([0.5, 0.0])})
        refused(ValueError, "without 'log_odds'", policy, {})
    smaller = {name: part[:5, :5] for name, part in observation.items() if part.ndim == 2} | {
        "position": np.array([2, 2])
    }
    refused(ValueError, "5 x 5 cells; the scenario's map has 14 x 12", dragnet.Policy("path", env.scenario), smaller)
    # Of any memory order and even with nowhere to go: a decision.
    turned = {name: np.asfortranarray(part) for name, part in observation.items()}
    assert dragnet.Policy("path")(turned).waypoint == dragnet.Policy("path")(observation).waypoint
    nowhere = observation | {"traversable": np.zeros_like(observation["traversable"])}
    refused(ValueError, "no robot can be", dragnet.Policy("path"), nowhere)


def test_comparisons_and_recordings(tmp_path):
    refused(ValueError, "unknown policy", dragnet.compare, small(), ["gnm"])
    refused(TypeError, "a list of names", dragnet.compare, small(), "path")
    refused(TypeError, "a list of names", dragnet.compare, small(), [lambda observation, mask: 0])
    refused(TypeError, r"policies\['mine'\] of type int", dragnet.compare, small(), {"mine": 3})
    refused(TypeError, "name 3", dragnet.compare, small(), {3: "path"})
    refused(ValueError, "baseline=path; allowed are mine", dragnet.compare, small(), {"mine": "tour"}, baseline="path")
    refused(ValueError, 'frame="sky"', dragnet.compare, small(), {"mine": lambda o, m: 0}, frame="sky")
    refused(ValueError, "no seed", dragnet.compare, small(), ["path"], seeds=0)
    refused(TypeError, "seeds 2.0 of type float; allowed is an integer", dragnet.compare, small(), ["path"], seeds=2.0)
    refused(ValueError, "seed -1", dragnet.compare, small(), ["path"], seeds=[-1])
    refused(OSError, "nothing.mcap", dragnet.read_recording, tmp_path / "nothing.mcap")
    refused((OSError, ValueError), "README", dragnet.read_recording, SCENARIOS / "README.md")


@pytest.mark.parametrize("make", [dragnet.SearchVectorEnv, dragnet.TeamVectorEnv])
def test_one_environment_in_two_threads(make):
    """While one thread steps, another is refused; nothing else happens."""
    env = make(small(), 64, control="step", masked_action="stay")
    env.reset(seed=0)
    actions = np.zeros(env.action_space.shape, dtype=np.int64)
    told = []

    def step():
        for _ in range(100_000):
            if told:
                return
            try:
                env.step(actions)
            except RuntimeError as error:
                told.append(str(error))

    threads = [threading.Thread(target=step) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert told
    assert all("one at a time" in message for message in told), set(told)
    env.step(actions)


@pytest.mark.parametrize(
    ("action", "error", "message"),
    [
        (900, ValueError, "action 900: no such action; they are 0 to 167"),
        (-1, ValueError, "action -1: no such action"),
        (float("nan"), TypeError, "action nan of type float; allowed is an integer"),
        (np.zeros(2), TypeError, r"action array\(\[0., 0.\]\) of type ndarray"),
        ("north", TypeError, "action 'north' of type str"),
    ],
)
def test_what_a_policy_of_ones_own_must_not_do(action, error, message):
    """It says in which decision, where, and of which episode."""
    where = r'policy \'mine\' on "small", seed 4, decision 3 of robot_1 at row \d+, column \d+: '
    asked = []

    def decide(observation, mask):
        asked.append(observation)
        return action if len(asked) == 3 else int(mask.argmax())

    refused(error, f"^{where}{message}", dragnet.compare, small(), {"mine": decide}, seeds=[4])
    assert len(asked) == 3

    def masked(observation, mask):
        return int(mask.argmin())

    refused(ValueError, "it is masked", dragnet.compare, small(), {"mine": masked}, seeds=[4], control="waypoint")

    def fails(observation, mask):
        return observation["no such part"]

    with pytest.raises(RuntimeError, match="decision 1 of robot_1.*KeyError: 'no such part'") as raised:
        dragnet.compare(small(), {"mine": fails}, seeds=[4])
    assert isinstance(raised.value.__cause__, KeyError)

    def interrupted(observation, mask):
        raise KeyboardInterrupt

    refused(KeyboardInterrupt, "^$", dragnet.compare, small(), {"mine": interrupted}, seeds=[4])


def test_closed_environments():
    envs = [dragnet.SearchEnv(small(), render_mode="rgb_array"), dragnet.SearchVectorEnv(small(), 2)]
    for env in [*envs, dragnet.parallel_env(small(), robots=2)]:
        env.reset(seed=0)
        env.close()
        env.close()
        refused(RuntimeError, "reset of an environment that is closed", env.reset, seed=0)
        refused(RuntimeError, "step of an environment that is closed", env.step, 0)
        refused(RuntimeError, "render of an environment that is closed", env.render)


def test_a_spoiled_history():
    env = dragnet.SearchEnv(small())
    env.reset(seed=0)
    state = env.__getstate__()
    for cell in (-2, 10**6, 2**40):
        spoiled = state | {"_history": (0, np.array([cell]))}
        refused(
            ValueError,
            f"cell {cell} of step 0: not on the map",
            dragnet.SearchEnv.__new__(dragnet.SearchEnv).__setstate__,
            spoiled,
        )
