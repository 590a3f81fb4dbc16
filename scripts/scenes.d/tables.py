"""Prints what the rows say: each figure against the range that is wanted, and the scenes where it is farthest outside."""

import math
import textwrap
from dataclasses import dataclass
from typing import Callable

# By what a largest distance may exceed its bound: a share of it, and rounding of singles in percent of the diagonal.
ROUNDING, SINGLES = 1e-6, 1e-5
# Smaller figures count as these: percent of the diagonal, degrees, seconds. Nobody sees them, and their quotients say nothing.
LEAST = {"mean": 1e-4, "max": 1e-2, "angle": 1e-2, "cpu": 1e-3}
INFINITE = float("inf")


@dataclass
class Figure:
    """A quotient per scene, and the range that is wanted of it."""

    title: str
    find: Callable  # (rows, scene) -> quotient, None where there is none
    low: float
    high: float

    def is_good(self, value):
        return self.low <= value <= self.high

    def find_excess(self, value):
        """Returns by which factor a quotient is outside of the range."""
        return max(self.low / max(value, 1e-9), value / self.high)


def list_figures():
    for bound in (1, 5):
        yield Figure(f"--error {bound}%: largest distance / bound", bound_share(bound), 0, 1 + ROUNDING + SINGLES / bound)
    for ratio in (0.5, 0.1):
        run = f"ratio {ratio}"
        yield Figure(f"{run}: printed mean / measured", columns_quotient("reported_mean", run, "mean", run), 0.95, 1.05)
        yield Figure(f"{run}: printed max / measured", columns_quotient("reported_max", run, "max", run), 0.95, INFINITE)
        yield Figure(f"{run}: vertices / asked for, where reached", vertices_share(ratio), 0.97, 1)
    run = "faces of ratio 0.1"
    yield Figure("mean: --faces / --ratio 0.1", columns_quotient("mean", run, "mean", "ratio 0.1"), 0.98, 1.02)
    for tool in ("gltfpack", "gltfpack -sa"):
        for column, other in (("mean", "mean"), ("max", "max"), ("angle", "angle"), ("cpu", "cpu"), ("cpu_no_check", "cpu")):
            yield Figure(f"{column}: program / {tool}", columns_quotient(column, f"as {tool}", other, tool), 0, 1)
        yield Figure(f"error of pictures: program / {tool}", pictures_quotient(tool), 0, 1)


def columns_quotient(column, run, other_column, other_run):
    """Returns the function that divides a column of a run by another's; there is none where both are too small to see."""

    def find(rows, scene):
        above, below = rows.number(scene, run, column), rows.number(scene, other_run, other_column)
        least = LEAST[other_column]
        if above is None or below is None or max(above, below) < least:
            return None
        return max(above, least) / max(below, least)

    return find


def is_promised(rows, scene, run):
    """Returns whether the program says that it did what it was asked for."""
    return rows.word(scene, run, "exit") == "0" and rows.word(scene, run, "outcome") == "reached"


def bound_share(bound):
    """Returns the function that divides the largest distance by a bound that the program says it holds."""

    def find(rows, scene):
        largest = rows.number(scene, f"error {bound}%", "max")
        return largest / bound if largest is not None and is_promised(rows, scene, f"error {bound}%") else None

    return find


def vertices_share(ratio):
    """Returns the function that divides the vertices by those asked for; it gives 1 for up to two fewer, as a merge takes."""

    def find(rows, scene):
        if not is_promised(rows, scene, f"ratio {ratio}"):
            return None
        asked = max(math.ceil(ratio * rows.number(scene, f"ratio {ratio}", "reported_input_vertices")), 3)
        vertices = rows.number(scene, f"ratio {ratio}", "reported_vertices")
        return 1.0 if asked - 2 <= vertices <= asked else vertices / asked

    return find


def pictures_quotient(tool):
    """Returns the function that divides the root mean square errors of pixels, from their PSNR."""

    def find(rows, scene):
        ours, theirs = (rows.number(scene, f"picture of {run}", "psnr") for run in (f"as {tool}", tool))
        return None if ours is None or theirs is None else 10 ** ((theirs - ours) / 20)

    return find


def print_tables(rows, n_worst):
    """Prints a line per figure, then the worst scenes of each, then what is no number."""
    found = [(figure, {scene: figure.find(rows, scene) for scene in rows.of_scenes}) for figure in list_figures()]
    found = [(figure, {scene: value for scene, value in values.items() if value is not None}) for figure, values in found]
    print("| figure | wanted | scenes | as wanted | geometric mean | least | largest |\n|---|---|---|---|---|---|---|")
    for figure, values in found:
        if values:
            numbers = list(values.values())
            mean = math.exp(sum(math.log(max(value, 1e-9)) for value in numbers) / len(numbers))
            cells = [f"{figure.low:.3g} to {figure.high:.3g}", len(values), sum(map(figure.is_good, numbers))]
            cells += [f"{mean:.3f}", f"{min(numbers):.3g}", f"{max(numbers):.3g}"]
            print("|", " | ".join(map(str, [figure.title, *cells])), "|")
    for figure, values in found:
        missed = [scene for scene in values if not figure.is_good(values[scene])]
        missed.sort(key=lambda scene: -figure.find_excess(values[scene]))
        if missed:
            print(f"\n{figure.title}: {', '.join(f'{scene} {values[scene]:.4g}' for scene in missed[:n_worst])}")
    for title, describe in WORDS.items():
        lines = [f"{scene}, {run}: {words}" for scene, run, row in rows.walk() if (words := describe(rows, row))]
        print(f"\n{title}: {len(lines)}", *lines, sep="\n    ")


def describe_broken_off(rows, row):
    return row["run"].startswith("error") and row.get("outcome") != "reached" and row.get("outcome")


def describe_faces(rows, row):
    counted, reported = rows.number(row["scene"], "input", "faces"), rows.number(row["scene"], row["run"], "reported_input_faces")
    return row["run"] == "ratio 0.1" and reported is not None and counted != reported and f"{counted:.0f} {reported:.0f}"


def describe_diagonal(rows, row):
    placed, reported = rows.number(row["scene"], "input", "diagonal"), rows.number(row["scene"], row["run"], "reported_diagonal")
    return row["run"] == "error 1%" and reported is not None and abs(reported / placed - 1) > 1e-3 and f"{reported / placed:.4g}"


WORDS = {
    "bound not promised": describe_broken_off,
    "meshes that vanished": lambda rows, row: textwrap.shorten(row.get("vanished", ""), 120, placeholder=" ..."),
    "faces of the input, counted and reported": describe_faces,
    "diagonal, reported / of the scene": describe_diagonal,
    "no result": lambda rows, row: row["run"] != "input" and "faces" not in row and "psnr" not in row and row.get("note"),
}
