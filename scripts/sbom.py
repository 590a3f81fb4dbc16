#!/usr/bin/env python3
"""Prints the parts of a release as CycloneDX JSON: the crates of the program, the libraries for C, Python and pages, and what is no crate.

sbom.py TARGET
"""
import json
import re
import sys

import licences

MANIFESTS = ["cli/Cargo.toml", "c/Cargo.toml", "python/Cargo.toml", "web/Cargo.toml"]


def checksums():
    """Returns the SHA-256 sums of crates in the lock file, by name and version."""
    entry = re.compile(r'name = "(.+)"\nversion = "(.+)"\nsource = ".+"\nchecksum = "(.+)"')
    return {(name, version): sum for name, version, sum in entry.findall((licences.ROOT / "Cargo.lock").read_text())}


def component(crate, sums):
    """Returns a crate as a component."""
    name, version, licence = crate["name"], crate["version"], crate["license"]
    made = {"type": "library", "bom-ref": f"{name}@{version}", "name": name, "version": version, "purl": f"pkg:cargo/{name}@{version}"}
    if licence:
        # Before SPDX had operators, crates.io wrote a slash.
        made["licenses"] = [{"expression": re.sub(r" ?/ ?", " OR ", licence)}]
    if (name, version) in sums:
        made["hashes"] = [{"alg": "SHA-256", "content": sums[name, version]}]
    return made


def main():
    target, sums, components, dependencies = sys.argv[1], checksums(), {}, []
    for manifest in MANIFESTS:
        linked = [component(crate, sums) for crate in licences.linked(target, manifest)]
        root = next(part["bom-ref"] for part in linked if part["name"] == licences.name_of(manifest))
        dependencies.append({"ref": root, "dependsOn": [part["bom-ref"] for part in linked if part["bom-ref"] != root]})
        components |= {part["bom-ref"]: part for part in linked}
    # With the static program for Linux.
    for name, licence, _ in licences.others(re.sub("-gnu$", "-musl", target), {part["name"] for part in components.values()}):
        components[name] = {"type": "library", "bom-ref": name, "name": name, "licenses": [{"expression": licence}]}
    version = components[dependencies[0]["ref"]]["version"]
    product = {"type": "application", "bom-ref": "release", "name": "neural-mesh", "version": version}
    print(json.dumps({
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json", "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": product}, "components": sorted(components.values(), key=lambda part: part["bom-ref"]),
        "dependencies": [{"ref": "release", "dependsOn": [entry["ref"] for entry in dependencies]}, *dependencies],
    }, indent=1))


main()
