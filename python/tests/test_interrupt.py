"""Ctrl-C and callbacks interrupt a run within a tenth of a second, and other threads keep running."""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType

import numpy as np
import pytest

import neural_mesh as nm
from conftest import torus

LARGE = torus(1000, 500)


def test_ctrl_c_interrupts_at_once() -> None:
    sent: list[float] = []

    def strike(number: int, frame: FrameType | None) -> None:
        sent.append(time.perf_counter())
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, strike)
    delays = []
    try:
        for after in (0.05, 0.2, 0.4):
            signal.setitimer(signal.ITIMER_REAL, after)
            with pytest.raises(KeyboardInterrupt):
                nm.simplify(LARGE, ratio=0.5, optimize="mean", threads=1)
            # The time from the signal to the caller. Signals are polled every 20 ms and the handler runs only then, so the clock starts at the timer.
            delays.append(time.perf_counter() - sent[-1])
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert max(delays) < 0.1


def test_signals_are_handled_during_a_run() -> None:
    times: list[float] = []
    before = signal.signal(signal.SIGALRM, lambda number, frame: times.append(time.perf_counter()))
    began = time.perf_counter()
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        nm.simplify(LARGE, ratio=0.5, threads=1)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert times and times[0] - began < 0.3


def test_progress_rises_and_an_exception_ends_the_run() -> None:
    heard: list[tuple[float, str]] = []
    nm.simplify(LARGE, ratio=0.2, progress=lambda done, stage: heard.append((done, stage)))
    done = [share for share, _ in heard]
    assert done == sorted(done) and done[-1] == 1.0 and len(done) > 3
    assert {"surface", "done"} <= {stage for _, stage in heard}

    class Enough(Exception):
        pass

    def stop(share: float, stage: str) -> None:
        raise Enough

    began = time.perf_counter()
    with pytest.raises(Enough):
        nm.simplify(LARGE, ratio=0.5, optimize="mean", progress=stop)
    assert time.perf_counter() - began < 1.5


def test_other_threads_run_during_a_run() -> None:
    ticks: list[float] = []
    is_over = threading.Event()

    def tick() -> None:
        while not is_over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.005)

    thread = threading.Thread(target=tick)
    thread.start()
    began = time.perf_counter()
    nm.simplify(LARGE, ratio=0.2)
    ended = time.perf_counter()
    is_over.set()
    thread.join()
    within = np.asarray([t for t in ticks if began < t < ended])
    assert len(within) > 10 and np.diff(within).max() < 0.5


def test_concurrent_runs_are_independent() -> None:
    mesh = torus(150, 80)
    expected = nm.simplify(mesh, ratio=0.2)
    results: list[nm.Light] = []
    threads = [threading.Thread(target=lambda: results.append(nm.simplify(mesh, ratio=0.2))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    for light in results:
        np.testing.assert_array_equal(light.vertices, expected.vertices)
