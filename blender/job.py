# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs work on arrays in a thread, with its progress and a way to stop it.
The work does not touch Blender's data; the operator that started it reads the outcome in the main thread."""

import threading


class Refusal(Exception):
    """A request that cannot be met, with one line that says why and what to do."""


class Stopped(Exception):
    """Raised inside the work once it has been stopped."""


class Job:
    """Work in a thread; `error` says in one line why it failed."""

    def __init__(self, work):
        self.progress = 0.0
        self.error = None
        self._work = work
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def is_running(self):
        """Returns whether the thread is at work."""
        return self._thread.is_alive()

    @property
    def is_stopped(self):
        """Returns whether the work was asked to stop."""
        return self._stop.is_set()

    def request_stop(self):
        """Asks the work to stop at its next report of progress."""
        self._stop.set()

    def stop(self):
        """Stops the work at its next report of progress and waits for that."""
        self._stop.set()
        self._thread.join()

    def _run(self):
        try:
            self._work(self._tell)
        except Stopped:
            pass
        # No caller of this thread could catch an exception.
        except Exception as error:
            self.error = first_line(error)

    def _tell(self, done):
        self.progress = done
        if self._stop.is_set():
            raise Stopped


def first_line(error):
    """Returns the first line of an exception's message, or its type."""
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
