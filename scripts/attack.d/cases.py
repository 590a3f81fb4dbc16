"""Cases: a mesh file and one run of the program on it, drawn from a seed or read from the folder of a find."""

import json
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import draw
import formats
import program
from judge import judged
from subject import Subject


@dataclass
class Case:
    name: str
    recipe: str
    mesh: str
    """Name of the mesh file."""
    output: str
    """Name of the requested output file."""
    options: list
    plain: bool
    verdicts: list = field(default_factory=list)

    def command(self):
        return " ".join(["neural-mesh simplify", self.mesh, "-o", self.output, *self.options])


def of_seed(executable, seed, finds, keep=False):
    """Runs and judges the four cases of a seed; those that break a promise are saved as finds."""
    drawn = draw.drawn(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = put(Path(folder), drawn, seed)
        subject, cases = Subject(path, drawn.plain), []
        for number, (ending, options) in enumerate(draw.runs(seed, drawn, path.suffix)):
            recipe = ", ".join(drawn.recipe)
            case = Case(f"{seed}-{number}", recipe, path.name, "out" + ending, options, drawn.plain)
            case.verdicts = verdicts(executable, case, subject, twice=number == seed % 4)
            cases.append(case)
            if case.verdicts or keep:
                kept(case, path, finds)
        return cases


def put(folder, drawn, seed):
    """Writes the mesh to a file, as text if single precision overflows."""
    ending = draw.Random(f"ending {seed}").choice(draw.ENDINGS)
    try:
        path = folder / ("in" + ending)
        formats.write(path, drawn.points, drawn.faces, drawn.double)
    except OverflowError:
        path = folder / "in.obj"
        formats.write(path, drawn.points, drawn.faces)
    return path


def verdicts(executable, case, subject, twice=False):
    """Runs a case, and with `twice` again on another number of threads; returns the verdicts."""
    with tempfile.TemporaryDirectory() as folder:
        done = ran(executable, case, subject, folder)
        found = judged(subject, done)
        if not twice or done.stopped:
            return found
        at = case.options.index("--threads") + 1
        other = "4" if case.options[at] == "1" else "1"
        with tempfile.TemporaryDirectory() as folder:
            options = [*case.options[:at], other, *case.options[at + 1 :]]
            second = ran(executable, case, subject, folder, options)
            bytes_of = lambda run: [path.read_bytes() for path in run.meshes]
            if not second.stopped and (done.code, bytes_of(done)) != (second.code, bytes_of(second)):
                said = f"exit code {second.code} after {done.code}, {second.words.strip()}"
                found.append(("threads", f"the result on {other} threads differs: {said}"))
    return found


def ran(executable, case, subject, folder, options=None):
    return program.run(executable, subject.path, Path(folder) / case.output, options or case.options)


def kept(case, path, finds):
    """Saves a case to its own folder."""
    kind = case.verdicts[0][0].replace(" ", "-") if case.verdicts else "sound"
    folder = Path(finds) / kind / case.name
    folder.mkdir(parents=True, exist_ok=True)
    if path.parent != folder:
        shutil.copy(path, folder / path.name)
    lines = [case.command(), *(f"{kind}: {words}" for kind, words in case.verdicts)]
    (folder / "what.txt").write_text("\n".join([f"{case.recipe}", *lines, ""]))
    (folder / "case.json").write_text(json.dumps(vars(case), indent=1))
    return folder


def loaded(folder):
    return Case(**json.loads((Path(folder) / "case.json").read_text()))


def again(executable, folder):
    """Repeats a find and judges it again."""
    case = loaded(folder)
    subject = Subject(Path(folder) / case.mesh, case.plain)
    case.verdicts = verdicts(executable, case, subject, twice="--threads" in case.options)
    return case
