"""Makes finds smaller: fewer faces, shorter coordinates, fewer options, as long as the same promise breaks."""

import dataclasses
import tempfile
import time
from pathlib import Path
from random import Random

import cases
import formats
import surface
from judge import Subject


def smaller(executable, folder, seconds):
    """Shrinks a find in its folder for so many seconds (60), and gives it as it is then."""
    folder, end = Path(folder), time.monotonic() + min(seconds, 60)
    case = cases.loaded(folder)
    kind, path = case.verdicts[0][0], folder / case.mesh

    def breaks(mesh, case):
        """Whether the promise is still broken; the case with its verdicts then."""
        if time.monotonic() > end or not mesh[1]:
            return None
        with tempfile.TemporaryDirectory() as work:
            trial = Path(work) / case.mesh
            try:
                formats.write(trial, *mesh, double=True)
                subject = Subject(trial, case.plain, case.mirrored)
            except OverflowError:
                return None
            found = cases.verdicts(executable, case, subject, kind == "threads")
        return dataclasses.replace(case, verdicts=found) if any(broken == kind for broken, _ in found) else None

    mesh = formats.read(path)
    for step in (fewer_options, fewer_faces, contracted, fewer_faces, shorter_numbers, fewer_options):
        mesh, case = step(mesh, case, breaks)
    case.verdicts.sort(key=lambda verdict: verdict[0] != kind)
    formats.write(path, *mesh, double=True)
    cases.kept(case, path, folder.parent.parent)
    return case


def fewer_options(mesh, case, breaks):
    """Without each option and its value behind the target; as OBJ, which people read."""
    at = 2
    while at < len(case.options):
        end = at + 1
        while end < len(case.options) and not case.options[end].startswith("--"):
            end += 1
        without = breaks(mesh, dataclasses.replace(case, options=case.options[:at] + case.options[end:]))
        case, at = (without, at) if without else (case, end)
    for change in ({"mesh": "in.obj"}, {"output": "out.obj"}):
        case = breaks(mesh, dataclasses.replace(case, **change)) or case
    return mesh, case


def fewer_faces(mesh, case, breaks):
    """Without whole components, then without runs of faces, shorter and shorter."""
    points, faces = mesh
    sets = surface.Sets()
    for face in faces:
        sets.join(face[0], face[1])
        sets.join(face[0], face[2])
    for piece in {sets.find(face[0]) for face in faces}:
        rest = [face for face in faces if sets.find(face[0]) != piece]
        found = breaks((points, rest), case)
        faces, case = (rest, found) if found else (faces, case)
    length = len(faces) // 2
    while length:
        at = 0
        while at < len(faces):
            rest = faces[:at] + faces[at + length :]
            found = breaks((points, rest), case)
            faces, case, at = (rest, found, at) if found else (faces, case, at + length)
        length //= 2
    return used(points, faces), case


def used(points, faces):
    new = {old: i for i, old in enumerate(sorted({v for face in faces for v in face}))}
    return [points[old] for old in new], [tuple(new[v] for v in face) for face in faces]


def contracted(mesh, case, breaks):
    """Edges become points, several at once while that works: closed meshes stay closed."""
    rng, share = Random(0), 0.5
    while share * len(mesh[0]) >= 0.5:
        for _ in range(12):
            points, faces = mesh
            goes = {}
            for face in rng.sample(faces, min(len(faces), max(int(share * len(points)), 1))):
                a, b = rng.sample(face, 2)
                if a not in goes and b not in goes and a not in goes.values():
                    goes[a] = b
            less = [tuple(goes.get(v, v) for v in face) for face in faces]
            less = used(points, [face for face in less if len(set(face)) == 3])
            found = breaks(less, case)
            mesh, case = (less, found) if found else (mesh, case)
        share /= 2
    return mesh, case


def shorter_numbers(mesh, case, breaks):
    for digits in (1, 2, 3, 5, 7):
        short = [tuple(float(f"{x:.{digits}g}") for x in point) for point in mesh[0]], mesh[1]
        found = breaks(short, case)
        if found:
            return short, found
    return mesh, case
