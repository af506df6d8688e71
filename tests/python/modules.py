"""Makes TorchScript modules by hand for tests of the detector: one that works, and some that do not.

Usage: modules.py FOLDER. Each is written there as `NAME.torchscript`; those that say how large their images are say 64 rows
and 96 columns.
"""

import json
import sys
from pathlib import Path
from typing import Tuple

import torch

FOLDER = Path(sys.argv[1])
ROWS, COLUMNS = 64, 96


class Red(torch.nn.Module):
    """Finds what is red, as one box around all of it: class 0 if that is upright, else class 1."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        red = (image[0, 0] > 0.6) & (image[0, 1] < 0.3) & (image[0, 2] < 0.3)
        rows, columns = torch.where(red.any(1))[0], torch.where(red.any(0))[0]
        output = torch.zeros(1, 6, 1)
        output[0, 2:4] = 1
        if rows.numel() > 0:
            top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
            output[0, :4, 0] = torch.stack([left + right, top + bottom, 2 * (right - left), 2 * (bottom - top)]) / 2
            output[0, 4 if bool(bottom - top > right - left) else 5, 0] = 0.9
        return output


class Constant(torch.nn.Module):
    """Says the same of every image."""

    def __init__(self, output):
        super().__init__()
        self.register_buffer("output", output)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return self.output


class NotANumber(torch.nn.Module):
    """Is a detector of gray images; of others it says nothing that is a number."""

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        output = torch.full((1, 6, 40), 0.5)
        return output / 0 * 0 if bool(image.std() > 0.01) else output


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
    extra = {"config.txt": json.dumps({key: value for key, value in about.items() if value is not None})}
    torch.jit.script(module).save(FOLDER / f"{name}.torchscript", _extra_files=extra)


def main():
    save("red", Red())
    save("silent", Red(), imgsz=None, task=None, names=None)
    save("segment", Red(), task="segment")
    save("names", Red(), names={0: "person"})
    save("no_size", Red(), imgsz=[0, 96])
    save("not_a_number", NotANumber())
    save("raises", Raises())
    save("square", Square())
    save("pair", Pair())
    save("nothing", Nothing())
    save("sparse", Sparse())
    save("endless", Endless())
    save("many", Constant(many()))
    save("end_to_end", Constant(torch.full((1, 300, 6), 250.0)), names=None)
    save("logits", Constant(torch.full((1, 6, 40), -3.0)))
    save("flat", Constant(torch.zeros(6, 40)))


main()
