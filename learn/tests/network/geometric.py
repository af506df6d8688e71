"""The network once more, of PyTorch Geometric's own attention, as a check of ours.

Usage: geometric.py FOLDER

The folder holds files WEIGHTS.weights.safetensors, as the program writes them, and for each graphs with the logits that
the program computed: WEIGHTS.GRAPH.graph.safetensors with the tensors

    features [nodes, features], logits [nodes]            32-bit floats
    source, target [edges], parent [nodes], root [1]      node numbers, 64 bits
    inverse_distance [edges]                              32-bit floats

Prints as JSON, for each graph, the largest difference of a logit, how far the logits are apart, and the seconds of one
forward pass: from features to logits, without gradients, on one thread, the median of several. Edges, their inverse
distances and the tables of ancestors are tensors before the clock starts. The seconds up to the end of the attention
layers are given too.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import torch
from safetensors import safe_open
from safetensors.torch import load_file
from torch.nn.functional import leaky_relu, linear
from torch_geometric.nn import GATConv

HEADS = 4
LOGIT_SCALE = 10.0
PASSES = 15


def attention(tensors, layer, hidden):
    """A layer with our parameters. PyTorch Geometric scores a vector made of an edge's number; ours is that score."""
    name = f"attention.{layer}"
    channels = hidden // HEADS
    module = GATConv(hidden, channels, heads=HEADS, negative_slope=0.2, add_self_loops=False, edge_dim=1)
    edge = torch.zeros(HEADS, channels)
    edge[:, 0] = tensors[f"{name}.edge"]
    first = torch.zeros(HEADS, channels)
    first[:, 0] = 1.0
    module.load_state_dict(
        {
            "lin.weight": tensors[f"{name}.weight"],
            "att_src": tensors[f"{name}.source"][None],
            "att_dst": tensors[f"{name}.target"][None],
            "lin_edge.weight": edge.reshape(-1, 1),
            "att_edge": first[None],
            "bias": tensors[f"{name}.bias"],
        }
    )
    return module


class Network(torch.nn.Module):
    def __init__(self, path):
        super().__init__()
        with safe_open(path, "pt") as file:
            self.shape = json.loads(file.metadata()["dragnet"])["shape"]
        self.tensors = load_file(path)
        hidden = self.shape["hidden"]
        layers = range(self.shape["layers"])
        self.attention = torch.nn.ModuleList(attention(self.tensors, layer, hidden) for layer in layers)

    def linear(self, name, inputs):
        return linear(inputs, self.tensors[f"{name}.weight"], self.tensors[f"{name}.bias"])

    def attend(self, graph):
        channels = leaky_relu(self.linear("encoder", graph.features))
        for layer in self.attention:
            channels = channels + leaky_relu(layer(channels, graph.edges, graph.inverse_distance))
        return channels

    def forward(self, graph):
        channels = self.attend(graph)
        if self.shape["decay_channels"]:
            fade = torch.sigmoid(self.tensors["decay.factor"])
            channels = torch.cat([channels, graph.carry(leaky_relu(self.linear("decay", channels)), fade)], 1)
        inputs = [leaky_relu(self.linear("mix", channels))]
        if self.shape["sum_channels"]:
            counted = self.linear("sum", inputs[0]).clamp(-12.0, 6.0).exp() * graph.is_not_root
            inputs.append(torch.log(graph.carry(counted, torch.ones(self.shape["sum_channels"])) + 1e-6))
        inputs = torch.cat([*inputs, graph.features], 1)
        head = leaky_relu(self.linear("head", inputs))
        return LOGIT_SCALE * self.linear("logit", torch.cat([head, inputs], 1)).squeeze(1)


class Graph:
    def __init__(self, path):
        tensors = load_file(path)
        self.features = tensors["features"]
        self.logits = tensors["logits"]
        self.edges = torch.stack([tensors["source"], tensors["target"]])
        self.inverse_distance = tensors["inverse_distance"][:, None]
        nodes = len(self.features)
        self.is_not_root = torch.ones(nodes, 1)
        self.is_not_root[tensors["root"]] = 0.0
        # Above the root, and above itself, is a last row of zeros.
        above = torch.cat([tensors["parent"], torch.tensor([nodes])])
        above[tensors["root"]] = nodes
        self.ancestors = []
        while (above < nodes).any():
            self.ancestors.append(above)
            above = above[above]

    def carry(self, values, fade):
        """Sum along the route of what each cell hands on, of which `fade` is left a cell later."""
        carried = torch.cat([values, torch.zeros(1, values.shape[1])])
        for above in self.ancestors:
            # Each row holds the nearest 1, 2, 4, .. cells of its route.
            carried = carried + fade * carried[above]
            fade = fade * fade
        return carried[:-1]


def median_seconds(function, *arguments):
    def seconds():
        start = time.perf_counter()
        function(*arguments)
        return time.perf_counter() - start

    function(*arguments)
    return statistics.median(seconds() for _ in range(PASSES))


def main():
    torch.set_num_threads(1)
    seen = {}
    for weights in sorted(Path(sys.argv[1]).glob("*.weights.safetensors")):
        network = Network(weights)
        name = weights.name.removesuffix(".weights.safetensors")
        for path in sorted(weights.parent.glob(f"{name}.*.graph.safetensors")):
            graph = Graph(path)
            logits = network(graph)
            seen[path.name.removesuffix(".graph.safetensors")] = {
                "difference": (logits - graph.logits).abs().max().item(),
                "spread": (logits.max() - logits.min()).item(),
                "seconds": median_seconds(network, graph),
                "attention_seconds": median_seconds(network.attend, graph),
            }
    json.dump(seen, sys.stdout)


with torch.no_grad():
    main()
