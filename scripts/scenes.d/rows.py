"""Keeps the measured rows in a CSV file, so that a run that was stopped goes on where it was."""

import csv

from measure import COLUMNS


class Rows:
    """Rows by scene and run; each is on disk as soon as it is added."""

    def __init__(self, path, is_kept):
        """Reads the rows of a file and drops those that are not kept; `is_kept` takes scene and run."""
        rows = list(csv.DictReader(path.open(newline=""))) if path.exists() else []
        # What was measured stays on disk until all that is kept is there again.
        unfinished = path.with_suffix(".part")
        with unfinished.open("w", newline="") as file:
            csv.DictWriter(file, COLUMNS).writeheader()
        self.path, self.of_scenes = unfinished, {}
        for row in rows:
            if is_kept(row["scene"], row["run"]):
                self.add(row["scene"], row["run"], row)
        self.path = unfinished.rename(path)

    def has(self, scene, run):
        return run in self.of_scenes.get(scene, {})

    def add(self, scene, run, row):
        row = {"scene": scene, "run": run} | {key: value for key, value in row.items() if value not in (None, "")}
        self.of_scenes.setdefault(scene, {})[run] = row
        with self.path.open("a", newline="") as file:
            csv.DictWriter(file, COLUMNS).writerow(row)

    def walk(self):
        """Yields (scene, run, row) for all rows."""
        for scene, rows in self.of_scenes.items():
            for run, row in rows.items():
                yield scene, run, row

    def number(self, scene, run, column):
        """Returns a figure of a row; None where there is none."""
        value = self.of_scenes.get(scene, {}).get(run, {}).get(column)
        return None if value is None else float(value)

    def word(self, scene, run, column):
        return str(self.of_scenes.get(scene, {}).get(run, {}).get(column, ""))
