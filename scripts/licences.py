#!/usr/bin/env python3
"""Prints the licences of all components of a package: crates, vendored C++, three.js, a font, Rust's library.

Fails if a crate has no licence text and its licence's name has none in another crate. The package is the program with all features, or that
of another manifest as `scripts/release` builds it.

licences.py TARGET [MANIFEST]
"""
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = "cli/Cargo.toml"
NAMED = re.compile(r"^(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)
NOT_TEXT = {".rs", ".html", ".py", ".cpp", ".h", ".json"}


def cargo(command, target, manifest, *options):
    """Returns what a command of cargo prints about a manifest for a target."""
    named = ["cargo", command, "--manifest-path", manifest, *options, *(["--all-features"] if manifest == PROGRAM else [])]
    platform = {"tree": "--target", "metadata": "--filter-platform"}[command]
    return subprocess.run([*named, platform, target], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def linked(target, manifest):
    """Lists the packages that are linked into one, by cargo's graph, as `cargo metadata` describes them."""
    tree = cargo("tree", target, manifest, "--edges", "normal", "--prefix", "none", "--format", "{p}")
    found = {tuple(line.split()[:2]) for line in tree.splitlines() if line}
    packages = json.loads(cargo("metadata", target, manifest, "--format-version", "1"))["packages"]
    named = [package for package in packages if (package["name"], f'v{package["version"]}') in found]
    return sorted(named, key=lambda package: (package["name"], package["version"]))


def name_of(manifest):
    """Returns the name of a manifest's package."""
    return re.search(r'^name = "(.+)"$', (ROOT / manifest).read_text(), re.MULTILINE)[1]


def texts(folder):
    """Lists the licence files of a folder and of its vendored code."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and NAMED.match(path.name)]
    folders = [path for path in sorted(folder.glob("LICENSES/*")) if path.is_file()]
    return [path.read_text(errors="replace").strip() for path in files + folders if path.suffix.lower() not in NOT_TEXT]


def comment_at_end(header):
    """Returns the licence in the last comment of a C++ header."""
    comment = header.read_text().rsplit("/**", 1)[1].split("*/")[0]
    return "\n".join(line.strip().removeprefix("*").strip() for line in comment.strip().splitlines())


def others(target, names):
    """Name, licence and text of each part that is no crate, of packages with these names."""
    if target.endswith("-musl") and "neural-mesh-cli" in names:
        # zig links these into a static program.
        folder = next(ROOT.glob("target/release-tools/**/ziglang/lib"))
        yield "musl", "MIT", folder / "libc/musl/COPYRIGHT"
        yield "libc++ and libunwind of LLVM", "Apache-2.0 WITH LLVM-exception", folder / "libcxx/LICENSE.TXT"
    if "neural-mesh-xatlas" in names:
        yield "xatlas (vendored, C++)", "MIT", ROOT / "xatlas/vendor/LICENSE"
    if names & {"neural-mesh-cli", "neural-mesh-web"}:
        yield "three.js (in pages)", "MIT", ROOT / "cli/viewer/dist/LICENSE-three"
    if "noto-sans-mono-bitmap" in names:
        yield "Noto Sans Mono (drawn letters of noto-sans-mono-bitmap)", "OFL-1.1", ROOT / "cli/licences/OFL-1.1.txt"


def parts(target, manifest):
    """Name, licence and texts of each part."""
    packages = linked(target, manifest)
    for crate in (package for package in packages if package["source"]):
        folder = Path(crate["manifest_path"]).parent
        found = texts(folder)
        if crate["name"] == "meshopt":
            found.append(comment_at_end(folder / "vendor/src/meshoptimizer.h"))
        yield f'{crate["name"]} {crate["version"]}', crate["license"] or "see its text", found
    for name, licence, file in others(target, {package["name"] for package in packages}):
        yield name, licence, [file.read_text().strip()]
    shared = {licence: (ROOT / f"LICENSE-{licence}").read_text().strip() for licence in ("MIT", "APACHE")}
    yield "the standard library of Rust", "MIT OR Apache-2.0", list(shared.values())


def main():
    by_text, lines, bare = {}, [], []
    for name, licence, found in parts(*(sys.argv[1:] + [PROGRAM])[:2]):
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


if __name__ == "__main__":
    main()
