"""Writes networks as ONNX files with PyTorch alone.

Ultralytics writes what a network is for beside it, as texts: a dictionary of Python for the names. So does this.
"""

import io

import torch
from torch.onnx._internal.torchscript_exporter import onnx_proto_utils

# It would look for functions of a package that none of these networks uses, in a package that is not installed.
onnx_proto_utils._add_onnxscript_fn = lambda model, _functions: model


def write(path, module, rows, columns, about, **options):
    """Writes a network whose input has these rows and columns; `about` are texts by their names."""
    file = io.BytesIO()
    torch.onnx.export(
        module,
        (torch.full((1, 3, rows, columns), 114 / 255),),
        file,
        dynamo=False,
        opset_version=17,
        input_names=["images"],
        output_names=["output0"],
        **options,
    )
    path.write_bytes(file.getvalue() + b"".join(entry(name, str(value)) for name, value in about.items()))


def entry(name, value):
    """A message of Protocol Buffers may be continued at its end: here by `metadata_props`, its field 14."""
    return field(14, field(1, name.encode()) + field(2, value.encode()))


def field(number, value):
    return varint(number << 3 | 2) + varint(len(value)) + value


def varint(number):
    low, high = number & 127, number >> 7
    return bytes([low | 128]) + varint(high) if high else bytes([low])
