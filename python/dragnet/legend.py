"""The legend below a picture: samples and words, in plain NumPy, so that pictures need no other library."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

#: A word, in the letters of ``_LETTERS``, and a sample of what it names.
Entry = tuple[str, NDArray[np.uint8]]

#: Height of a line and space between entries, pixels.
_LINE = 18
_GAP = 8
#: A letter with the space after it, pixels.
_LETTER_WIDTH = 6
_LETTER_HEIGHT = 7

#: The rows of each letter from the top, five bits each, in hexadecimal; only those that a legend needs.
_LETTERS = {
    " ": "00000000000000",
    ",": "00000000000408",
    "1": "040c040404040e",
    "2": "0e11010204081f",
    "3": "1f02040201110e",
    "4": "02060a121f0202",
    "5": "1f101e0101110e",
    "A": "0e11111f111111",
    "B": "1e11111e11111e",
    "C": "0e11101010110e",
    "D": "1e11111111111e",
    "E": "1f10101e10101f",
    "F": "1f10101e101010",
    "G": "0e11101711110e",
    "H": "1111111f111111",
    "I": "0e04040404040e",
    "J": "0702020202120c",
    "K": "11121418141211",
    "L": "1010101010101f",
    "N": "11191513111111",
    "O": "0e11111111110e",
    "P": "1e11111e101010",
    "R": "1e11111e141211",
    "S": "0f10100e01011e",
    "T": "1f040404040404",
    "U": "1111111111110e",
}


def legend(entries: Sequence[Entry], width: int) -> NDArray[np.uint8]:
    """The entries in as many lines as the width (pixels) makes of them, shape ``(height, width, 3)``."""
    lines: list[list[NDArray[np.uint8]]] = [[]]
    taken = 0
    for word, sample in entries:
        block = _block(word, sample)
        if taken and taken + block.shape[1] > width:
            lines.append([])
            taken = 0
        lines[-1].append(block)
        taken += block.shape[1]
    image = np.full((_LINE * len(lines), width, 3), 255, dtype=np.uint8)
    for place, line in enumerate(lines):
        row = np.concatenate(line, axis=1)[:, :width]
        image[place * _LINE : (place + 1) * _LINE, : row.shape[1]] = row
    return image


def _block(word: str, sample: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width, _ = sample.shape
    block = np.full((_LINE, _GAP + width + _GAP // 2 + len(word) * _LETTER_WIDTH, 3), 255, dtype=np.uint8)
    top = (_LINE - height) // 2
    # A frame: a white sample would not be seen.
    block[top - 1 : top + height + 1, _GAP - 1 : _GAP + width + 1] = 160
    block[top : top + height, _GAP : _GAP + width] = sample
    top = (_LINE - _LETTER_HEIGHT) // 2
    left = _GAP + width + _GAP // 2
    for place, letter in enumerate(word):
        rows = np.frombuffer(bytes.fromhex(_LETTERS[letter]), dtype=np.uint8)
        dots = np.unpackbits(rows[:, None], axis=1)[:, 3:].astype(np.bool_)
        at = left + place * _LETTER_WIDTH
        block[top : top + _LETTER_HEIGHT, at : at + _LETTER_WIDTH - 1][dots] = 0
    return block
