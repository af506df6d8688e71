"""Lets PyTorch as its wheels bring it be imported without NVIDIA's libraries, which nothing on a CPU calls.

Usage: without_cuda.py, with the interpreter whose PyTorch is meant. Needs gcc, nm and readelf.

The wheels for Linux name a dozen libraries of NVIDIA's, over 2 GB to download, and none of them loads while one is
missing. So each that is missing gets a stand-in beside PyTorch's own: the functions that PyTorch asks of it, under the
versions that it asks for, and each ends the program. Libraries that are there stay as they are.
"""

import re
import subprocess
import sysconfig
import tempfile
from pathlib import Path

SITE_PACKAGES = Path(sysconfig.get_paths()["purelib"])
TORCH = SITE_PACKAGES / "torch/lib"

# Functions of most libraries carry the library's file name as their version; those of these have none, or another.
PREFIXES = {"libnccl": "nccl", "libcurand": "curand", "libcufile": "cuFile", "libcusparseLt": "cusparseLt"}
VERSIONS = {"libnvshmem_host": "NVSHMEM"}

# Of the driver. What needs it is loaded only when there is one.
DRIVER = "libcuda.so.1"


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def missing_libraries():
    folders = [TORCH, *SITE_PACKAGES.glob("nvidia/*/lib")]
    present = {file.name for folder in folders for file in folder.iterdir()}
    needed = set()
    for library in TORCH.glob("*.so"):
        needed.update(re.findall(r"\(NEEDED\).*\[(lib(?:cu|nv|nccl)[^\]]*)\]", output("readelf", "-d", library)))
    return sorted(needed - present - {DRIVER})


def functions_by_version():
    """All that PyTorch's libraries ask for; the version of those without one is ""."""
    functions = {}
    for library in TORCH.glob("*.so"):
        for line in output("nm", "--dynamic", "--undefined-only", library).splitlines():
            name, _, version = line.split()[-1].partition("@")
            functions.setdefault(version, set()).add(name)
    return functions


def make_stand_in(library, functions):
    base = library.split(".so")[0]
    version = VERSIONS.get(base, library)
    versioned = sorted(functions.get(version, ()))
    plain = sorted(name for name in functions[""] if base in PREFIXES and name.startswith(PREFIXES[base]))
    with tempfile.TemporaryDirectory(dir=TORCH) as folder:
        source, script, made = (Path(folder) / name for name in ["source.c", "versions", library])
        source.write_text(
            "extern void abort(void);\n" + "".join(f"void {name}(void) {{ abort(); }}\n" for name in versioned + plain)
        )
        script.write_text(f"{version} {{ global: {' '.join(f'{name};' for name in versioned)} }};\n")
        options = [f"-Wl,--version-script={script}"] if versioned else []
        output("gcc", "-shared", "-fPIC", "-w", "-fno-builtin", f"-Wl,-soname,{library}", *options, source, "-o", made)
        made.rename(TORCH / library)


def main():
    missing = missing_libraries()
    functions = functions_by_version()
    for library in missing:
        make_stand_in(library, functions)


main()
