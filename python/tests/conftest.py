"""What tests share: small scenarios."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

import dragnet

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "scenarios"

# Windows without a screen.
os.environ["SDL_VIDEODRIVER"] = "dummy"

KINDS = ["dict", "planes", "graph", "belief"]


def small(rest: str = "", *, moves: int = 4, budget_cells: int = 400) -> dragnet.Scenario:
    """A small map with a wall that some cells hide behind."""
    text = f"""
name = "small"
map = {{ shape = "ice_cream_cone", rows = 14, columns = 12, cell_meters = 10.0, connectivity = {moves} }}
sensor.radius = 2
objects.count = 4
robots.start = "scattered"
mission.budget_meters = {budget_cells * 10.0}
{rest}
"""
    return dragnet.Scenario.from_text(text)


@pytest.fixture(scope="session")
def program() -> str:
    """The command line, built: ``DRAGNET`` names it where it is not in ``target/debug``."""
    path = os.environ.get("DRAGNET", str(ROOT / "target/debug/dragnet"))
    assert shutil.which(path), f"{path} is missing: cargo build -p dragnet"
    return path


def masked_sample(mask: np.ndarray, random: np.random.Generator) -> int:
    """An action that can be taken."""
    return int(random.choice(np.flatnonzero(mask)))
