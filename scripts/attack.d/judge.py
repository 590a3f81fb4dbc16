"""Judges the files that the program wrote by its promises.

Each verdict is a pair: the kind of the promise that is broken, one of `promises.PROMISES`, and what was found.
"""

import re

import formats
import surface
from asked import CHECKS, OF_REPAIRED, asks, is_repaired, value_of
from program import SECONDS
from subject import Result


def judged(subject, done):
    """Returns all verdicts on a run."""
    found = list(of_run(subject, done))
    if found or done.stopped or done.code not in (0, 3):
        return found
    return [verdict for result in results(subject, done, found) for verdict in of_result(subject, done, result)] + found


def of_run(subject, done):
    """Checks how the run ended, apart from its files."""
    if done.seconds > SECONDS:
        yield "hang", f"{done.seconds:.0f} s of the processor"
    if done.stopped:
        return
    if done.code not in (0, 1, 2, 3) or "panicked" in done.words:
        yield "crash", f"exit code {done.code}: {done.words.strip()[:300]}"
        return
    lines = done.words.splitlines()
    is_line = len(lines) == 1 and lines[0].startswith("neural-mesh: ") and lines[0].isprintable()
    if done.out or (not is_line if done.code in (1, 2, 3) else lines):
        yield "words", f"exit code {done.code}, said {(done.out + done.words)[:300]!r}"
    n_files = len(targets_of(done))
    if value_of(done.options, "--lods") and is_scene(subject, done):
        n_files = len(done.meshes)
    if (len(done.meshes) == n_files and done.report is not None) != (done.code in (0, 3)) or done.stray:
        yield "whole", f"exit code {done.code}, meshes {[path.name for path in done.meshes]}, {done.stray}"
    elif done.code == 3 and (done.report["outcome"] == "reached" or not {"--error", "--size"} & set(done.options)):
        yield "exit", f"exit code 3, outcome {done.report['outcome']}"
    elif done.code in (1, 2) and subject.faces and subject.plain and may_not_be_refused(subject, done):
        yield "refused", done.words.strip()


def may_not_be_refused(subject, done):
    """A mesh that bounds no solid may be refused, and one whose file exceeds the bytes asked for with hardly a face."""
    least = re.search(r"--size (\d+): one face for each material already takes (\d+) bytes", done.words)
    is_too_large = least is not None and int(least[2]) > int(least[1]) == int(value_of(done.options, "--size"))
    return not asks(done, "--printable") and not is_too_large


def targets_of(done):
    """The option, the size asked for and the least size that a result stands for: levels that repeat the one before are left out of
    the report, and it gets their outcome."""
    if "--lods" not in done.options:
        return [[*done.options[:2], done.options[1]]]
    notes = [note for note in (done.report or {}).get("notes", []) if note.startswith("levels left out: ")]
    left_out = [float(size.rstrip("%")) for note in notes for size in note.split(": ")[1].split(", ")]
    targets = []
    for ratio in value_of(done.options, "--lods").split(","):
        if targets and any(abs(100 * float(ratio) - size) <= 1e-9 for size in left_out):
            targets[-1][2] = ratio
        else:
            targets.append(["--ratio", ratio, ratio])
    return targets


def is_scene(subject, done):
    """Levels of detail of a scene stand in one file, where each takes its own place."""
    return subject.path.suffix == ".glb" and all(path.suffix == ".glb" for path in done.meshes)


def may_touch(subject, done, said):
    """Whether vertices may lie at one position: what is cut where parts touch has to stay where it was with these options, and
    where nothing was simplified."""
    understood = dict(vars(subject.figures), **done.report["input"])
    holds = {"--subset", "--lock-boundaries"} & set(done.options) or said["faces"] == understood["faces"]
    return bool(holds) and understood["non_manifold_edges"] + understood["non_manifold_vertices"] > 0


def results(subject, done, found):
    """Reads the results of a run, and adds a verdict for each unreadable file."""
    levels = done.report.get("levels") or [dict(done.report["output"], outcome=done.report["outcome"])]
    targets = targets_of(done)
    if len(done.meshes) != len(levels):
        return
    for number, (path, said) in enumerate(zip(done.meshes, levels)):
        target = targets[number]
        try:
            touch = may_touch(subject, done, said)
            result = Result(path, said, said["outcome"], target, not touch)
            if not all(abs(x) < float("inf") for point in result.all_points for x in point):
                raise formats.Unreadable("a coordinate that is not finite")
        except formats.Unreadable as error:
            found.append(("file", f"{path.name}: {error}"))
            continue
        # An STL has no shared vertices, so positions cannot coincide.
        if path.suffix != ".stl" or not touch:
            yield result


def of_result(subject, done, result):
    """Judges one written mesh."""
    apart = list(of_positions(result)) or list(of_faces(subject, result))
    yield from apart or of_report(result)
    # `input` in the report of a repair is the repaired mesh.
    misread = [] if is_repaired(done) else list(of_reading(subject, done))
    yield from misread
    # Consequences of these flaws are not reported again.
    if not apart and not misread and not is_repaired(done) and subject.is_understood(done):
        yield from of_surface(subject, result)
        yield from of_size(subject, done, result)
    if apart:
        return
    for option, check in (OF_REPAIRED if is_repaired(done) else CHECKS).items():
        if asks(done, option):
            yield from check(subject, done, result)
    low, high = surface.bounds(subject.points)
    reach = max(max(l - x, x - h) for point in result.points for l, x, h in zip(low, point, high))
    if reach > subject.diagonal:
        yield "astray", f"a vertex lies {reach / subject.diagonal:.2g} diagonals outside the box of the input"


def of_positions(result):
    told, distinct = result.said["vertices"], result.figures.vertices
    if told > distinct:
        yield "positions", f"{told} vertices in the report, {distinct} positions in the file"


def of_faces(subject, result):
    doubled = len(result.named) - len(result.faces)
    if doubled:
        yield "doubled", f"{doubled} of {len(result.all_faces)} faces have the vertices of another"
    faces = [face for face in result.all_faces if result.weld or len({result.all_points[v] for v in face}) == 3]
    degenerate = surface.degenerate(result.all_points, faces)
    if degenerate > subject.degenerate:
        yield "degenerate", f"{degenerate} of {len(result.all_faces)} faces without area, {subject.degenerate} in the input"


def of_surface(subject, result):
    """Judges the topology, counted after welding, as any reader does."""
    before, after = subject.figures, result.figures
    dropped = result.said["components_pruned"]
    if not after.manifold:
        yield "manifold", f"{after.non_manifold_edges} non-manifold edges and {after.non_manifold_vertices} vertices"
    opened = f"{after.boundary_edges} boundary edges"
    if after.boundary_edges and before.closed and before.edge_manifold:
        yield "closed", opened
    elif after.boundary_edges and before.odd_edges == 0:
        yield "closed even", f"{opened}, {before.non_manifold_edges} edges of the input have more than two faces"
    elif after.boundary_edges and subject.opened_by_cleaning:
        yield "closed again", f"{opened}, {before.boundary_edges} of the input without its repeated faces"
    if after.disagreeing and after.manifold and surface.orientable(result.faces):
        yield "winding", f"{after.disagreeing} edges"
    left = before.components - dropped
    # Cutting at non-manifold edges may increase the number of components.
    if after.components < left or before.edge_manifold and after.components > left:
        yield "pieces", f"{before.components} become {after.components}, {dropped} reported dropped"
    elif before.edge_manifold and after.manifold and not dropped:
        if after.loops != before.loops:
            yield "loops", f"{before.loops} become {after.loops}"
        elif after.split_euler != before.split_euler:
            yield "handles", f"Euler characteristic {before.split_euler} becomes {after.split_euler}"


def of_size(subject, done, result):
    """Judges the size; split vertices count once, and the report has their number."""
    name, asked, least_asked = result.target
    if name not in ("--ratio", "--vertices", "--faces"):
        return
    before, after = subject.figures, result.figures
    key = "faces" if name == "--faces" else "vertices"
    count = (lambda ratio: max(int(before.vertices * float(ratio) * (1 + 1e-12)), 1)) if name == "--ratio" else int
    asked, least_asked = count(asked), count(least_asked)
    size, whole = getattr(after, key), getattr(before, key)
    if asked >= whole:
        yield from of_unchanged(subject, done, result)
        return
    split = result.said["split_vertices"] + max(before.fans - before.vertices, 0)
    # Vertices or faces removed by one merge.
    step = 2 if key == "faces" else 1
    text = f"{size} {key}, {asked} asked for of {whole}, {split} split: {result.outcome}"
    # What stays of the input has at least so many to give: only handles make vertices fewer than half the faces.
    rest = before.faces - sum(component["faces"] for component in result.said.get("dropped", []))
    least = min(asked - step, rest if key == "faces" else 0.4 * rest)
    if result.outcome == "reached" and not least <= size <= asked + split * (2 if key == "faces" else 1):
        yield "size", text
    elif result.outcome != "reached" and size + split <= least_asked:
        yield "size", text


def of_unchanged(subject, done, result):
    before, after = subject.figures, result.figures
    # Pruned components are gone.
    if result.said["components_pruned"]:
        return
    if before.odd_edges == 0 and after.faces != before.faces:
        yield "unchanged", f"{before.faces} faces become {after.faces}"
    if before.manifold and after.vertices != before.vertices:
        yield "unchanged", f"{before.vertices} vertices become {after.vertices}"


def of_reading(subject, done):
    if len(subject.named) > len(subject.faces):
        return  # Of repeated faces a second one may stay.
    before, said = subject.figures, done.report["input"]
    told = {key: getattr(before, key) for key in said if said[key] != getattr(before, key)}
    # Vertices of a mesh in doubles may be one in single precision, as long as that opens nothing and loses no part.
    is_less = said["components"] < before.components or before.closed and not said["closed"]
    if told and "--weld" not in done.options and (subject.is_single or is_less):
        yield "read", ", ".join(f"{key} {said[key]} in the report, {value} in the file" for key, value in told.items())


def of_report(result):
    after, said = result.figures, result.said
    keys = ["vertices", "faces", "closed", "boundary_edges", "non_manifold_edges", "non_manifold_vertices", "components", "euler"]
    told = [key for key in keys if said.get(key, getattr(after, key)) != getattr(after, key)]
    if told:
        yield "report", ", ".join(f"{key} {said[key]} in the report, {getattr(after, key)} in the file" for key in told)
