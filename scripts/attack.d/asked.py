"""Verdicts on options: fixed positions, sizes of components, distances, bytes."""

import formats
import surface
from distance import largest


def value_of(options, name):
    return options[options.index(name) + 1] if name in options else None


def asks(done, option):
    """Returns whether a run has an option, with or without a value after `=`."""
    return any(word.split("=")[0] == option for word in done.options)


def is_repaired(done):
    """Returns whether the mesh was repaired before it was simplified."""
    return asks(done, "--printable") or asks(done, "--fill-holes")


def comparable(subject, result):
    """Returns how positions of both files are compared: in single precision if either file is, as text may have fewer digits."""
    singly = subject.is_single or result.path.suffix == ".stl"
    return lambda point: tuple((formats.single(x) if singly else x) + 0.0 for x in point)


def keeps_positions(subject, done, result):
    """Returns whether fixed positions can be checked: welding moves them, and a glTF stores doubles relative to its own origin."""
    return "--weld" not in done.options and (subject.is_single or result.path.suffix != ".glb")


def of_subset(subject, done, result):
    if not keeps_positions(subject, done, result):
        return
    as_one = comparable(subject, result)
    strangers = set(map(as_one, result.points)) - set(map(as_one, subject.points))
    if strangers:
        yield "subset", f"{len(strangers)} of {result.figures.vertices} vertices are none of the input, such as {min(strangers)}"


def of_locked(subject, done, result):
    if not keeps_positions(subject, done, result) or not subject.figures.manifold:
        return
    as_one, edges = comparable(subject, result), surface.edges_of(result.faces)
    asked = {frozenset(map(as_one, edge)) for edge in subject.boundary}
    missing = asked - {frozenset(as_one(result.points[v]) for v in edge) for edge, around in edges.items() if len(around) == 1}
    if missing:
        yield "locked", f"{len(missing)} of {len(asked)} boundary edges are gone"


def of_pruned(subject, done, result):
    size = next(word for word in done.options if word.startswith("--prune")).partition("=")[2]
    if not size or not subject.figures.edge_manifold or not subject.is_understood(done):
        return
    edges, sets = surface.edges_of(subject.faces), surface.Sets()
    for around in edges.values():
        sets.join(around[0][0], around[-1][0])
    pieces = {}
    for number, face in enumerate(subject.faces):
        pieces.setdefault(sets.find(number), set()).update(subject.points[v] for v in face)
    sizes = sorted(surface.diagonal(list(points)) / subject.diagonal for points in pieces.values())
    limit = float(size.rstrip("%")) / 100
    if any(abs(size / limit - 1) < 1e-4 for size in sizes):
        return
    small = min(sum(size < limit for size in sizes), len(sizes) - 1)
    # Other components may be dropped for their price.
    if result.said["components_pruned"] < small:
        yield "pruned", f"{result.said['components_pruned']} of {len(sizes)} components, {small} are smaller than {size}"


def of_kept_parts(subject, done, result):
    if result.said["components_pruned"] and not asks(done, "--prune"):
        yield "pruned", f"{result.said['components_pruned']} components are gone, all were to be kept"


def of_error(subject, done, result):
    asked = value_of(done.options, "--error")
    if not asked or "--weld" in done.options or len(subject.faces) > 3000:
        return
    asked = float(asked.rstrip("%")) / 100 * subject.diagonal
    # With --prune the bound holds for the remaining components.
    if asks(done, "--prune") and result.said["components_pruned"]:
        return
    found = largest((subject.points, subject.faces), (result.points, result.faces))
    slack = 1e-6 * subject.diagonal
    if found > 1.0001 * asked + slack and not (done.code == 3 and result.outcome != "reached"):
        share = 100 / subject.diagonal
        yield "error", f"{found * share:.4g} % away, {asked * share:.4g} % asked for, exit code {done.code}: {result.outcome}"
    certified = done.report.get("certified")
    if certified and found > 1.0001 * certified["upper"] + slack:
        yield "certified", f"{found:.6g} away, {certified['upper']:.6g} certified"


def of_bytes(subject, done, result):
    asked, size = int(value_of(done.options, "--size")), result.path.stat().st_size
    if size > asked and not (done.code == 3 and result.outcome != "reached"):
        yield "bytes", f"{size} bytes, {asked} asked for, exit code {done.code}: {result.outcome}"


def of_printable(subject, done, result):
    figures = result.figures
    if figures.boundary_edges or figures.disagreeing or not figures.manifold or not figures.components:
        edges = f"{figures.boundary_edges} boundary edges, {figures.disagreeing} disagree"
        yield "solid", f"{edges}, {figures.components} components"


def of_filled(subject, done, result):
    """Checks filled holes of manifold inputs; others are cut apart, which adds boundaries."""
    before, loops, left = subject.figures, result.figures.loops, done.report["repaired"]["holes_left"]
    if before.manifold and loops > min(before.loops, left):
        yield "filled", f"{before.loops} boundary loops become {loops}, {left} holes are said to be left"


# Checks that hold for repaired meshes; the others compare with the input file.
OF_REPAIRED = {
    "--printable": of_printable,
    "--fill-holes": of_filled,
    "--size": of_bytes,
}
CHECKS = {
    "--subset": of_subset,
    "--lock-boundaries": of_locked,
    "--prune": of_pruned,
    "--keep-components": of_kept_parts,
    "--error": of_error,
    "--size": of_bytes,
}
