"""Runs the program and gltfpack on a scene, and measures each result into a row."""

import json
import resource
import signal
import subprocess
from dataclasses import asdict, dataclass

import gltf
import surface

# CPU seconds of a run, after which it is ended; beside other work, seconds of the clock would say nothing.
SECONDS = 120
# CPU time is the least of this many runs where one takes less than a second.
REPEATS = 3
COLUMNS = (
    "scene run exit outcome faces vertices mean max angle reported_mean reported_max reported_upper cpu cpu_no_check vanished "
    "reported_faces reported_vertices reported_input_faces reported_input_vertices reported_components diagonal "
    "reported_diagonal psnr note"
).split()


@dataclass
class Run:
    """A result to make of each scene, by the program unless it names options of gltfpack."""

    name: str
    parts: set  # of --part that need it
    options: tuple = ()
    faces_of: str = ""  # the run whose number of faces is asked for
    gltfpack: tuple | None = None


RUNS = [
    Run("input", {"error", "distance", "faces", "gltfpack"}),
    Run("error 1%", {"error"}, ("--error", "1%")),
    Run("error 5%", {"error"}, ("--error", "5%")),
    Run("ratio 0.5", {"distance"}, ("--ratio", "0.5")),
    Run("ratio 0.1", {"distance", "faces"}, ("--ratio", "0.1")),
    Run("faces of ratio 0.1", {"faces"}, faces_of="ratio 0.1"),
    Run("gltfpack", {"gltfpack"}, gltfpack=("-noq", "-kn", "-km", "-si", "0.1")),
    Run("gltfpack -sa", {"gltfpack"}, gltfpack=("-noq", "-kn", "-km", "-si", "0.1", "-sa")),
    Run("as gltfpack", {"gltfpack"}, faces_of="gltfpack"),
    Run("as gltfpack -sa", {"gltfpack"}, faces_of="gltfpack -sa"),
]


def count(asset):
    """Returns the columns of an asset's size, each mesh counted once."""
    return {"faces": int(asset.count_faces().sum()), "vertices": asset.count_vertices()}


def count_comparable_faces(original, result):
    """Returns the faces of gltfpack's result as the program counts them: gltfpack writes equal meshes once, the program each."""
    before, after = int(original.count_faces().sum()), int(result.count_faces().sum())
    if len(original.entries("meshes")) == len(result.entries("meshes")):
        return after
    return round(result.count_placed_faces() * before / original.count_placed_faces())


class Original:
    """A scene as it is, and what results of it are measured against."""

    def __init__(self, name, path, folder, n_samples):
        self.name, self.path, self.folder, self.n_samples = name, path, folder, n_samples
        self.asset = gltf.Asset(path)
        placed = self.asset.place_scene()
        self.centre, self.diagonal = surface.find_frame(placed)
        if self.diagonal == 0:
            raise gltf.Unsupported("all in one point")
        self.surface = surface.Surface(placed, self.centre, self.diagonal)
        folder.mkdir(parents=True, exist_ok=True)

    def result_path(self, run_name):
        return self.folder / f"{run_name}.glb"

    def measure_result(self, path):
        """Returns the columns of a result that come from its file alone."""
        try:
            asset = gltf.Asset(path)
            result = surface.Surface(asset.place_scene(), self.centre, self.diagonal)
        except gltf.Unsupported as problem:
            return {"note": f"result: {problem}"}
        return count(asset) | asdict(surface.compare(self.surface, result, self.n_samples))

    def find_vanished(self, path):
        """Returns the names of meshes that have no triangles left; the program keeps the order of those that remain."""
        result = gltf.Asset(path)
        left = list(zip(result.read_mesh_names(), result.count_faces(), strict=True))
        vanished = []
        for name, n_faces in zip(self.asset.read_mesh_names(), self.asset.count_faces(), strict=True):
            n_left = left.pop(0)[1] if left and left[0][0] == name else 0
            if n_faces and not n_left:
                vanished.append(name)
        return "; ".join(vanished)


def run_command(command):
    """Runs a command; returns its exit status, below 0 where a signal ended it, its CPU seconds and its last words."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    limits = (SECONDS, SECONDS + 1)
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        errors="replace",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, limits),
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if done.returncode < 0:
        return done.returncode, seconds, f"{signal.Signals(-done.returncode).name} after {seconds:.0f} s"
    return done.returncode, seconds, " ".join(done.stderr.strip().splitlines()[-1:])


def find_least_cpu(command, first):
    """Returns the least CPU seconds of several runs, the first of which is done."""
    n_more = REPEATS - 1 if first < 1 else 0
    return min([first] + [run_command(command)[1] for _ in range(n_more)])


def run_program(original, run, options, program):
    """Returns the row of a result of the program."""
    out, report_path = original.result_path(run.name), original.folder / f"{run.name}.json"
    base = [program, "simplify", original.path, "-o", out, *options, "--threads", "1", "--quiet", "--force"]
    command = [*base, "--report", report_path]
    out.unlink(missing_ok=True)
    status, cpu, words = run_command(command)
    row = {"exit": status, "cpu": cpu, "note": words}
    if not out.is_file():
        return row
    report = json.loads(report_path.read_text())
    row |= read_report(report) | original.measure_result(out) | {"vanished": original.find_vanished(out)}
    if "gltfpack" in run.parts:
        row["cpu"] = find_least_cpu(command, cpu)
        quick = [*base, "--no-check"]
        row["cpu_no_check"] = find_least_cpu(quick, run_command(quick)[1])
    return row


def read_report(report):
    """Returns the columns that are figures of the program's own report."""
    distance, certified = report.get("distance") or {}, report.get("certified") or {}
    # The diagonal in the unit of the scene is what makes the absolute bound a share.
    shares = certified.get("upper_percent")
    return {
        "outcome": report["outcome"],
        "reported_mean": distance.get("mean_percent"),
        "reported_max": distance.get("max_percent"),
        "reported_upper": shares,
        "reported_diagonal": 100 * certified["upper"] / shares if shares else None,
        "reported_faces": report["output"]["faces"],
        "reported_vertices": report["output"]["vertices"],
        "reported_input_faces": report["input"]["faces"],
        "reported_input_vertices": report["input"]["vertices"],
        "reported_components": f"{report['input']['components']} to {report['output']['components']}",
    }


def run_gltfpack(original, run, gltfpack, clock):
    """Returns the row of a result of gltfpack; `clock` is the build whose CPU time counts."""
    out = original.result_path(run.name)
    out.unlink(missing_ok=True)
    status, _, words = run_command([gltfpack, "-i", original.path, "-o", out, *run.gltfpack])
    row = {"exit": status, "note": words}
    if status != 0 or not out.is_file():
        return row
    timed = [clock, "-i", original.path, "-o", original.folder / "clock.glb", *run.gltfpack]
    faces = count_comparable_faces(original.asset, gltf.Asset(out))
    return row | original.measure_result(out) | {"faces": faces, "cpu": find_least_cpu(timed, run_command(timed)[1])}


def make_row(original, run, rows, arguments):
    """Makes and measures one result; `rows` are those of this scene so far, by run. None where it cannot be asked for."""
    if run.name == "input":
        return count(original.asset) | {"diagonal": original.diagonal}
    if run.gltfpack is not None:
        return run_gltfpack(original, run, arguments.gltfpack, arguments.gltfpack_clock or arguments.gltfpack)
    if run.faces_of:
        faces = rows.get(run.faces_of, {}).get("faces")
        return run_program(original, run, ("--faces", str(faces)), arguments.program) if faces else None
    return run_program(original, run, run.options, arguments.program)
