#!/usr/bin/env python3
"""Prints the licences of all components of the program with all features: crates, vendored C++, three.js, a font, Rust's library.

Fails if a crate has no licence text and its licence's name has none in another crate.

licences.py TARGET
"""
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NAMED = re.compile(r"^(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)
NOT_TEXT = {".rs", ".html", ".py", ".cpp", ".h", ".json"}


def crates(target):
    """Lists the packages that are linked into the program, by cargo's graph, without those of this workspace."""
    command = ["cargo", "metadata", "--format-version", "1", "--all-features", "--filter-platform", target]
    graph = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    packages = {package["id"]: package for package in graph["packages"]}
    nodes = {node["id"]: node for node in graph["resolve"]["nodes"]}
    todo = [package["id"] for package in packages.values() if package["name"] == "neural-mesh-cli"]
    found = set()
    while todo:
        package = todo.pop()
        if package in found:
            continue
        found.add(package)
        linked = lambda edge: any(kind["kind"] is None for kind in edge["dep_kinds"])
        todo.extend(edge["pkg"] for edge in nodes[package]["deps"] if linked(edge))
    own = set(graph["workspace_members"])
    return sorted((packages[package] for package in found - own), key=lambda package: (package["name"], package["version"]))


def texts(folder):
    """Lists the licence files of a folder and of its vendored code."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and NAMED.match(path.name)]
    folders = [path for path in sorted(folder.glob("LICENSES/*")) if path.is_file()]
    return [path.read_text(errors="replace").strip() for path in files + folders if path.suffix.lower() not in NOT_TEXT]


def comment_at_end(header):
    """Returns the licence in the last comment of a C++ header."""
    comment = header.read_text().rsplit("/**", 1)[1].split("*/")[0]
    return "\n".join(line.strip().removeprefix("*").strip() for line in comment.strip().splitlines())


def parts(target):
    """Name, licence and texts of each part."""
    for crate in crates(target):
        folder = Path(crate["manifest_path"]).parent
        found = texts(folder)
        if crate["name"] == "meshopt":
            found.append(comment_at_end(folder / "vendor/src/meshoptimizer.h"))
        yield f'{crate["name"]} {crate["version"]}', crate["license"] or "see its text", found
    yield "xatlas (vendored, C++)", "MIT", [(ROOT / "xatlas/vendor/LICENSE").read_text().strip()]
    yield "three.js (in the page of compare)", "MIT", [(ROOT / "cli/viewer/dist/LICENSE-three").read_text().strip()]
    yield "Noto Sans Mono (drawn letters of noto-sans-mono-bitmap)", "OFL-1.1", [(ROOT / "cli/licences/OFL-1.1.txt").read_text().strip()]
    shared = {licence: (ROOT / f"LICENSE-{licence}").read_text().strip() for licence in ("MIT", "APACHE")}
    yield "the standard library of Rust", "MIT OR Apache-2.0", list(shared.values())


def main():
    by_text, lines, bare = {}, [], []
    for name, licence, found in parts(sys.argv[1]):
        lines.append(f"{name}: {licence}")
        if not found:
            bare.append((name, licence))
        for text in dict.fromkeys(found):
            by_text.setdefault(text, []).append(name)
    # A package without a licence text names the standard text that applies.
    standard = {"MIT": ROOT / "LICENSE-MIT", "Apache-2.0": ROOT / "LICENSE-APACHE"}
    for name, licence in bare:
        named = [known for known in standard if known in re.split(r"[ ()/]+", licence)]
        if not named:
            sys.exit(f"{name}: no licence text, and {licence} is none that is known: add its text")
        by_text.setdefault(standard[named[0]].read_text().strip(), []).append(f"{name} (its package has no text)")
    print("What neural-mesh is made of beside its own code, and under which licences.\n\n" + "\n".join(lines))
    for text, names in by_text.items():
        print("\n" + "=" * 100 + "\n" + ", ".join(names) + "\n" + "=" * 100 + "\n\n" + text)


main()
