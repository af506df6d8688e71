"""Trains the example network on painted pictures, and tells how well it finds what is in others.

Usage: train.py FOLDER [STEPS]. Into the folder come `figures.onnx`, the network; `field.jpg`, a picture; and
`field.json`, what is painted in it and what PyTorch finds. Needs PyTorch, NumPy and OpenCV, as `./test.sh` installs
them. Pictures and weights are drawn from fixed seeds.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy
import torch
from torch import nn
from torch.nn import functional

sys.path.append(str(Path(__file__).parents[3] / "tests/python"))

import onnx_file  # noqa: E402
from painting import NAMES, WIDTHS, field, paint  # noqa: E402

# Of the network's input, and pixels from one anchor to the next.
ROWS, COLUMNS, STRIDE = 192, 320, 8
BATCH = 16
# Sides of boxes come out as powers of e, in units of a stride.
MOST_POWER = 5.0


def layer(inputs, outputs, stride=1, side=3):
    convolution = nn.Conv2d(inputs, outputs, side, stride, side // 2, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs, momentum=0.05), nn.SiLU())


class Network(nn.Module):
    """Convolutions down to a stride of 32; what they see is added to that of a stride of 8, where anchors are."""

    def __init__(self):
        super().__init__()
        self.fine = nn.Sequential(layer(3, 12, 2), layer(12, 16, 2), layer(16, 24, 2), layer(24, 24))
        self.middle = nn.Sequential(layer(24, 32, 2), layer(32, 32))
        self.coarse = nn.Sequential(layer(32, 40, 2), layer(40, 40), layer(40, 32, side=1))
        self.mixed = nn.Sequential(layer(64, 24, side=1))
        self.joined = nn.Sequential(layer(48, 32, side=1), layer(32, 32))
        self.head = nn.Conv2d(32, 4 + len(NAMES), 1)
        self.head.bias.data[4:] = -4.0
        row, column = torch.meshgrid(torch.arange(ROWS // STRIDE), torch.arange(COLUMNS // STRIDE), indexing="ij")
        self.register_buffer("centers", STRIDE * (torch.stack([column, row]).flatten(1) + 0.5))

    def raw(self, images):
        """For each anchor: logarithms of the strides to the left, upper, right and lower edge, and scores."""
        fine = self.fine(images)
        middle = self.middle(fine)
        coarse = functional.interpolate(self.coarse(middle), scale_factor=2.0, mode="nearest")
        mixed = functional.interpolate(self.mixed(torch.cat([coarse, middle], 1)), scale_factor=2.0, mode="nearest")
        return self.head(self.joined(torch.cat([mixed, fine], 1))).flatten(2)

    def edges(self, raw):
        distances = STRIDE * raw[:, :4].clamp(-MOST_POWER, MOST_POWER).exp()
        return torch.cat([self.centers - distances[:, :2], self.centers + distances[:, 2:]], 1)

    def forward(self, images):
        """As YOLO from version 8 on: centers, sides and probabilities of all anchors."""
        raw = self.raw(images)
        low, high = self.edges(raw).chunk(2, 1)
        return torch.cat([(low + high) / 2, high - low, raw[:, 4:].sigmoid()], 1)


def background(random, rows, columns):
    """A field, a plain color or a slope from one to another, with things that are none of ours."""
    kind = random.integers(0, 4)
    if kind < 2:
        image = field(random, rows, columns)
    elif kind == 2:
        image = numpy.full((rows, columns, 3), random.choice([random.uniform(20, 230), 114.0]), numpy.uint8)
    else:
        ends = random.uniform(0, 255, (2, 2, 3)).astype(numpy.float32)
        image = cv2.resize(ends, (columns, rows), interpolation=cv2.INTER_LINEAR).astype(numpy.uint8)
    for _ in range(random.integers(0, 5)):
        color = tuple(int(part) for part in random.integers(0, 256, 3))
        if color[0] > 150 and max(color[1:]) < 100:
            # Too much like a post.
            continue
        height, width = (random.uniform(0.05, 0.5, 2) * rows).astype(int)
        left, top = int(random.uniform(-10, columns)), int(random.uniform(-10, rows))
        if random.random() < 0.5:
            cv2.rectangle(image, (left, top), (left + int(width), top + int(height)), color, -1)
        else:
            cv2.ellipse(image, (left, top), (int(width) // 2 + 1, int(height) // 2 + 1), 0, 0, 360, color, -1)
    return image


def objects(random, rows, columns):
    """Class, left, top, right and lower edge of things that do not overlap; in one picture of five there are none."""
    placed = []
    for _ in range(random.integers(1, 6) if random.random() < 0.8 else 0):
        kind = int(random.integers(0, len(NAMES)))
        height = rows * numpy.exp(random.uniform(numpy.log(0.14), numpy.log(0.6)))
        width = height * (random.uniform(0.18, 0.6) if NAMES[kind] == "post" else WIDTHS[kind])
        # Whole pixels, as they are painted.
        left, top = round(random.uniform(0, columns - width)), round(random.uniform(0, rows - height))
        thing = kind, left, top, left + max(3, round(width)), top + round(height)
        if all(left > r or thing[3] < l or top > b or thing[4] < t for _, l, t, r, b in placed):
            placed.append(thing)
    return placed


def spoiled(random, image):
    """Smaller and larger again, out of focus, lighter or darker, with noise."""
    rows, columns = image.shape[:2]
    if random.random() < 0.5:
        size = [max(8, round(side * random.uniform(0.3, 1))) for side in (columns, rows)]
        image = cv2.resize(cv2.resize(image, size, interpolation=cv2.INTER_AREA), (columns, rows))
    if random.random() < 0.3:
        image = cv2.GaussianBlur(image, (0, 0), random.uniform(0.3, 1.5))
    image = image.astype(numpy.float32)
    if random.random() < 0.7:
        image = (image - 114) * random.uniform(0.7, 1.2) + 114 + random.uniform(-25, 25, 3)
    image += random.normal(0, random.choice([0, random.uniform(0, 12)]), image.shape)
    return numpy.clip(image, 0, 255).astype(numpy.uint8)


def picture(random):
    """An image as it is letterboxed, and what is in it."""
    across, down = (COLUMNS, ROWS) if random.random() < 0.3 else random.uniform(0.6, 1, 2) * (COLUMNS, ROWS)
    columns, rows = (COLUMNS, round(down)) if random.random() < 0.5 else (round(across), ROWS)
    image, placed = background(random, rows, columns), objects(random, rows, columns)
    for thing in placed:
        paint(image, *thing)
    left, top = (COLUMNS - columns) // 2, (ROWS - rows) // 2
    input_image = numpy.full((ROWS, COLUMNS, 3), 114, numpy.uint8)
    input_image[top : top + rows, left : left + columns] = spoiled(random, image)
    return input_image, [(kind, l + left, t + top, r + left, b + top) for kind, l, t, r, b in placed]


def tensor(images):
    return torch.from_numpy(numpy.stack(images)).permute(0, 3, 1, 2).float() / 255


def targets(centers, placed):
    """What each anchor is to score, and by which the others count less; and the box that it is to give, if one."""
    anchors = centers.shape[1]
    score, box, gives = torch.zeros(len(NAMES), anchors), torch.zeros(4, anchors), torch.zeros(anchors, dtype=torch.bool)
    for kind, left, top, right, bottom in placed:
        edges = torch.tensor([left, top, right, bottom]).float()[:, None]
        off = centers - (edges[:2] + edges[2:]) / 2
        far = off.square().sum(0).sqrt() / (0.12 * (bottom - top) + 3)
        score[kind] = torch.maximum(score[kind], torch.exp(-far.square()))
        score[kind, far.argmin()] = 1.0
        near = (off.abs().amax(0) < 1.5 * STRIDE) & (centers > edges[:2]).all(0) & (centers < edges[2:]).all(0)
        near[far.argmin()] = True
        box[:, near], gives = edges, gives | near
    return score, box, gives


def loss(network, raw, score, box, gives):
    """Focal loss of scores as by Zhou et al., "Objects as Points" (2019); one less intersection over union of boxes."""
    probability = raw[:, 4:].sigmoid().clamp(1e-5, 1 - 1e-5)
    of_centers = -(1 - probability).square() * probability.log()
    of_others = -(1 - score) ** 4 * probability.square() * (1 - probability).log()
    count = max(1, int((score == 1).sum()))
    scores = torch.where(score == 1, of_centers, of_others).sum() / count
    given, wanted = (boxes.transpose(1, 2)[gives] for boxes in (network.edges(raw), box))
    common = (torch.minimum(given, wanted)[:, 2:] - torch.maximum(given, wanted)[:, :2]).clamp(min=0).prod(1)
    areas = (given[:, 2:] - given[:, :2]).prod(1) + (wanted[:, 2:] - wanted[:, :2]).prod(1)
    boxes = (1 - common / (areas - common)).sum() + 0.02 * (given - wanted).abs().sum()
    return scores + 2 * boxes / max(1, int(gives.sum()))


def trained(steps):
    torch.manual_seed(1)
    random = numpy.random.default_rng(1)
    network = Network().train()
    optimizer = torch.optim.AdamW(network.parameters(), lr=4e-3, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, max_lr=4e-3, total_steps=steps)
    for step in range(steps):
        images, placed = zip(*(picture(random) for _ in range(BATCH)))
        score, box, gives = map(torch.stack, zip(*(targets(network.centers, things) for things in placed)))
        value = loss(network, network.raw(tensor(images)), score, box, gives)
        optimizer.zero_grad()
        value.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 5)
        optimizer.step()
        schedule.step()
        if step % 100 == 0:
            print(f"step {step}: loss {value.item():.3f}", flush=True)
    return network.eval()


def overlap(one, other):
    """Intersection over union of two boxes."""
    common = numpy.prod(numpy.clip(numpy.minimum(one, other)[2:] - numpy.maximum(one, other)[:2], 0, None))
    area = [(box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)]
    return common / (sum(area) - common)


def found(output, confidence=0.25, iou=0.7):
    """Class, edges and probability, the most confident first, as a robot reads an output."""
    kept = []
    for number in (-output[4:].max(0)).argsort():
        scores, (x, y, width, height) = output[4:, number], output[:4, number]
        if scores.max() <= confidence:
            break
        box = numpy.array([x - width / 2, y - height / 2, x + width / 2, y + height / 2])
        if all(scores.argmax() != kind or overlap(box, other) <= iou for kind, other, _ in kept):
            kept.append((int(scores.argmax()), box, float(scores.max())))
    return kept


def tell_scores(network, count=1000):
    """On pictures of another seed: a thing is found if a box of its class overlaps it by half."""
    random = numpy.random.default_rng(2)
    things, hits, boxes, empty, wrong, overlaps = 0, 0, 0, 0, 0, []
    for _ in range(count):
        image, placed = picture(random)
        with torch.no_grad():
            seen = found(network(tensor([image]))[0].numpy())
        things, boxes = things + len(placed), boxes + len(seen)
        empty, wrong = empty + (not placed), wrong + bool(seen and not placed)
        for kind, *edges in placed:
            best = max((overlap(numpy.array(edges), box) for other, box, _ in seen if other == kind), default=0)
            hits += best >= 0.5
            overlaps += [best] if best >= 0.5 else []
    print(f"{count} pictures with {things} things: {hits} found, {boxes - hits} boxes besides, mean overlap {numpy.mean(overlaps):.3f}")
    print(f"{empty} of them empty: boxes in {wrong}")


def write_picture(folder, network):
    """Twice as large as the input, since a robot takes half of an image's columns and rows."""
    random = numpy.random.default_rng(3)
    image = field(random, 2 * ROWS, 2 * COLUMNS)
    placed = [(0, 60, 100, 130, 240), (0, 470, 60, 530, 180), (1, 220, 220, 325, 360), (2, 380, 150, 410, 290)]
    for thing in placed:
        paint(image, *thing)
    path = folder / "field.jpg"
    cv2.imwrite(str(path), image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 80])
    image = cv2.imread(str(path))[..., ::-1]
    seen = cv2.resize(image, (COLUMNS, ROWS), interpolation=cv2.INTER_LINEAR)
    with torch.no_grad():
        boxes = found(network(tensor([seen]))[0].numpy())
    told = {
        "painted": [[NAMES[kind], *edges] for kind, *edges in placed],
        "found": [[NAMES[kind], *(round(2 * float(edge), 2) for edge in box), round(score, 4)] for kind, box, score in boxes],
    }
    lines = ",\n".join(f'"{key}": {json.dumps(value)}' for key, value in told.items())
    (folder / "field.json").write_text(f"{{\n{lines}\n}}\n")


def main():
    torch.set_num_threads(1)
    folder, steps = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 3000
    network = trained(steps)
    tell_scores(network)
    about = {"task": "detect", "imgsz": [ROWS, COLUMNS], "names": NAMES, "stride": STRIDE}
    onnx_file.write(folder / "figures.onnx", network, ROWS, COLUMNS, about)
    print(f"{sum(part.numel() for part in network.parameters())} weights, {(folder / 'figures.onnx').stat().st_size} bytes")
    write_picture(folder, network)


main()
