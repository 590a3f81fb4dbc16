"""Runs of the program."""

import json
import resource
import subprocess
import time
from dataclasses import dataclass

# A run may take so many seconds, by the clock and of the processor's time: a busy machine is no fault of the program.
SECONDS = 20
# It is stopped after so many by the clock; if it has hardly used the processor until then, it waits for itself.
STOPPED_AFTER, IDLE = 120, 1
MEMORY = 4 << 30


@dataclass
class Done:
    """A run that has ended."""

    options: list
    code: int
    """The exit code; below zero the signal."""
    out: str
    words: str
    """What it said on standard error."""
    seconds: float
    meshes: list
    """The mesh files that it wrote: one, or one for each level of detail."""
    stopped: bool
    """Whether it took too long by the clock."""
    report: dict
    """What `--report` holds; None if it is not there."""
    stray: list
    """Other files that it left."""


def run(program, mesh, output, options):
    """Simplifies a mesh into a folder of its own, which holds nothing yet."""
    report, folder = output.with_suffix(".json"), output.parent
    command = [program, "simplify", mesh, "-o", output, "--report", report, "--quiet", *options]
    before, began = processor_seconds(), time.monotonic()
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=STOPPED_AFTER, preexec_fn=bounded)
        code, out, words = done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired as stopped:
        code, out, words = -9, stopped.stdout or b"", stopped.stderr or b""
    by_clock = time.monotonic() - began
    by_processor = processor_seconds() - before
    waits_for_itself = by_processor < IDLE and by_clock > STOPPED_AFTER
    seconds = by_clock if waits_for_itself else min(by_clock, by_processor)
    left = sorted(path for path in folder.iterdir() if path != report)
    meshes = sorted(path for path in left if path == output or path.name.startswith(output.stem + "-lod"))
    stray = [path.name for path in left if path not in meshes]
    said = [text.decode("utf-8", "replace") for text in (out, words)]
    told = json.loads(report.read_text()) if report.exists() else None
    return Done(options, code, *said, seconds, meshes, by_clock > STOPPED_AFTER, told, stray)


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def bounded():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
