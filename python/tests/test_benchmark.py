"""Results on frozen tracks: the same as the command line's, and verified by running them again."""

import json
import subprocess

import numpy as np
import pytest

import dragnet
from dragnet import benchmark


class Greedy:
    """A policy of ours as anybody could have written it."""

    def __init__(self):
        self.policy = dragnet.Policy("greedy")
        self.seeds = []

    def reset(self, seed):
        self.seeds.append(seed)
        self.policy.reset(seed)

    def __call__(self, belief, mask):
        decision = self.policy(belief)
        return None if decision.step is None else decision.waypoint


@pytest.fixture(scope="module")
def result():
    return benchmark.run("smoke", {"mine": Greedy(), "greedy": "greedy"}, observation="belief")


def without_times(result):
    return [{name: value for name, value in row.items() if name != "decision_ms_p50"} for row in result.summary]


def test_a_callable_has_the_results_of_the_policy_that_it_is(result):
    rows = without_times(result)
    mine = [{**row, "policy": "greedy"} for row in rows if row["policy"] == "mine"]
    assert mine == [row for row in rows if row["policy"] == "greedy"]
    assert [row["group"] for row in mine][-1] == "all"
    assert mine[-1]["episodes"] == 12
    assert mine[-1]["reached"] > 0


def test_the_command_line_has_the_same_track_and_episodes(result, program, tmp_path):
    out = tmp_path / "result.json"
    subprocess.run(
        [program, "benchmark", "smoke", "--policies", "greedy", "--out", out], check=True, stdout=subprocess.PIPE
    )
    ours, theirs = json.loads(result.to_json()), json.loads(out.read_text())
    assert ours["track"] == theirs["track"]
    assert ours["policies"][1]["episodes"] == theirs["policies"][0]["episodes"]
    assert ours["policies"][1]["decider"] == theirs["policies"][0]["decider"]
    assert benchmark.verify(out) == []
    named = tmp_path / "named.json"
    benchmark.run("smoke", ["greedy"], out=named)
    verified = subprocess.run([program, "benchmark", "--verify", named], check=True, stdout=subprocess.PIPE, text=True)
    assert "0 of 12 episodes differ" in verified.stdout


def test_a_result_survives_its_file_and_is_never_overwritten(result, tmp_path):
    path = tmp_path / "result.json"
    result.write(path)
    read = benchmark.Result.read(path)
    assert (read.track, read.digest, read.to_json()) == ("smoke", result.digest, result.to_json())
    with pytest.raises(FileExistsError, match="exists already"):
        result.write(path)
    with pytest.raises(FileExistsError, match="exists already"):
        benchmark.run("smoke", ["greedy"], out=path)
    path.write_text(path.read_text().replace('"recall":1.0', '"recall":0.5', 1))
    with pytest.raises(ValueError, match="an edited or damaged result"):
        benchmark.Result.read(path)


def test_a_callable_is_verified_by_running_it_again(result):
    mine = Greedy()
    assert benchmark.verify(result, {"mine": mine}, sample=6, seed=2) == []
    assert 0 < len(mine.seeds) < 6, "some episodes of each policy"

    def other(belief, mask):
        return int(np.flatnonzero(mask)[-1])

    differing = benchmark.verify(result, {"mine": other})
    assert len(differing) >= 6, "only searches that end within a waypoint may be alike"
    claimed = {(row["search"], row["seed"]): row for row in json.loads(result.to_json())["policies"][0]["episodes"]}
    for row in differing:
        assert row["policy"] == "mine"
        assert row["claimed_average_recall"] == claimed[row["search"], row["seed"]]["average_recall"]
        assert row["claimed_average_recall"] != row["found_average_recall"]


def test_tracks_are_listed():
    names = [track.name for track in benchmark.tracks()]
    assert names[:2] == ["smoke", "single"]
    assert all(track.version == 1 and track.episodes >= 12 for track in benchmark.tracks())


@pytest.mark.parametrize(
    ("request_", "error", "message"),
    [
        (lambda result: benchmark.run("double", ["path"]), ValueError, "no such track; allowed are smoke, single"),
        (lambda result: benchmark.run("smoke", ["pat"]), ValueError, "pat"),
        (lambda result: benchmark.run("smoke", ["path(evaluations=3)"]), ValueError, "evaluations"),
        (
            lambda result: benchmark.run("smoke", {"mine": lambda *_: None}, observation="map"),
            ValueError,
            "observation",
        ),
        (lambda result: benchmark.run("smoke", {"mine": lambda *_: 1 / 0}), RuntimeError, "ZeroDivisionError"),
        (lambda result: benchmark.verify(result), ValueError, "'mine': decided by a callable"),
        (lambda result: benchmark.verify(result, {"mine": 3}), TypeError, "type int; allowed is a callable"),
        (lambda result: benchmark.verify(result, {"mine": print, "my": print}), ValueError, "allowed are mine"),
        (lambda result: benchmark.verify(result, {"mine": print}, sample=0), ValueError, "sample=0"),
        (lambda result: benchmark.verify(result, {"mine": print}, sample=25), ValueError, "allowed is 1 to 24"),
    ],
)
def test_requests_that_make_no_sense_are_refused(result, request_, error, message):
    with pytest.raises(error, match=message):
        request_(result)
