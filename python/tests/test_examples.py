"""The examples run, and do what they say."""

import importlib.util
import re
import sys

import numpy as np
import pytest
import torch
from conftest import ROOT


def example(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "python/examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(autouse=True)
def few_threads():
    torch.set_num_threads(1)


def test_a_random_agent_finds_some():
    info = example("random_agent").main()
    assert 0.0 <= info["recall"] <= 1.0
    assert info["path_cells"] > 0


def test_our_policies_are_better_than_chance():
    table = example("baselines").main(seeds=4)
    by_policy = {row["policy"]: row["auc_f1_mean"] for row in table}
    assert by_policy["path"] > by_policy["random"]


def test_a_team_survives_its_network():
    assert example("team").main() == 1.0


def test_an_agent_learns():
    before, learned = example("learn").main()
    assert learned > before + 0.2


def test_maskable_ppo_is_compared_with_built_in_policies():
    """How well it searches after ten minutes is not tested; that it learns at all, in test_libraries.py."""
    table = example("ppo").main(minutes=0.0, seeds=2, lanes=2)
    assert [row["policy"] for row in table] == ["ppo", "greedy", "random"]


def test_a_network_imitates_and_is_compared_with_built_in_policies():
    """How well it searches after all demonstrations is not tested; that it learns at all is."""
    imitate = example("imitate")
    table = imitate.main(demonstrations=2, epochs=3, seeds=2)
    assert [row["policy"] for row in table] == ["imitate", "greedy", "random", "tour"]
    seen, steps = imitate.demonstrate(1_000_000, np.random.default_rng(0))
    seen, steps = torch.from_numpy(np.array(seen)), torch.tensor(steps)
    learned = imitate.learn(seen, steps, epochs=60)
    assert float((learned(seen).argmax(dim=1) == steps).float().mean()) > 0.6


@pytest.mark.parametrize("way", range(8))
def test_windows_are_turned_with_the_steps_that_they_show(way):
    imitate = example("imitate")
    side = 2 * imitate.REACH + 1
    seen = torch.zeros(4, 2, side, side)
    for step, (down, right) in enumerate(imitate.OFFSETS):
        seen[step, :, imitate.REACH + down, imitate.REACH + right] = 1.0
    turned, steps = imitate.turned(seen, torch.arange(4), way)
    assert sorted(steps.tolist()) == [0, 1, 2, 3]
    for window, step in zip(turned, steps.tolist(), strict=True):
        down, right = imitate.OFFSETS[step]
        assert window.sum() == window[:, imitate.REACH + down, imitate.REACH + right].sum() == 2.0


def test_the_greedy_policy_of_dsse_finds_everything_on_the_smallest_track():
    summary = example("benchmark_dsse").main("smoke").summary
    assert (summary[-1]["group"], summary[-1]["reached"]) == ("all", 12)


def test_maskable_ppo_is_measured_on_the_benchmark(monkeypatch):
    """How well it searches after ten minutes is not tested."""
    monkeypatch.syspath_prepend(ROOT / "python/examples")
    summary = example("benchmark_ppo").main(minutes=0.0, track="smoke", lanes=1).summary
    assert {row["policy"] for row in summary} == {"ppo"}
    assert summary[-1]["episodes"] == 12


def test_a_picture_is_drawn(tmp_path):
    example("picture").main(tmp_path / "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_the_gallery_is_drawn(tmp_path):
    example("gallery").main(tmp_path, ["FigureFour"])
    assert (tmp_path / "FigureFour.png").read_bytes().startswith(b"\x89PNG")


def test_the_code_of_the_guide_runs(monkeypatch):
    """Block after block, as a reader would type it; with fewer steps of learning and fewer seeds."""
    monkeypatch.chdir(ROOT)
    names = {"np": np, "torch": torch}
    count = 0
    for page in ("docs/python.md", "python/README.md", "docs/benchmark.md"):
        for block in re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL):
            few = block.replace("10_000", "64").replace("seeds=100", "seeds=2")
            exec(compile(few, page, "exec"), names)
            count += 1
    assert count >= 10
    assert {row["policy"] for row in names["table"]} == {"mine", "tour"}
