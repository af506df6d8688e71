"""Run a dragnet command in shards over a Ray cluster, then merge the parts.

  python scale/ray_sweep.py --address auto --shards 200 --out results -- \\
      compare scenarios/paper/*.toml --policies greedy,path --seeds 50

Ray places the shards, and runs again those that are lost or fail. To go on after a failure start the same sweep once
more: what is done is not run again. Exit codes: 0 done, 1 a shard failed, 2 bad input.
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

BAD_INPUT = 2
"""Exit code of what cannot be done, whoever tries."""

MAX_SHARDS = 100_000
"""As dragnet allows."""

LAST_LINES = 5
"""So much of what a failed command said is told."""

POLL_SECONDS = 1.0

Files = dict[str, bytes]
"""Content by path, relative to a folder."""


class BadInput(Exception):
    """To try again is in vain."""


class ShardFailed(Exception):
    """The command failed, and may succeed elsewhere or later."""


@dataclass(frozen=True)
class Sweep:
    """A command in shards."""

    program: str
    command: list[str]
    """Its arguments, without those of shards."""
    shards: int
    threads: int
    """Of one shard."""
    out: Path
    folder: Path | None
    """Where the command runs; without, where Ray has put what was uploaded."""
    collect: bool
    """Whether parts come back through Ray, and not by a shared folder."""

    def run(self, shard: int) -> Files:
        """Runs a shard on this node; what it made, if that is collected."""
        if not self.collect:
            self.call(shard, self.out)
            return {}
        with tempfile.TemporaryDirectory() as name:
            self.call(shard, Path(name))
            made = [path for path in Path(name).rglob("*") if path.is_file()]
            return {str(path.relative_to(name)): path.read_bytes() for path in made}

    def call(self, shard: int, out: Path) -> None:
        command = [self.program, *self.command, "--shard", f"{shard}/{self.shards}", "--out", str(out)]
        environment = {**os.environ, "RAYON_NUM_THREADS": str(self.threads)}
        where = f"shard {shard} on {socket.gethostname()}"
        try:
            done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True)
        except OSError as error:
            raise ShardFailed(f"{where}: {error}") from None
        if done.returncode != 0:
            said = "\n".join(done.stderr.strip().splitlines()[-LAST_LINES:])
            failure = BadInput if done.returncode == BAD_INPUT else ShardFailed
            raise failure(f"{where}: exit code {done.returncode}\n{said}")

    def remaining(self) -> list[int]:
        """The shards to run. In a shared folder the command itself knows what is done; what was collected is known by
        its name here, and merging tells whether it belongs."""
        shards = range(1, self.shards + 1)
        there = {path.name.split(".")[0] for path in self.out.iterdir()} if self.collect else set()
        return [shard for shard in shards if f"part-{shard}-of-{self.shards}" not in there]

    def keep(self, files: Files) -> None:
        """Writes what was collected, each file as a whole or not at all; last the part, which says that all is there."""
        for name, content in sorted(files.items(), key=lambda file: file[0].startswith("part-")):
            path = self.out / name
            path.parent.mkdir(parents=True, exist_ok=True)
            unfinished = path.with_name(f".unfinished-{path.name}")
            unfinished.write_bytes(content)
            unfinished.replace(path)

    def merge(self, folder: Path) -> int:
        out = str(self.out)
        return subprocess.run([self.program, "merge", out, "--out", out], cwd=folder).returncode


def run_all(sweep: Sweep, shards: list[int], retries: int) -> Iterator[tuple[int, Exception | None]]:
    """Runs shards; each one as it ends, with why it failed for good."""
    import ray

    @ray.remote
    def run(shard: int) -> Files:
        return sweep.run(shard)

    run = run.options(num_cpus=sweep.threads, max_retries=retries, retry_exceptions=[ShardFailed])
    tasks = {run.remote(shard): shard for shard in shards}
    while tasks:
        ended, _ = ray.wait(list(tasks), num_returns=len(tasks), timeout=POLL_SECONDS)
        for task in ended:
            shard = tasks.pop(task)
            try:
                sweep.keep(ray.get(task))
            except ray.exceptions.RayTaskError as error:
                yield shard, error.cause
            except ray.exceptions.RayError as error:
                yield shard, error
            else:
                yield shard, None


def watch(sweep: Sweep, retries: int) -> list[int]:
    """Runs a sweep and says how far it is; the shards that failed."""
    shards = sweep.remaining()
    failed = []
    for count, (shard, failure) in enumerate(run_all(sweep, shards, retries), start=1):
        if isinstance(failure, BadInput):
            raise failure
        if failure:
            failed.append(shard)
            say(f"failed: {failure}")
        show_progress(shard, count, len(shards))
    return failed


def show_progress(shard: int, count: int, total: int) -> None:
    """A bar on a terminal, a line elsewhere."""
    if not sys.stderr.isatty():
        say(f"shard {shard} has ended: {count} of {total}")
        return
    filled = 40 * count // total
    bar = "#" * filled + "." * (40 - filled)
    end = "\n" if count == total else ""
    print(f"\r{bar} {count} of {total} shards", end=end, file=sys.stderr, flush=True)


def say(line: str) -> None:
    start = "\r\x1b[K" if sys.stderr.isatty() else ""
    print(f"{start}{line}", file=sys.stderr, flush=True)


def start_ray(options: argparse.Namespace) -> None:
    """Joins a cluster, or starts one on this machine."""
    # Ray reports its use to its makers otherwise.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
    except ImportError:
        raise BadInput("Ray is missing: pip install --requirement scale/requirements.txt") from None
    local = {} if options.address else {"num_cpus": options.cores, "include_dashboard": False}
    environment = {"working_dir": str(options.upload)} if options.upload else None
    try:
        check_address(options.address or "")
        ray.init(
            address=options.address or "local",
            runtime_env=environment,
            log_to_driver=False,
            logging_level=logging.ERROR,
            **local,
        )
    except (OSError, RuntimeError, ValueError) as error:
        raise BadInput(f"--address {options.address}: {error}") from None


def check_address(address: str) -> None:
    """That somebody listens at HOST:PORT, for which Ray would wait without an end."""
    host, _, port = address.rpartition(":")
    if port.isdecimal() and "//" not in host:
        socket.create_connection((host, int(port)), timeout=10).close()


def whole_number(least: int, most: int) -> Callable[[str], int]:
    """A reader of whole numbers in a range."""

    def read(text: str) -> int:
        if text.isdecimal() and least <= int(text) <= most:
            return int(text)
        raise argparse.ArgumentTypeError(f"{text!r}: allowed is a whole number, {least} to {most}")

    return read


def folder(text: str) -> Path:
    path = Path(text).resolve()
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {text}")
    return path


def read_options() -> argparse.Namespace:
    summary, _, example = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        description=summary, epilog=example, formatter_class=argparse.RawDescriptionHelpFormatter
    )

    def add(name: str, value: str, says: str, **more: Any) -> None:
        parser.add_argument(name, metavar=value, help=says, **more)

    add("--shards", "N", "into so many parts", required=True, type=whole_number(1, MAX_SHARDS))
    add("--out", "DIR", "folder of parts and results, shared by all nodes", required=True, type=Path)
    parser.add_argument("--collect", action="store_true", help="bring the parts to --out through Ray instead")
    add("--upload", "DIR", "bring this folder to all nodes first, and run the command in it", type=folder)
    add("--program", "FILE", "the program [default: %(default)s]; with --upload, in there", default="dragnet")
    add("--threads", "N", "cores of a shard [default: 1]", default=1, type=whole_number(1, 1024))
    add("--retries", "N", "of a shard [default: 3]", default=3, type=whole_number(0, 1000))
    add("--address", "HOST:PORT", "of a Ray cluster, or auto [default: start one on this machine]")
    add("--cores", "N", "of the cluster on this machine [default: all]", type=whole_number(1, 65536))
    add("command", "COMMAND", "after --: what dragnet does, without --shard and --out", nargs="+")
    return parser.parse_args()


def find_program(options: argparse.Namespace) -> str:
    """Relative to the folder that is uploaded, or else its absolute path."""
    name = options.program
    found = shutil.which(options.upload / name if options.upload else name)
    if found is None:
        raise BadInput(f"--program {name}: there is no such program in {options.upload or 'the search path'}")
    return os.path.join(".", name) if options.upload else os.path.abspath(found)


def plan(options: argparse.Namespace) -> Sweep:
    try:
        options.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"--out {options.out}: cannot make the folder: {error}") from None
    return Sweep(
        program=find_program(options),
        command=options.command,
        shards=options.shards,
        threads=options.threads,
        out=options.out.resolve(),
        folder=None if options.upload else Path.cwd(),
        collect=options.collect,
    )


def main() -> int:
    options = read_options()
    try:
        sweep = plan(options)
        # Stdout is for results; Ray tells there which workers it lost.
        with contextlib.redirect_stdout(sys.stderr):
            start_ray(options)
            failed = watch(sweep, options.retries)
    except BadInput as error:
        say(f"error: {error}")
        return BAD_INPUT
    if failed:
        say(f"error: {len(failed)} of {sweep.shards} shards failed; start the same sweep again to go on")
        return 1
    return sweep.merge(options.upload or Path.cwd())


if __name__ == "__main__":
    sys.exit(main())
