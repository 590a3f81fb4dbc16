"""What the program promises, held against the files that it wrote.

Each verdict is a pair: the kind of the promise that is broken, one of PROMISES, and what was found.
"""

from functools import cached_property
from math import dist

import formats
import surface
from distance import largest
from program import SECONDS

PROMISES = {
    "crash": "CONTRIBUTING, help: a run ends with exit code 0, 1, 2 or 3; no panic, no signal",
    "hang": f"no run on a mesh of this size takes {SECONDS} s",
    "words": "help, `--quiet`: a failure is one line, `neural-mesh: ...`, without control characters; a success says nothing",
    "whole": "README: a file appears whole or not at all: all of them with exit code 0 or 3, none otherwise",
    "exit": "help: exit code 3 is for a bound that was not held, and its outcome says why",
    "refused": "README: files are read as far as they can be understood: a mesh that single precision holds is not refused",
    "file": "formats.md: the file is one of its format, its coordinates finite",
    "threads": "README: the same bytes on any number of threads",
    "read": "cleanup.rs: `input` of the report is the mesh of the file: equal positions are one vertex; nothing is lost",
    "positions": "closed.md, 5: no two vertices are written at one position",
    "doubled": "closed.md: no two faces of a result have the same three vertices",
    "degenerate": "a result has no more faces without area than the input, in the numbers of the file",
    "closed": "README: where the input is closed and manifold, so is the result",
    "closed even": "an input whose edges have two, four, ... faces comes back closed",
    "closed again": "an input that is closed until repeated faces go comes back closed",
    "manifold": "closed.md, 1: the result is a manifold with or without boundary, also after equal positions are welded",
    "winding": "closed.md, prepare: the surface is oriented: the winding of a two-sided result agrees",
    "pieces": "README: the same components, less those reported dropped",
    "handles": "README: the same handles",
    "loops": "closed.md, 3: the same boundary loops",
    "size": "README, closed.md: `reached` means the size asked for, and more vertices or faces mean that it was not",
    "unchanged": "cli: what is as small as asked is written as it is",
    "report": "what the report says of the result holds of the file",
    "subset": "assets.md: with --subset vertices of the result are vertices of the input",
    "locked": "assets.md: with --lock-boundaries vertices and edges of the boundary stay, bit for bit",
    "mirrored": "assets.md: with --symmetric each vertex and face of the result has its image",
    "pruned": "assets.md: --prune=SIZE drops the components smaller than that, and the largest by area stays",
    "error": "assets.md: with --error nothing is farther than asked, or exit code 3 says so",
    "certified": "assets.md: the certified distance is no less than the true one",
    "bytes": "assets.md: with --size the file fits, or exit code 3 says so",
    "astray": "README: the surface stays close: no vertex lies farther outside the box of the input than its diagonal",
}

# Boundary edges that the removal of repeated faces may open, and their share of the faces, for the holes to be closed again.
SMALL_HOLES, FEW = 6, 0.05
# Share of the diagonal up to which a mirrored input may differ from its image.
ALIKE = 0.0002


class Subject:
    """The input, as the judge understands its file."""

    def __init__(self, path, plain=True, mirrored=False):
        self.path, self.plain, self.mirrored = path, plain, mirrored
        self.points, self.faces, self.named = surface.cleaned(*formats.read(path))

    @cached_property
    def figures(self):
        return surface.figures(self.points, self.faces)

    @cached_property
    def degenerate(self):
        return surface.degenerate(self.points, self.faces)

    @cached_property
    def two_sided(self):
        return surface.orientable(self.faces)

    @cached_property
    def diagonal(self):
        return surface.diagonal(self.points)

    @cached_property
    def is_single(self):
        return all(formats.single(x) == x for point in self.points for x in point)

    def is_understood(self, done):
        """Whether the program has seen the same mesh: it may weld what single precision cannot tell apart."""
        said = done.report["input"]
        return "--weld" not in done.options and all(said[key] == getattr(self.figures, key) for key in said)

    @cached_property
    def boundary(self):
        """Boundary edges as pairs of points."""
        edges = surface.edges_of(self.faces)
        return {frozenset(self.points[v] for v in edge) for edge, around in edges.items() if len(around) == 1}

    @cached_property
    def opened_by_cleaning(self):
        """Whether it is closed, with small holes where repeated faces went."""
        are_few = 0 < len(self.named) - len(self.faces) <= max(FEW * len(self.faces), 1)
        return are_few and self.figures.boundary_edges <= SMALL_HOLES and surface.odd_edges(self.named) == 0


class Result:
    """A mesh file that was written, and what the report says of it."""

    def __init__(self, path, said, outcome, target, weld):
        self.path, self.said, self.outcome, self.target = path, said, outcome, target
        self.all_points, self.all_faces = formats.read(path)
        self.points, self.faces, self.named = surface.cleaned(self.all_points, self.all_faces, weld)
        self.figures = surface.figures(self.points, self.faces)


def value_of(options, name):
    return options[options.index(name) + 1] if name in options else None


def judged(subject, done):
    """All verdicts on a run."""
    found = list(of_run(subject, done))
    if found or done.stopped or done.code not in (0, 3):
        return found
    return [verdict for result in results(subject, done, found) for verdict in of_result(subject, done, result)] + found


def of_run(subject, done):
    """Whether the run ended as it should, whatever it wrote."""
    if done.seconds > SECONDS:
        yield "hang", f"{done.seconds:.0f} s of the processor"
    if done.stopped:
        return
    if done.code not in (0, 1, 2, 3) or "panicked" in done.words:
        yield "crash", f"exit code {done.code}: {done.words.strip()[:300]}"
        return
    lines = done.words.splitlines()
    is_line = len(lines) == 1 and lines[0].startswith("neural-mesh: ") and lines[0].isprintable()
    if done.out or (not is_line if done.code in (1, 2) else lines):
        yield "words", f"exit code {done.code}, said {(done.out + done.words)[:300]!r}"
    n_files = len(value_of(done.options, "--lods").split(",")) if "--lods" in done.options else 1
    if value_of(done.options, "--lods") and is_scene(subject, done):
        n_files = len(done.meshes)
    if (len(done.meshes) == n_files and done.report is not None) != (done.code in (0, 3)) or done.stray:
        yield "whole", f"exit code {done.code}, meshes {[path.name for path in done.meshes]}, {done.stray}"
    elif done.code == 3 and (done.report["outcome"] == "reached" or not {"--error", "--size"} & set(done.options)):
        yield "exit", f"exit code 3, outcome {done.report['outcome']}"
    elif done.code in (1, 2) and subject.faces and subject.plain and (subject.mirrored or not is_mirrored(done)):
        yield "refused", done.words.strip()


def is_mirrored(done):
    return any(word.startswith("--symmetric") for word in done.options)


def is_scene(subject, done):
    """Levels of detail of a scene stand in one file, where each takes its own place."""
    return subject.path.suffix == ".glb" and all(path.suffix == ".glb" for path in done.meshes)


def may_touch(subject, done):
    """Whether vertices may lie at one position: what is cut where parts touch has to stay where it was with these options."""
    return bool({"--subset", "--lock-boundaries"} & set(done.options)) and not subject.figures.manifold


def results(subject, done, found):
    """The results of a run; files that cannot be read are found."""
    levels = done.report.get("levels") or [dict(done.report["output"], outcome=done.report["outcome"])]
    targets = [["--ratio", ratio] for ratio in (value_of(done.options, "--lods") or "").split(",")]
    if len(done.meshes) != len(levels):
        return
    for number, (path, said) in enumerate(zip(done.meshes, levels)):
        target = targets[number] if "--lods" in done.options else done.options[:2]
        try:
            result = Result(path, said, said["outcome"], target, not may_touch(subject, done))
            if not all(abs(x) < float("inf") for point in result.all_points for x in point):
                raise formats.Unreadable("a coordinate that is not finite")
        except formats.Unreadable as error:
            found.append(("file", f"{path.name}: {error}"))
            continue
        # An STL has no vertices that could lie at one position.
        if path.suffix != ".stl" or not may_touch(subject, done):
            yield result


def of_result(subject, done, result):
    """Everything about one mesh that was written."""
    apart = list(of_positions(result)) or list(of_faces(subject, result))
    yield from apart or of_report(result)
    misread = list(of_reading(subject, done))
    yield from misread
    # What follows from these is not told again.
    if not apart and not misread and subject.is_understood(done):
        yield from of_surface(subject, result)
        yield from of_size(subject, done, result)
    if apart:
        return
    for option, check in CHECKS.items():
        if any(word.split("=")[0] == option for word in done.options):
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
    degenerate = surface.degenerate(result.all_points, result.all_faces)
    if degenerate > subject.degenerate:
        yield "degenerate", f"{degenerate} of {len(result.all_faces)} faces without area, {subject.degenerate} in the input"


def of_surface(subject, result):
    """Topology; counted after welding, as any reader does."""
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
    # What is cut apart at a non-manifold edge may be more pieces than before.
    if after.components < left or before.edge_manifold and after.components > left:
        yield "pieces", f"{before.components} become {after.components}, {dropped} reported dropped"
    elif before.edge_manifold and after.manifold and not dropped:
        if after.loops != before.loops:
            yield "loops", f"{before.loops} become {after.loops}"
        elif after.split_euler != before.split_euler:
            yield "handles", f"Euler characteristic {before.split_euler} becomes {after.split_euler}"


def of_size(subject, done, result):
    """Sizes count a vertex once that had to be split; how many were is in the report."""
    name, asked = result.target
    if name not in ("--ratio", "--vertices", "--faces"):
        return
    before, after = subject.figures, result.figures
    key = "faces" if name == "--faces" else "vertices"
    asked = max(int(before.vertices * float(asked)), 1) if name == "--ratio" else int(asked)
    size, whole = getattr(after, key), getattr(before, key)
    if asked >= whole:
        yield from of_unchanged(subject, done, result)
        return
    split = result.said["split_vertices"] + max(before.fans - before.vertices, 0)
    step = 2 if key == "faces" or is_mirrored(done) else 1
    text = f"{size} {key}, {asked} asked for of {whole}, {split} split: {result.outcome}"
    least = 0 if result.said["components_pruned"] else asked - step
    if result.outcome == "reached" and not least <= size <= asked + split * (2 if key == "faces" else 1):
        yield "size", text
    elif result.outcome != "reached" and size + split <= asked:
        yield "size", text


def of_unchanged(subject, done, result):
    before, after = subject.figures, result.figures
    # Edges across the plane of a mirrored result are split.
    if is_mirrored(done):
        return
    if before.odd_edges == 0 and after.faces != before.faces:
        yield "unchanged", f"{before.faces} faces become {after.faces}"
    if before.manifold and after.vertices != before.vertices:
        yield "unchanged", f"{before.vertices} vertices become {after.vertices}"


def of_reading(subject, done):
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


def comparable(subject, result):
    """How positions of both files compare: as single precision where either is in that, which text may write in fewer digits."""
    singly = subject.is_single or result.path.suffix == ".stl"
    return lambda point: tuple((formats.single(x) if singly else x) + 0.0 for x in point)


def keeps_positions(subject, done, result):
    """Whether positions that stay can be told: welding moves them, a glTF holds doubles about an origin of its own."""
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


def of_mirrored(subject, done, result):
    """Images are exact where single precision holds the file, whose text may have fewer digits."""
    if not subject.plain:
        return
    in_singles = [tuple(map(formats.single, point)) for point in result.points]
    plane = done.report["mirror"]
    unlike = boundary_without_image(subject, plane)
    if unlike:
        yield "mirrored", f"{unlike} of {len(subject.boundary)} boundary edges of the input have no image, which is no error"
    lost = min(without_image(points, result.faces, plane) for points in (result.points, in_singles))
    if lost[0] or lost[1] and result.figures.disagreeing == 0:
        yield "mirrored", f"{lost[0]} vertices and {lost[1]} faces have no image about {plane}"


def image_about(plane):
    """What maps a point to its image about a plane such as `x = 0`."""
    axis, at = plane.split(" = ")
    axis, at = "xyz".index(axis), float(at)
    return lambda point: tuple((2 * at - x if k == axis else x) + 0.0 for k, x in enumerate(point))


def boundary_without_image(subject, plane):
    """Edges whose middle has no image on another boundary edge, within a share of the diagonal."""
    middles = [tuple(sum(axis) / 2 for axis in zip(*edge)) for edge in subject.boundary if len(edge) == 2]
    images = list(map(image_about(plane), middles))
    near = ALIKE * subject.diagonal
    return sum(all(dist(image, middle) > near for middle in middles) for image in images)


def without_image(points, faces, plane):
    """How many vertices have no image about a plane; if all have one, how many faces have none with opposite winding."""
    image = image_about(plane)
    number = {tuple(x + 0.0 for x in point): i for i, point in enumerate(points)}
    images = [number.get(image(point)) for point in points]
    if None in images:
        return images.count(None), 0
    first = lambda face: face[(i := face.index(min(face))) :] + face[:i]
    there = {first(face) for face in faces}
    return 0, sum(first(tuple(images[v] for v in face[::-1])) not in there for face in faces)


def of_pruned(subject, done, result):
    size = next(word for word in done.options if word.startswith("--prune")).partition("=")[2]
    if not size or not subject.figures.edge_manifold:
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
    if result.said["components_pruned"] != small:
        yield "pruned", f"{result.said['components_pruned']} of {len(sizes)} components, {small} are smaller than {size}"


def of_error(subject, done, result):
    asked = value_of(done.options, "--error")
    if not asked or "--weld" in done.options or len(subject.faces) > 3000:
        return
    asked = float(asked.rstrip("%")) / 100 * subject.diagonal
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


CHECKS = {
    "--subset": of_subset,
    "--lock-boundaries": of_locked,
    "--symmetric": of_mirrored,
    "--prune": of_pruned,
    "--error": of_error,
    "--size": of_bytes,
}
