"""Makes networks by hand for tests of the detector: one that works, and some that do not.

Usage: modules.py FOLDER. Each is written there as a TorchScript module, `NAME.torchscript`, and, where that format can
hold it, as `NAME.onnx`; those that say how large their images are say 64 rows and 96 columns.
"""

import json
import sys
from pathlib import Path
from typing import Tuple

import onnx_file
import torch

FOLDER = Path(sys.argv[1])
ROWS, COLUMNS = 64, 96


class Red(torch.nn.Module):
    """Finds what is red, as one box around all of it: class 0 if that is upright, else class 1."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        red = ((image[0, 0] > 0.6) & (image[0, 1] < 0.3) & (image[0, 2] < 0.3)).float()
        rows, columns = red.amax(1), red.amax(0)
        count, row, column = rows.shape[0], torch.arange(rows.shape[0]), torch.arange(columns.shape[0])
        bottom, top = (rows * (row + 1)).amax(), count - (rows * (count - row)).amax()
        count = columns.shape[0]
        right, left = (columns * (column + 1)).amax(), count - (columns * (count - column)).amax()
        seen, upright = 0.9 * red.amax(), (bottom - top > right - left).float()
        width, height = (right - left).clamp(min=1.0), (bottom - top).clamp(min=1.0)
        box = [(left + right) / 2, (top + bottom) / 2, width, height]
        return torch.stack(box + [seen * upright, seen * (1 - upright)]).reshape(1, 6, 1)


class Constant(torch.nn.Module):
    """Says the same of every image."""

    def __init__(self, output):
        super().__init__()
        self.register_buffer("output", output)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return self.output + 0 * image.amax()


class NotANumber(torch.nn.Module):
    """Is a detector of gray images; of others it says nothing that is a number."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        is_gray = (image.amax() - image.amin() < 0.01).float()
        return 0.5 + 0 / is_gray * torch.ones(1, 6, 40)


class Lost(torch.nn.Module):
    """Looks for what it says where there is nothing, unless the image is gray."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        is_colored = (image.amax() - image.amin() > 0.01).long()
        return torch.full((2, 6, 40), 0.5).index_select(0, 1000 * is_colored.reshape(1))


class Raises(torch.nn.Module):
    """Fails of all images but gray ones."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        if bool(image.std() > 0.01):
            raise ValueError("this image is too much for me")
        return torch.full((1, 6, 40), 0.5)


class Square(torch.nn.Module):
    """Wants other images."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return torch.mm(image[0, 0], image[0, 1]).reshape(1, 6, -1)


class Pair(torch.nn.Module):
    """Says two things, as networks for masks do."""

    def forward(self, image: torch.Tensor) -> Tuple[torch.Tensor, torch.Tensor]:
        return torch.zeros(1, 6, 40), image


class Nothing(torch.nn.Module):
    """Says nothing at all."""

    def forward(self, image: torch.Tensor) -> None:
        return None


class Sparse(torch.nn.Module):
    """A tensor, but none that lies in memory as others do."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return torch.full((1, 6, 40), 0.5).to_sparse()


class Endless(torch.nn.Module):
    """More numbers than there is memory, of which none is stored."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return torch.full((1, 1, 1), 0.5).expand(1, 6, 1 << 40)


def many():
    """A box at every second pixel."""
    output = torch.full((1, 6, ROWS * COLUMNS // 4), 0.9)
    output[0, 0] = torch.arange(0, COLUMNS, 2).repeat(ROWS // 2)
    output[0, 1] = torch.arange(0, ROWS, 2).repeat_interleave(COLUMNS // 2)
    output[0, 2:4] = 1
    return output


def save(name, module, **says):
    about = {"imgsz": [ROWS, COLUMNS], "task": "detect", "names": {0: "person", 1: "boat"}} | says
    about = {key: value for key, value in about.items() if value is not None}
    torch.jit.script(module).save(FOLDER / f"{name}.torchscript", _extra_files={"config.txt": json.dumps(about)})
    return about


def save_both(name, module, rows=ROWS, columns=COLUMNS, axes=None, **says):
    """Without `axes` the size of the input is fixed in the ONNX file."""
    about = save(name, module, **says)
    onnx_file.write(FOLDER / f"{name}.onnx", module, rows, columns, about, dynamic_axes=axes)


def main():
    any_size = {"images": {2: "rows", 3: "columns"}}
    save_both("red", Red())
    save_both("silent", Red(), axes=any_size, imgsz=None, task=None, names=None)
    save_both("segment", Red(), task="segment")
    save_both("names", Red(), names={0: "person"})
    save_both("no_size", Red(), axes=any_size, imgsz=[0, 96])
    save_both("not_a_number", NotANumber())
    save_both("lost", Lost())
    save("raises", Raises())
    save_both("square", Square(), rows=96, axes=any_size)
    save_both("pair", Pair())
    save("nothing", Nothing())
    save("sparse", Sparse())
    save("endless", Endless())
    save_both("many", Constant(many()))
    save_both("end_to_end", Constant(torch.full((1, 300, 6), 250.0)), names=None)
    save_both("logits", Constant(torch.full((1, 6, 40), -3.0)))
    save_both("flat", Constant(torch.zeros(6, 40)))


main()
