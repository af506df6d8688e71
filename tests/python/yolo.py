"""Makes what tests of the detector are held against: networks of ultralytics, and what ultralytics itself makes of images.

Usage: yolo.py FOLDER. Into the folder come

- `random.torchscript` and `random.onnx`, YOLO11n with weights that are drawn, `random.png`, an image for it, and for each resolution what
  ultralytics prepares of it (`full.pixels`, 8 bits, rows, columns, red green blue) and what the network says
  (`full.output`, 32-bit floats);
- `figures.torchscript` and `figures.onnx`, a small YOLO11 that is trained here to find painted figures and barrels, and
  `figures.ppm`, an image of a camera's size with some of them;
- `expected.json`: what ultralytics finds in them, and where the figures were painted.

Weights and images are drawn from fixed seeds. ultralytics is under the AGPL: it is used here, in tests, and nowhere else.
"""

import json
import os
import sys
from pathlib import Path

FOLDER = Path(sys.argv[1])
# Whatever it keeps lies here; and it asks no network for anything.
os.environ.update(YOLO_CONFIG_DIR=str(FOLDER), YOLO_OFFLINE="true", YOLO_AUTOINSTALL="false", YOLO_VERBOSE="false")

import cv2  # noqa: E402
import numpy  # noqa: E402
import torch  # noqa: E402
import ultralytics  # noqa: E402
import yaml  # noqa: E402
from ultralytics import YOLO  # noqa: E402
from ultralytics.cfg import get_cfg  # noqa: E402
from ultralytics.data.augment import LetterBox  # noqa: E402
from ultralytics.nn.tasks import DetectionModel  # noqa: E402
from ultralytics.utils.nms import non_max_suppression  # noqa: E402
from ultralytics.utils.ops import scale_boxes  # noqa: E402

import onnx_file  # noqa: E402
import painting  # noqa: E402
from painting import field, paint, place, texture  # noqa: E402

# Rows and columns of inputs. None is a square, so that whoever confuses the two is found out.
RANDOM_INPUT = (256, 320)
FIGURES_INPUT = (128, 160)
# The camera of the paper.
CAMERA_ROWS, CAMERA_COLUMNS = 3032, 5320
NAMES = {kind: painting.NAMES[kind] for kind in (0, 1)}
STEPS, BATCH = 200, 8


def half(image):
    rows, columns = image.shape[:2]
    return cv2.resize(image, (columns // 2, rows // 2), interpolation=cv2.INTER_LINEAR)


def prepared(image, network_input):
    return LetterBox(network_input, auto=False)(image=image)


def run(module, *images):
    images = torch.from_numpy(numpy.stack(images)).permute(0, 3, 1, 2).float() / 255
    with torch.no_grad():
        return module(images.contiguous())


def found(output, network_input, image, **settings):
    """Boxes in pixels of the image: left, top, right, bottom, confidence, class. Of equals the first anchor comes first."""
    (boxes,), (anchors,) = non_max_suppression(output.clone(), max_det=10_000, return_idxs=True, **settings)
    order = sorted(range(len(boxes)), key=lambda number: (-boxes[number, 4].item(), anchors[number].item()))
    boxes = boxes[order]
    boxes[:, :4] = scale_boxes(network_input, boxes[:, :4], image.shape[:2])
    return boxes.double().tolist()


def exported(model, network_input, name):
    """As people export theirs, so that the file says what ultralytics says of a module; and the same as an ONNX file."""
    file = model.export(format="torchscript", imgsz=network_input, device="cpu")
    Path(file).rename(FOLDER / f"{name}.torchscript")
    module = torch.jit.load(FOLDER / f"{name}.torchscript")
    about = {"task": "detect", "imgsz": list(network_input), "names": model.names}
    onnx_file.write(FOLDER / f"{name}.onnx", module, *network_input, about)
    return module


def spread(layer, values, mean, deviation):
    """Weights of a layer such that what came out as `values` comes out with this mean and deviation."""
    scale = deviation / values.std().item()
    layer.weight.data *= scale
    layer.bias.data = (layer.bias.data - values.mean().item()) * scale + mean


def random_case(expected):
    torch.manual_seed(1)
    random = numpy.random.default_rng(1)
    image = numpy.clip(texture(random, 398, 706) + 120, 0, 255).astype(numpy.uint8)
    cv2.imwrite(str(FOLDER / "random.png"), image[..., ::-1])

    model = YOLO("yolo11n.yaml", task="detect")
    head = model.model.model[-1]
    caught = {}
    for branch in [head.cv2, head.cv3]:
        for part in branch:
            part[-1].register_forward_hook(lambda layer, _, values: caught.__setitem__(layer, values))
    # Weights as they are drawn let nothing of the image through, unless each layer's values are brought to one scale.
    for part in model.model.modules():
        if isinstance(part, torch.nn.BatchNorm2d):
            part.momentum = 1.0
    shown = [prepared(seen, RANDOM_INPUT) for seen in [image, half(image)]]
    run(model.model.train(), *shown)
    run(model.model.eval(), *shown)
    for part in head.cv2:
        spread(part[-1], caught[part[-1]], 0, 2)
    for part in head.cv3:
        spread(part[-1], caught[part[-1]], -3.5, 0.9)
    for branch in [head.cv2, head.cv3]:
        for part in branch:
            part[-1]._forward_hooks.clear()
    module = exported(model, RANDOM_INPUT, "random")

    for resolution, seen in [("full", image), ("half", half(image))]:
        pixels = prepared(seen, RANDOM_INPUT)
        output = run(module, pixels)
        (FOLDER / f"{resolution}.pixels").write_bytes(pixels.tobytes())
        (FOLDER / f"{resolution}.output").write_bytes(output.numpy().tobytes())
        settings = [
            dict(conf_thres=0.7, iou_thres=0.7),
            dict(conf_thres=0.35, iou_thres=0.2),
            dict(conf_thres=0.25, iou_thres=0.2, agnostic=True),
            dict(conf_thres=0.25, iou_thres=0.45, classes=[3, 17, 40, 79]),
        ]
        expected["random"][resolution] = {
            "shape": list(output.shape),
            "cases": [case | {"boxes": found(output, RANDOM_INPUT, seen, **case)} for case in settings],
        }


def scene(random, rows, columns):
    """A field with some figures and barrels, none before another."""
    image = field(random, rows, columns)
    objects = []
    for _ in range(random.integers(1, 6)):
        kind, height = int(random.integers(0, 2)), random.uniform(0.2, 0.5) * rows
        corner = random.uniform(0, columns - height), random.uniform(0, rows - height)
        thing = kind, left, top, right, bottom = place(kind, *corner, height)
        if all(left > r or right < l or top > b or bottom < t for _, l, t, r, b in objects):
            objects.append(thing)
    for thing in objects:
        paint(image, *thing)
    return image, objects


def batch(random):
    """Scenes as they are letterboxed; places as parts of the input."""
    rows, columns = FIGURES_INPUT
    images, numbers, kinds, places = [], [], [], []
    for number in range(BATCH):
        inner = int(random.integers(rows * 2 // 3, rows + 1))
        top = (rows - inner) // 2
        image, objects = scene(random, inner, columns)
        images.append(cv2.copyMakeBorder(image, top, rows - inner - top, 0, 0, cv2.BORDER_CONSTANT, value=(114,) * 3))
        for kind, left, upper, right, lower in objects:
            numbers.append(number)
            kinds.append([kind])
            middle = (left + right) / 2 / columns, ((upper + lower) / 2 + top) / rows
            places.append([*middle, (right - left) / columns, (lower - upper) / rows])
    return {
        "img": torch.from_numpy(numpy.stack(images)).permute(0, 3, 1, 2).float() / 255,
        "batch_idx": torch.tensor(numbers).float(),
        "cls": torch.tensor(kinds).float(),
        "bboxes": torch.tensor(places).float(),
    }


def trained():
    torch.manual_seed(2)
    random = numpy.random.default_rng(2)
    plan = yaml.safe_load((Path(ultralytics.__file__).parent / "cfg/models/11/yolo11.yaml").read_text())
    plan |= {"scales": {"n": [0.34, 0.125, 64]}, "scale": "n", "yaml_file": "figures.yaml"}
    model = DetectionModel(plan, ch=3, nc=len(NAMES), verbose=False)
    model.args = get_cfg()
    model.names = NAMES
    model.train()
    for part in model.modules():
        if isinstance(part, torch.nn.BatchNorm2d):
            # Of so few steps there is no long mean.
            part.momentum = 0.1
    most = 4e-3
    optimizer = torch.optim.AdamW(model.parameters(), lr=most)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, max_lr=most, total_steps=STEPS)
    for _ in range(STEPS):
        loss, _ = model.loss(batch(random))
        optimizer.zero_grad()
        loss.sum().backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 10)
        optimizer.step()
        schedule.step()
    whole = YOLO("yolo11n.yaml", task="detect")
    model.args, model.task = whole.model.args, whole.task
    whole.model = model.eval()
    return whole


def figures_case(expected):
    module = exported(trained(), FIGURES_INPUT, "figures")
    image = field(numpy.random.default_rng(7), CAMERA_ROWS, CAMERA_COLUMNS)
    objects = [place(0, 700, 900, 1300), place(1, 2300, 1500, 900), place(0, 4300, 1400, 1100)]
    for thing in objects:
        paint(image, *thing)
    cv2.imwrite(str(FOLDER / "figures.ppm"), image[..., ::-1])
    seen = half(image)
    output = run(module, prepared(seen, FIGURES_INPUT))
    boxes = found(output, FIGURES_INPUT, seen, conf_thres=0.25, iou_thres=0.7)
    expected["figures"] = {
        "painted": objects,
        "boxes": [[2 * edge for edge in box[:4]] + box[4:] for box in boxes],
    }


def main():
    torch.set_num_threads(1)
    os.chdir(FOLDER)
    expected = {"random": {}}
    random_case(expected)
    figures_case(expected)
    (FOLDER / "expected.json").write_text(json.dumps(expected))


main()
