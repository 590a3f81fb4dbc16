"""Reduces finds: fewer faces, shorter coordinates, fewer options, as long as a run breaks its promise.

Closed and manifold meshes stay so, as an open mesh may break the promise by another fault.
"""

import dataclasses
import tempfile
import time
from pathlib import Path
from random import Random

import cases
import formats
import surface
from subject import Subject


def smaller(executable, folder, seconds):
    """Reduces a find in its folder for a number of seconds (60), and returns the reduced case."""
    folder, end = Path(folder), time.monotonic() + min(seconds, 60)
    case = cases.loaded(folder)
    kind, path = case.verdicts[0][0], folder / case.mesh
    sound = soundness(Subject(path))

    def breaks(mesh, case):
        """Returns the case with its verdicts if the promise is still broken."""
        if time.monotonic() > end or not mesh[1]:
            return None
        with tempfile.TemporaryDirectory() as work:
            trial = Path(work) / case.mesh
            try:
                formats.write(trial, *mesh, double=True)
                subject = Subject(trial, case.plain)
            except OverflowError:
                return None
            if any(was and not still for was, still in zip(sound, soundness(subject))):
                return None
            found = cases.verdicts(executable, case, subject, kind == "threads")
        return dataclasses.replace(case, verdicts=found) if any(broken == kind for broken, _ in found) else None

    mesh = formats.read(path)
    for step in (fewer_options, fewer_faces, contracted, fewer_faces, shorter_numbers, fewer_options):
        mesh, case = step(mesh, case, breaks)
    case.verdicts.sort(key=lambda verdict: verdict[0] != kind)
    path.unlink()
    formats.write(folder / case.mesh, *mesh, double=True)
    cases.kept(case, folder / case.mesh, folder.parent.parent)
    return case


def soundness(subject):
    figures = subject.figures
    return figures.odd_edges == 0, figures.edge_manifold, figures.manifold, figures.disagreeing == 0


def fewer_options(mesh, case, breaks):
    """Removes each option after the target if possible, and writes readable OBJ."""
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
    """Removes whole components, then ever shorter runs of faces."""
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
    """Contracts edges, as many at once as possible; closed meshes stay closed."""
    rng = Random(0)
    for share in (0.3, 0.1, 0.03, 0.0):
        failed = 0
        while failed < 10:
            less = contracted_once(rng, mesh, share)
            found = breaks(less, case) if len(less[1]) < len(mesh[1]) else None
            mesh, case, failed = (less, found, 0) if found else (mesh, case, failed + 1)
    return mesh, case


def contracted_once(rng, mesh, share):
    """Contracts a share of the edges, at least one: distant edges whose ends have two common neighbours."""
    points, faces = mesh
    near = {}
    for face in faces:
        for v in face:
            near.setdefault(v, set()).update(face)
    goes, touched = {}, set()
    for _ in range(20 + int(share * len(points))):
        a, b = rng.sample(rng.choice(faces), 2)
        around = near[a] | near[b]
        if len(near[a] & near[b]) <= 4 and not around & touched and (share > 0 or not goes):
            goes[a] = b
            touched |= around
    less = [tuple(goes.get(v, v) for v in face) for face in faces]
    return used(points, [face for face in less if len(set(face)) == 3])


def shorter_numbers(mesh, case, breaks):
    for digits in (1, 2, 3, 5, 7):
        short = [tuple(float(f"{x:.{digits}g}") for x in point) for point in mesh[0]], mesh[1]
        found = breaks(short, case)
        if found:
            return short, found
    return mesh, case
