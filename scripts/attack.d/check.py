"""Checks the judge with results that are broken on purpose, each with the promise that it breaks."""

import tempfile
from dataclasses import replace
from pathlib import Path

import flaws
import formats
import shapes
from judge import judged
from program import Done
from promises import PROMISES
from subject import Result, Subject
from surface import has_no_area

RING = shapes.torus(12, 8, 0.5)
BALL = [tuple(map(formats.single, point)) for point in shapes.icosphere(2)[0]], shapes.icosphere(2)[1]
TWO = shapes.joined(BALL, shapes.moved(BALL, (3.0, 0, 0)))
OPEN = BALL[0], BALL[1][1:]
CUBE = shapes.box(2, 2, 2)
# Two opposite faces attached to an edge: closed until one of them is removed.
FLAP = [*BALL[0], (3.0, 0.0, 0.0)], BALL[1] + [(*BALL[1][0][:2], 162), (162, *BALL[1][0][1::-1])]
EDGE = shapes.welded(shapes.joined(CUBE, shapes.moved(CUBE, (1, 1, 0))))


def sound(folder, mesh, result, options, ending=".ply"):
    """Returns a run that wrote this result with a correct report."""
    given, path = folder / "in.ply", folder / ("out" + ending)
    formats.write(given, *mesh, double=True)
    formats.write(path, *result, double=True)
    subject = Subject(given)
    output = dict(vars(Result(path, {}, "", [], True).figures), components_pruned=0, split_vertices=0)
    output["closed"] = output["boundary_edges"] == 0
    keys = ["vertices", "faces", "closed", "components", "euler", "non_manifold_edges", "non_manifold_vertices"]
    report = {"input": {key: getattr(subject.figures, key) for key in keys}, "output": output, "outcome": "reached"}
    return subject, Done(options, 0, "", "", 0.1, [path], False, report, [])


def kinds(*of_run, **changes):
    with tempfile.TemporaryDirectory() as folder:
        subject, done = sound(Path(folder), *of_run)
        output = changes.pop("output", {})
        report = {**done.report, **changes.pop("said", {}), "output": {**done.report["output"], **output}}
        return {kind for kind, _ in judged(subject, replace(done, **{"report": report, **changes}))}


def broken():
    """Yields kind, mesh, result, options, and other changes of the run."""
    whole, half = ["--ratio", "1"], ["--ratio", "0.5"]
    a, b, _ = BALL[1][0]
    folded = [BALL[0][b if i == a else i] for i in range(len(BALL[0]))], BALL[1]
    moved = [(9.0, 0.0, 0.0) if i == 0 else point for i, point in enumerate(BALL[0])], BALL[1]
    yield "crash", BALL, BALL, whole, {"code": 101}
    yield "hang", BALL, BALL, whole, {"seconds": 21.0}
    yield "words", BALL, BALL, whole, {"code": 1, "words": "two\nlines", "meshes": [], "report": None}
    yield "whole", BALL, BALL, whole, {"meshes": []}
    yield "exit", BALL, BALL, whole, {"code": 3}
    yield "refused", BALL, BALL, whole, {"code": 1, "words": "neural-mesh: no", "meshes": [], "report": None}
    yield "file", BALL, ([(float("nan"),) * 3, *BALL[0][1:]], BALL[1]), whole, {}
    yield "doubled", BALL, (BALL[0], BALL[1] + [BALL[1][0][::-1]]), whole, {}
    yield "degenerate", BALL, folded, whole, {}
    yield "positions", BALL, folded, whole, {"output": {"vertices": 162}}
    yield "closed", BALL, OPEN, whole, {}
    yield "manifold", OPEN, (BALL[0], OPEN[1] + [(0, 100, 101)]), whole, {}
    yield "winding", BALL, (BALL[0], OPEN[1] + [BALL[1][0][::-1]]), whole, {}
    yield "pieces", TWO, BALL, half, {}
    yield "handles", RING, shapes.icosphere(1), half, {}
    yield "loops", OPEN, BALL, whole, {}
    yield "size", BALL, shapes.icosphere(1), half, {}
    yield "unchanged", BALL, shapes.icosphere(1), whole, {}
    yield "report", BALL, BALL, whole, {"output": {"faces": 319}}
    yield "subset", BALL, moved, [*whole, "--subset"], {}
    yield "locked", OPEN, ([(x, y, z + 1e-3) for x, y, z in OPEN[0]], OPEN[1]), [*whole, "--lock-boundaries"], {}
    yield "pruned", TWO, TWO, [*half, "--prune=80%"], {}
    yield "pruned", TWO, BALL, [*half, "--keep-components"], {"output": {"components_pruned": 1}}
    yield "error", BALL, moved, ["--error", "1%"], {}
    yield "bytes", BALL, BALL, ["--size", "100"], {}
    yield "closed even", EDGE, (EDGE[0], EDGE[1][1:]), half, {"output": {"split_vertices": 9}}
    yield "closed again", FLAP, OPEN, half, {"output": {"split_vertices": 99}}
    yield "read", BALL, BALL, whole, {"said": {"input": {"components": 2, "closed": True}}}
    yield "certified", BALL, moved, ["--error", "1%"], {"said": {"certified": {"upper": 0.1}}}
    yield "solid", BALL, OPEN, [*whole, "--printable"], {}
    yield "filled", BALL, OPEN, [*whole, "--fill-holes"], {"said": {"repaired": {"holes_left": 0}}}
    yield "astray", BALL, moved, whole, {}


def everything_is_seen():
    """Fails if the judge misses a broken result or rejects a sound one."""
    for mesh in (RING, BALL, TWO, OPEN):
        for options in (["--ratio", "1"], ["--ratio", "1", "--subset", "--lock-boundaries"], ["--error", "1%"]):
            assert not kinds(mesh, mesh, options), (options, kinds(mesh, mesh, options))
    seen = set()
    for kind, mesh, result, options, changes in broken():
        assert kind in kinds(mesh, result, options, **changes), kind
        seen.add(kind)
    assert has_no_area((0.1, 0.1, 0.1), (0.2, 0.2, 0.2), (0.4, 0.4, 0.4))
    assert not has_no_area((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (2.0, 2.0, 2.0 + 1e-15))
    print(f"the judge sees {len(seen)} of {len(PROMISES)} kinds of broken promises, all but {', '.join(PROMISES.keys() - seen)}")
