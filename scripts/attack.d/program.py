"""Runs of the program."""

import json
import resource
import signal
import subprocess
import time
from dataclasses import dataclass

# Seconds that a run may take, by both wall clock and processor time, so that a busy machine is no failure; soon after it is stopped.
SECONDS = 20
# Wall-clock seconds after which a run is stopped; with little processor time it is deadlocked.
STOPPED_AFTER, IDLE = 120, 1
MEMORY = 4 << 30


@dataclass
class Done:
    """A finished run."""

    options: list
    code: int
    """Exit code, or the negative number of the signal."""
    out: str
    words: str
    """Text on standard error."""
    seconds: float
    meshes: list
    """Written mesh files: one, or one for each level of detail."""
    stopped: bool
    """Whether it was stopped since it took too long."""
    report: dict
    """Content of the `--report` file; None if it is missing."""
    stray: list
    """Other files in the output folder."""


def run(program, mesh, output, options):
    """Simplifies a mesh into an empty folder."""
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
    stopped = by_clock > STOPPED_AFTER or code == -signal.SIGXCPU
    return Done(options, code, *said, seconds, meshes, stopped, told, stray)


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def bounded():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS + 2, SECONDS + 10))
