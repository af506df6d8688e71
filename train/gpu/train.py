"""Trains a network of `dragnet_learn::network` on a GPU, as `dragnet train` does on a CPU.

    python3 train.py --graphs 'DIR/*.safetensors' --out FILE.safetensors [--minutes M] [--watch]

Reads what `cargo run --release -p dragnet-learn --example graphs` writes, and writes a weights file of the product.
With --watch files that appear while it trains are learned from too, and the weights are written again and again, so
that demonstrations can follow the network as it learns. Needs PyTorch, numpy and safetensors.
"""

import argparse
import glob
import json
import math
import os
import time

import numpy as np
import torch
import torch.nn.functional as F
from safetensors import safe_open
from safetensors.torch import save_file

HEADS, NONE = 4, 65535
LEAST_SUM, SUM_LOG_RANGE, LOGIT_SCALE = 1e-6, (-12.0, 6.0), 10.0
FEATURES = [
    "probability", "log_odds", "entropy", "information_gain", "log_information_gain", "log_path_length",
    "log_path_weight", "robot", "openness", "planned_precision", "hidden", "log_hidden", "hidden_gain",
    "log_hidden_gain", "suspected", "log_total_hidden", "near_path_length", "sensor_radius", "diagonal_moves",
]  # fmt: skip


def parameters(shape):
    """Name and shape of every parameter, as `Shape::parameters` lists them."""
    hidden, coarse, levels = shape["hidden"], shape["coarse_channels"], shape["levels"]
    found = []

    def linear(name, outputs, inputs):
        found.append((f"{name}.weight", (outputs, inputs)))
        found.append((f"{name}.bias", (outputs,)))

    def attention(name, width):
        linear(name, width, width)
        found.append((f"{name}.source", (HEADS, width // HEADS)))
        found.append((f"{name}.target", (HEADS, width // HEADS)))
        found.append((f"{name}.edge", (HEADS,)))

    def width(level):
        return coarse if level else hidden

    linear("encoder", hidden, len(FEATURES))
    for layer in range(shape["layers"]):
        attention(f"attention.{layer}", hidden)
    for level in range(1, levels + 1):
        linear(f"gather.{level}", coarse, width(level - 1) + 1)
        for layer in range(shape["coarse_layers"]):
            attention(f"level.{level}.gather.{layer}", coarse)
    for level in reversed(range(levels)):
        linear(f"spread.{level}", width(level), coarse)
        for name in refining(shape, level):
            attention(name, width(level))
    if shape["decay_channels"]:
        linear("decay", shape["decay_channels"], hidden)
        found.append(("decay.factor", (shape["decay_channels"],)))
    linear("mix", hidden, hidden + shape["decay_channels"])
    if shape["sum_channels"]:
        linear("sum", shape["sum_channels"], hidden)
    head = hidden + shape["sum_channels"] + len(FEATURES)
    linear("head", hidden, head)
    linear("logit", 1, hidden + head)
    return found


def refining(shape, level):
    if level == 0:
        return ["refine"]
    return [f"level.{level}.refine.{layer}" for layer in range(shape["coarse_layers"])]


class Network(torch.nn.Module):
    def __init__(self, shape, seed):
        super().__init__()
        self.shape = shape
        random = torch.Generator().manual_seed(seed)
        self.values = torch.nn.ParameterDict()
        for name, size in parameters(shape):
            if name == "decay.factor":
                value = torch.linspace(0.5, 0.95, size[0]).logit()
            elif len(size) < 2:
                value = torch.zeros(size)
            else:
                limit = math.sqrt(6 / sum(size))
                value = limit * (2 * torch.rand(size, generator=random) - 1)
            self.values[name.replace(".", "/")] = torch.nn.Parameter(value)

    def get(self, name):
        return self.values[name.replace(".", "/")]

    def linear(self, name, x):
        return F.linear(x, self.get(f"{name}.weight"), self.get(f"{name}.bias"))

    def attend(self, name, x, edges):
        neighbors, inverse_distance, missing = edges
        projected = x @ self.get(f"{name}.weight").T
        rows, slots = neighbors.shape
        heads = projected.view(rows, HEADS, -1)
        source = (heads * self.get(f"{name}.source")).sum(-1)
        target = (heads * self.get(f"{name}.target")).sum(-1)
        flat = neighbors.reshape(-1)
        scores = source.index_select(0, flat).view(rows, slots, HEADS) + target[:, None]
        scores = scores + inverse_distance[..., None] * self.get(f"{name}.edge")
        scores = F.leaky_relu(scores, 0.2).masked_fill(missing[..., None], -1e9)
        share = scores.softmax(1).masked_fill(missing[..., None], 0.0)
        brought = heads.index_select(0, flat).view(rows, slots, HEADS, -1)
        summed = torch.einsum("rsh,rshc->rhc", share, brought).reshape(rows, -1)
        return x + F.leaky_relu(summed + self.get(f"{name}.bias"))

    def carry(self, values, ancestors, fade=None):
        for ancestor in ancestors:
            before = values.index_select(0, ancestor)
            values = values + (before if fade is None else before * fade)
            fade = None if fade is None else fade * fade
        return values

    def forward(self, batch):
        """Logits of the candidates, shape [decisions, candidates]."""
        shape = self.shape
        x = F.leaky_relu(self.linear("encoder", batch["features"]))
        for layer in range(shape["layers"]):
            x = self.attend(f"attention.{layer}", x, batch["edges"][0])
        channels = [x]
        for level in range(1, shape["levels"] + 1):
            piece, size, count = batch["piece"][level], batch["size"][level], batch["count"][level]
            below = channels[-1]
            mean = below.new_zeros(len(size), below.shape[1]).index_add(0, piece, below) / count
            y = F.leaky_relu(self.linear(f"gather.{level}", torch.cat([mean, size], 1)))
            for layer in range(shape["coarse_layers"]):
                y = self.attend(f"level.{level}.gather.{layer}", y, batch["edges"][level])
            channels.append(y)
        for level in reversed(range(shape["levels"])):
            spread = F.leaky_relu(self.linear(f"spread.{level}", channels[level + 1]))
            y = channels[level] + spread.index_select(0, batch["piece"][level + 1])
            for name in refining(shape, level):
                y = self.attend(name, y, batch["edges"][level])
            channels[level] = y
        x = channels[0]
        if shape["decay_channels"]:
            decaying = F.leaky_relu(self.linear("decay", x)) * batch["is_node"]
            faded = self.carry(decaying, batch["ancestors"], self.get("decay.factor").sigmoid())
            x = torch.cat([x, faded], 1)
        mixed = F.leaky_relu(self.linear("mix", x))
        inputs = [mixed]
        if shape["sum_channels"]:
            values = self.linear("sum", mixed).clamp(*SUM_LOG_RANGE).exp() * batch["is_candidate"]
            inputs.append((self.carry(values, batch["ancestors"]) + LEAST_SUM).log())
        inputs.append(batch["features"])
        inputs = torch.cat(inputs, 1).index_select(0, batch["candidates"].reshape(-1))
        head = F.leaky_relu(self.linear("head", inputs))
        logits = self.linear("logit", torch.cat([head, inputs], 1)) * LOGIT_SCALE
        return logits.view(batch["candidates"].shape)


class Data:
    """Decisions in the GPU's memory. Tensors over nodes stand behind each other; `first` says where a decision starts."""

    def __init__(self, levels, device):
        self.levels, self.device = levels, device
        self.parts, self.seen = {}, set()
        self.all = None

    def add(self, path):
        levels = range(1, self.levels + 1)
        with safe_open(path, "np") as file:
            table = {name: file.get_tensor(name) for name in file.keys()}
        part = {
            "features": torch.from_numpy(table["features"]).half(),
            "parent": number(table["parent"]).view(-1),
            "root": number(table["root"]).view(-1),
            "nodes.0": number(table["nodes"]).view(-1),
            "neighbors.0": number(table["0.neighbors"]),
            "straight.0": torch.from_numpy(table["0.straight"]),
        }
        for level in levels:
            part[f"nodes.{level}"] = number(table[f"{level}.nodes"]).view(-1)
            part[f"piece.{level}"] = number(table[f"{level}.piece"]).view(-1)
            part[f"size.{level}"] = torch.from_numpy(table[f"{level}.size"])
            part[f"neighbors.{level}"] = number(table[f"{level}.neighbors"])
            part[f"straight.{level}"] = torch.from_numpy(table[f"{level}.straight"])
        part["candidates"], part["scores"] = candidates(table["scores"][:, 0], table["nodes"][:, 0])
        for name, tensor in part.items():
            self.parts.setdefault(name, []).append(tensor.to(self.device))
        self.seen.add(path)

    def join(self):
        """Makes decisions that were added ready; returns their number."""
        for name, parts in self.parts.items():
            self.parts[name] = [torch.cat(parts)] if len(parts) > 1 else parts
        self.all = {name: parts[0] for name, parts in self.parts.items()}
        for level in range(self.levels + 1):
            nodes = self.all[f"nodes.{level}"].long()
            self.all[f"first.{level}"] = nodes.cumsum(0) - nodes
        return len(self.all["root"])

    def batch(self, chosen):
        """The decisions of these numbers. The last row of each level stands for no node."""
        data = self.all
        rows, firsts, batch = [], [], {"edges": [], "piece": [None], "size": [None], "count": [None]}
        for level in range(self.levels + 1):
            count = data[f"nodes.{level}"][chosen].long()
            first = count.cumsum(0) - count
            total = int(count.sum())
            graph = torch.repeat_interleave(torch.arange(len(chosen), device=self.device), count, output_size=total)
            row = torch.arange(total, device=self.device) - first[graph] + data[f"first.{level}"][chosen][graph]
            rows.append(row)
            firsts.append(first)
            neighbors = data[f"neighbors.{level}"][row].long()
            missing = neighbors < 0
            neighbors = torch.where(missing, total, neighbors + first[graph][:, None])
            straight = data[f"straight.{level}"][row].bool()
            inverse = torch.where(straight, 1.0, math.sqrt(0.5)).masked_fill(missing, 0.0)
            width = int((~missing).sum(1).max()) if total else 1
            pad = lambda tensor, value: F.pad(tensor[:, :width], (0, 0, 0, 1), value=value)
            batch["edges"].append((pad(neighbors, total), pad(inverse, 0.0), pad(missing, True)))
            if level:
                size = F.pad(data[f"size.{level}"][row], (0, 0, 0, 1), value=0.0)
                batch["size"].append(size)
                below, below_graph = rows[level - 1], self_graph
                piece = data[f"piece.{level}"][below].long() + first[below_graph]
                piece = F.pad(piece, (0, 1), value=total)
                batch["piece"].append(piece)
                ones = torch.ones(len(piece), device=self.device)
                batch["count"].append(torch.zeros(total + 1, device=self.device).index_add(0, piece, ones)[:, None])
            self_graph = graph
        total = len(rows[0])
        first, row = firsts[0], rows[0]
        graph = torch.repeat_interleave(
            torch.arange(len(chosen), device=self.device), data["nodes.0"][chosen].long(), output_size=total
        )
        parent = F.pad(data["parent"][row].long() + first[graph], (0, 1), value=total)
        root = data["root"][chosen].long() + first
        parent[root] = total
        # Candidates are less than eight cells away.
        batch["ancestors"] = [parent, parent[parent]]
        batch["ancestors"].append(batch["ancestors"][1][batch["ancestors"][1]])
        batch["features"] = F.pad(data["features"][row].float(), (0, 0, 0, 1))
        batch["is_node"] = torch.ones(total + 1, 1, device=self.device)
        batch["is_node"][total] = 0
        batch["is_candidate"] = batch["is_node"].clone()
        batch["is_candidate"][root] = 0
        candidates = data["candidates"][chosen].long()
        batch["candidates"] = torch.where(candidates < 0, total, candidates + first[:, None])
        batch["scores"] = data["scores"][chosen]
        return batch


def number(array):
    """Numbers of nodes, -1 for none."""
    return torch.from_numpy(np.where(array == NONE, -1, array.astype(np.int32)).astype(np.int16))


MOST_CANDIDATES = 24


def candidates(scores, nodes):
    """Scored nodes of each decision, -1 where there are fewer, and their scores."""
    numbers = np.full((len(nodes), MOST_CANDIDATES), -1, np.int16)
    found = np.full((len(nodes), MOST_CANDIDATES), -np.inf, np.float32)
    first = 0
    for place, count in enumerate(nodes.astype(int)):
        of_nodes = scores[first : first + count]
        scored = np.flatnonzero(np.isfinite(of_nodes))[:MOST_CANDIDATES]
        numbers[place, : len(scored)] = scored
        found[place, : len(scored)] = of_nodes[scored]
        first += count
    return torch.from_numpy(numbers), torch.from_numpy(found)


def losses(logits, scores, temperature):
    """Cross-entropy against softmax(scores / temperature), and the cells that the network's choice loses."""
    is_none = scores.isinf()
    log_policy = logits.masked_fill(is_none, -1e9).log_softmax(1)
    best = scores.max(1, keepdim=True).values
    wished = ((scores - best) / temperature).softmax(1)
    loss = -(wished * log_policy).sum(1)
    entropy = -(wished * wished.clamp(min=1e-12).log()).sum(1)
    chosen = logits.masked_fill(is_none, -1e9).argmax(1, keepdim=True)
    regret = (best - scores.gather(1, chosen)).squeeze(1)
    return loss - entropy, regret


def save(network, path, recipe):
    header = {"format": "dragnet-weights-2", "features": FEATURES, "shape": network.shape, "recipe": recipe}
    tensors = {name: network.get(name).detach().cpu().contiguous() for name, _ in parameters(network.shape)}
    save_file(tensors, f"{path}.new", metadata={"dragnet": json.dumps(header, separators=(",", ":"))})
    os.replace(f"{path}.new", path)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graphs", required=True, help="pattern of files to learn from")
    parser.add_argument("--held-out", help="pattern of files to measure on")
    parser.add_argument("--out", required=True)
    parser.add_argument("--minutes", type=float, default=8.0)
    parser.add_argument("--steps", type=int, help="this many steps instead of minutes")
    parser.add_argument("--watch", action="store_true")
    parser.add_argument("--start", help="weights to go on from")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--batch", type=int, default=128)
    parser.add_argument("--learning-rate", type=float, default=2e-3)
    parser.add_argument("--temperature", type=float, default=1.5, help="cells")
    parser.add_argument("--hidden", type=int, default=32)
    parser.add_argument("--layers", type=int, default=2)
    parser.add_argument("--coarse-channels", type=int, default=64)
    parser.add_argument("--coarse-layers", type=int, default=2)
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    return parser.parse_args()


def main():
    options = arguments()
    torch.backends.cuda.matmul.allow_tf32 = True
    shape = {
        "hidden": options.hidden, "layers": options.layers, "decay_channels": 16, "sum_channels": 4,
        "levels": 3, "coarse_channels": options.coarse_channels, "coarse_layers": options.coarse_layers,
    }  # fmt: skip
    network = Network(shape, options.seed)
    if options.start:
        with safe_open(options.start, "pt") as file:
            for name, _ in parameters(shape):
                network.get(name).data.copy_(file.get_tensor(name))
    network.to(options.device)
    average = {name: value.detach().clone() for name, value in network.named_parameters()}
    adam = torch.optim.AdamW(network.parameters(), lr=options.learning_rate, weight_decay=1e-4)
    data, held_out = Data(3, options.device), Data(3, options.device)
    if options.held_out:
        for path in sorted(glob.glob(options.held_out)):
            held_out.add(path)
        held_out.join()
    random = torch.Generator(device=options.device).manual_seed(options.seed)
    start, step, count, shown, saved, sums = time.time(), 0, 0, time.time(), time.time(), []

    def write():
        recipe = {
            "expert": "tour", "scenarios": ["mixture"], "decisions": count, "seed": options.seed,
            "epochs": round(step * options.batch / max(count, 1)), "held_out_loss": measure()[0] if options.held_out else 0.0,
            "program": "train/gpu/train.py", "within_cells": 5.0,
        }  # fmt: skip
        own = {name: value.detach().clone() for name, value in network.named_parameters()}
        for name, value in network.named_parameters():
            value.data.copy_(average[name])
        save(network, options.out, recipe)
        for name, value in network.named_parameters():
            value.data.copy_(own[name])

    @torch.no_grad()
    def measure():
        total, number = torch.zeros(2, device=options.device), len(held_out.all["root"])
        for chosen in torch.arange(number, device=options.device).split(256):
            batch = held_out.batch(chosen)
            total += torch.stack([value.sum() for value in losses(network(batch), batch["scores"], options.temperature)])
        return [value / number for value in total.tolist()]

    while True:
        done = step / options.steps if options.steps else (time.time() - start) / (60 * options.minutes)
        if done >= 1:
            break
        if step % 100 == 0 and (options.watch or not count):
            new = [path for path in sorted(glob.glob(options.graphs)) if path not in data.seen]
            for path in new:
                data.add(path)
            if new:
                count = data.join()
        if not count:
            time.sleep(1)
            continue
        for group in adam.param_groups:
            group["lr"] = options.learning_rate * min(1, (step + 1) / 300) * max(0.5 * (1 + math.cos(math.pi * done)), 0.01)
        batch = data.batch(torch.randint(count, (min(options.batch, count),), device=options.device, generator=random))
        loss, regret = losses(network(batch), batch["scores"], options.temperature)
        adam.zero_grad(set_to_none=True)
        loss.mean().backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        adam.step()
        with torch.no_grad():
            keep = min(0.999, (step + 1) / (step + 10))
            for name, value in network.named_parameters():
                average[name].lerp_(value, 1 - keep)
        sums.append(torch.stack([loss.mean().detach(), regret.mean()]))
        step += 1
        if time.time() - shown > 15:
            shown = time.time()
            mean = torch.stack(sums).mean(0).tolist()
            of_held_out = f", held out {measure()}" if options.held_out else ""
            print(f"{shown - start:.0f} s, step {step}, {count} decisions: loss {mean[0]:.4f}, regret {mean[1]:.3f}{of_held_out}", flush=True)
            sums = []
        if options.watch and time.time() - saved > 30:
            saved = time.time()
            write()
    write()


if __name__ == "__main__":
    main()
