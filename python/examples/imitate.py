"""A small network learns by demonstration to search as `tour` does, in plain PyTorch; then it is compared with built-in policies.

Usage: python imitate.py [DEMONSTRATIONS]

An episode with `tour` as the expert is a demonstration. Some steps of it are random, so that the network also learns what to do
where the expert would not have gone. It sees the map around the robot, turned and mirrored in all eight ways, and steps to a neighbor.
"""

import sys

import numpy as np
import torch

import dragnet

SCENARIO = "ice_cream_cone"
EXPERT = "tour"
#: Steps of a tour that are taken before the expert decides again, as robots do.
STEPS = 4
EXPLORED = 0.2
#: Half the side of the window around the robot, cells; the far window has as many blocks of 5 x 5 cells.
REACH = 7
BLOCK = 5
OFFSETS = dragnet.OFFSETS[4]
CHOICES = {"control": "step", "observation": "planes", "frame": "robot"}


def windows(planes):
    """The cells around the robot, and all of the map in blocks of cells: ``(2 features, side, side)``."""
    rows, columns = (length // 2 for length in planes.shape[1:])
    near = planes[:, rows - REACH : rows + REACH + 1, columns - REACH : columns + REACH + 1]
    side = (2 * REACH + 1) * BLOCK
    far = np.zeros((len(planes), side, side), np.float32)
    top, left = side // 2 - rows, side // 2 - columns
    far[:, top : top + planes.shape[1], left : left + planes.shape[2]] = planes
    blocks = far.reshape(len(planes), side // BLOCK, BLOCK, side // BLOCK, BLOCK).mean(axis=(2, 4))
    return np.concatenate([near, blocks])


def demonstrate(seed, random):
    """Windows and the expert's steps of an episode; what is taken is now and then another step."""
    env = dragnet.SearchEnv(SCENARIO, **CHOICES)
    expert = dragnet.Policy(EXPERT, env.scenario, seed=seed)
    planes, info = env.reset(seed=seed)
    seen, steps, plan, over = [], [], [], False
    while not over:
        if not plan:
            plan = planned(expert(env.belief()), env)
        if not plan:
            break
        seen.append(windows(planes))
        steps.append(plan[0])
        step = plan.pop(0)
        if random.random() < EXPLORED:
            step, plan = random.choice(np.flatnonzero(info["action_mask"])), []
        planes, _, terminated, truncated, info = env.step(step)
        over = terminated or truncated
    return seen, steps


def planned(decision, env):
    """The first steps of a decision's path."""
    cells = [env.path[-1], *decision.path[:STEPS]]
    places = [divmod(int(cell), env.scenario.shape[1]) for cell in cells]
    return [OFFSETS.index((to[0] - at[0], to[1] - at[1])) for at, to in zip(places, places[1:], strict=False)]


class Steps(torch.nn.Module):
    """From windows to a score of each step."""

    def __init__(self, channels):
        super().__init__()
        side = (2 * REACH + 2) // 2
        self.layers = torch.nn.Sequential(
            torch.nn.Conv2d(channels, 32, 3, padding=1),
            torch.nn.ReLU(),
            torch.nn.Conv2d(32, 32, 3, stride=2, padding=1),
            torch.nn.ReLU(),
            torch.nn.Flatten(),
            torch.nn.Linear(32 * side**2, 128),
            torch.nn.ReLU(),
            torch.nn.Linear(128, len(OFFSETS)),
        )

    def forward(self, seen):
        return self.layers(seen)


def turned(seen, steps, way):
    """One of the eight ways to turn and mirror both."""
    quarter, mirrored = way % 4, way >= 4
    seen = torch.rot90(seen, quarter, (2, 3))
    seen = seen.flip(3) if mirrored else seen
    of_step = []
    for down, right in OFFSETS:
        for _ in range(quarter):
            down, right = -right, down
        of_step.append(OFFSETS.index((down, -right if mirrored else right)))
    return seen, torch.tensor(of_step)[steps]


def learn(seen, steps, epochs):
    torch.manual_seed(0)
    torch.set_num_threads(1)
    network = Steps(seen.shape[1])
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, max(epochs, 1))
    for epoch in range(epochs):
        losses = []
        for batch in torch.randperm(len(seen)).split(256):
            some, wanted = turned(seen[batch], steps[batch], int(torch.randint(8, ())))
            loss = torch.nn.functional.cross_entropy(network(some), wanted)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            losses.append(loss.item())
        schedule.step()
        print(f"epoch {epoch + 1} of {epochs}: loss {np.mean(losses):.3f}")
    return network.eval()


class Learned:
    """A network as a policy. It draws its steps, and prefers cells where it was less often: the most probable steps may lead to and
    fro for ever. Both numbers were chosen on the seeds 2000 to 2059."""

    SHARPNESS = 3.0
    RELUCTANCE = 2.0

    def __init__(self, network):
        self.network = network

    def reset(self, seed):
        self.random = np.random.default_rng(seed)
        self.at = (0, 0)
        self.visits = {}

    @torch.no_grad()
    def __call__(self, planes, action_mask):
        scores = self.network(torch.from_numpy(windows(planes))[None])[0].numpy()
        around = [(self.at[0] + down, self.at[1] + right) for down, right in OFFSETS]
        visits = np.array([self.visits.get(cell, 0) for cell in around])
        worth = np.where(action_mask, self.SHARPNESS * scores - self.RELUCTANCE * visits, -np.inf)
        chances = np.exp(worth - worth.max())
        step = int(self.random.choice(len(chances), p=chances / chances.sum()))
        self.at = around[step]
        self.visits[self.at] = self.visits.get(self.at, 0) + 1
        return step


def main(demonstrations=200, epochs=14, seeds=400):
    random = np.random.default_rng(0)
    # Other episodes than those of the comparison, whose seeds are small.
    parts = [demonstrate(1_000_000 + number, random) for number in range(demonstrations)]
    seen = torch.from_numpy(np.array([window for windows, _ in parts for window in windows]))
    steps = torch.tensor([step for _, of_part in parts for step in of_part])
    print(f"{len(steps):,} decisions of {demonstrations} demonstrations")
    policies = {"imitate": Learned(learn(seen, steps, epochs)), "greedy": "greedy", "random": "random", "tour": "tour"}
    table = dragnet.compare(SCENARIO, policies, seeds=seeds, robots=1, **CHOICES)
    for row in table:
        cells, sem = row["cells_to_full_recall_restricted_mean"], row["cells_to_full_recall_restricted_sem"]
        found = row["cells_to_full_recall_reached"]
        print(f"{row['policy']:>8}: all found on {cells:.1f} ± {sem or 0.0:.1f} cells, in {found} of {seeds} searches")
    for row in table.differences:
        low, high = row["cells_to_full_recall_low"], row["cells_to_full_recall_high"]
        print(f"{row['policy']:>8} less imitate: {low:+.0f} to {high:+.0f} cells, 95 % interval")
    return table


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
