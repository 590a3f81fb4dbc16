"""Runs the cases of meshoptimizer's `demo/tests.cpp` that call `meshopt_simplify*` through the functions of `neural_mesh.h`.

    python3 c/tests/meshoptimizer.py TESTS_CPP PREFIX

TESTS_CPP is that file, which is not a part of this project; PREFIX is where `scripts/c --install` put the library. Triangles are compared in any
order. Prints each case with the lines that do not hold; fails where these are others than those of `EXPECTED`."""

import re
import subprocess
import sys
from pathlib import Path

# Calls of each case that tests.cpp makes with arguments; the others have none.
ARGUMENTS = {"simplifyAttr": ("false", "true"), "simplifyUpdateLocked": ("0", "meshopt_SimplifySparse")}
# Cases of functions that neural_mesh.h does not have, and of meshoptimizer's internals.
OTHER_FUNCTIONS = ("simplifyDebug",)
# Conditions of each case that do not hold, and the reason.
EXPECTED = {
    "simplifySloppyLocks": (
        ["error == 0.f", "memcmp(ib, expected, sizeof(expected)) == 0"],
        "another vertex of the cell is kept; the error is the longest way of a vertex, also within a plane",
    ),
    "simplifyDegenerate": (
        ["meshopt_simplify(ib, ib, 18, vb, 6, 12, 3, 1e-3f) == 6", "memcmp(ib, expected, sizeof(expected)) == 0"],
        "triangles with equal corners do not stop: the 3 indices that are requested cover the same area",
    ),
    "simplifySeamFake": (
        ["meshopt_simplify(ib, ib, 6, vb, 4, 16, 0, 1.f, 0, NULL) == 6"],
        "triangles with corners in one place vanish: 0 indices are requested",
    ),
    "simplifyAttr": (
        [
            "meshopt_simplifyWithAttributes(ib[0], ib[0], 7 * 2 * 6, vb[0], 8 * 3, 6 * sizeof(float), vb[0] + 3, 6 * sizeof(float), "
            "attr_weights, 3, NULL, 6 * 3, 1e-2f) == 18",
            "memcmp(ib, expected, sizeof(expected)) == 0",
        ],
        "more triangles: estimates of merges add up",
    ),
    "simplifySeam": (
        ["memcmp(res, expected, sizeof(expected)) == 0"] * 2,
        "as many triangles over other vertices of the seam",
    ),
    "simplifySeamAttr": (["fabsf(error - 0.35f) < 0.01f"], "another estimate of the error"),
    "simplifyErrorAbsolute": (["fabsf(error - 0.85f) < 0.01f"], "another estimate of the error"),
    "simplifyUpdate": (
        [f"fabsf(vb[3][{axis}] - {value}) < 1e-2f" for axis, value in enumerate(("0.88f", "0.19f"))],
        "its position of the vertex that moves is expected",
    ),
}

PRELUDE = r"""
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>
#include "neural_mesh.h"

enum {
    meshopt_SimplifyLockBorder = NM_LOCK_BORDER,
    meshopt_SimplifySparse = NM_SPARSE,
    meshopt_SimplifyErrorAbsolute = NM_ERROR_ABSOLUTE,
    meshopt_SimplifyPrune = NM_PRUNE,
};

static bool holds;

static size_t meshopt_simplify(unsigned *out, const unsigned *in, size_t n, const float *positions, size_t vertices, size_t stride,
                               size_t target, float error, unsigned options = 0, float *result = nullptr) {
    return nm_simplify(out, in, n, positions, vertices, stride, target, error, options, result);
}

static size_t meshopt_simplifyWithAttributes(unsigned *out, const unsigned *in, size_t n, const float *positions, size_t vertices,
                                             size_t stride, const float *attributes, size_t attribute_stride, const float *weights,
                                             size_t count, const unsigned char *locks, size_t target, float error,
                                             unsigned options = 0, float *result = nullptr) {
    return nm_simplify_with_attributes(out, in, n, positions, vertices, stride, attributes, attribute_stride, weights, count, locks,
                                       target, error, options, result);
}

static size_t meshopt_simplifyWithUpdate(unsigned *in, size_t n, float *positions, size_t vertices, size_t stride, float *attributes,
                                         size_t attribute_stride, const float *weights, size_t count, const unsigned char *locks,
                                         size_t target, float error, unsigned options = 0, float *result = nullptr) {
    return nm_simplify_with_update(in, n, positions, vertices, stride, attributes, attribute_stride, weights, count, locks, target,
                                   error, options, result);
}

static size_t meshopt_simplifySloppy(unsigned *out, const unsigned *in, size_t n, const float *positions, size_t vertices, size_t stride,
                                     const unsigned char *locks, size_t target, float error, float *result = nullptr) {
    return nm_simplify_sloppy(out, in, n, positions, vertices, stride, locks, target, error, result);
}

static size_t meshopt_simplifySloppy(unsigned *out, const unsigned *in, size_t n, const float *positions, size_t vertices, size_t stride,
                                     size_t target, float error, float *result = nullptr) {
    return nm_simplify_sloppy(out, in, n, positions, vertices, stride, nullptr, target, error, result);
}

static size_t meshopt_simplifyPrune(unsigned *out, const unsigned *in, size_t n, const float *positions, size_t vertices, size_t stride,
                                    float error) {
    return nm_simplify_prune(out, in, n, positions, vertices, stride, error);
}

static size_t meshopt_simplifyPoints(unsigned *out, const float *positions, size_t vertices, size_t stride, const float *colors,
                                     size_t color_stride, float weight, size_t target) {
    return nm_simplify_points(out, positions, vertices, stride, colors, color_stride, weight, target);
}

static float meshopt_simplifyScale(const float *positions, size_t vertices, size_t stride) {
    return nm_simplify_scale(positions, vertices, stride);
}

// Compares triangles in any order, each from any of its corners.
static int compare_triangles(const void *first, const void *second, size_t bytes) {
    const auto sorted = [bytes](const void *from) {
        const auto *indices = static_cast<const unsigned *>(from);
        std::vector<std::array<unsigned, 3>> triangles;
        for (size_t i = 0; i + 2 < bytes / sizeof(unsigned); i += 3) {
            std::array<unsigned, 3> corners = {indices[i], indices[i + 1], indices[i + 2]};
            std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
            triangles.push_back(corners);
        }
        std::sort(triangles.begin(), triangles.end());
        return triangles;
    };
    return sorted(first) != sorted(second);
}

#define memcmp compare_triangles
#define assert(condition) \
    do { \
        if (!(condition)) std::printf("  line %d: %s\n", __LINE__, #condition), holds = false; \
    } while (0)
"""

MAIN = """
template <class Case> static bool run(const char *name, Case call) {
    holds = true;
    call();
    std::printf("%s %s\\n", holds ? "pass" : "FAIL", name);
    std::fflush(stdout);
    return holds;
}
"""


def find_cases(source):
    """Returns the name, parameters, first line and text of each case."""
    pattern = re.compile(r"^static void (simplify\w*)\((.*?)\)\n\{\n.*?^\}\n", re.M | re.S)
    cases = [(found[1], found[2], source[: found.start()].count("\n") + 1, found[0]) for found in pattern.finditer(source)]
    return [case for case in cases if case[0] not in OTHER_FUNCTIONS]


def write_program(source):
    """Returns the program that runs all cases."""
    parts, calls = [PRELUDE], []
    for name, _, line, text in find_cases(source):
        parts.append(f'#line {line} "tests.cpp"\n{text}')
        calls += [f"{name}({argument})" for argument in ARGUMENTS.get(name, ("",))]
    runs = "\n".join(f'    run("{call}", [] {{ {call}; }});' for call in calls)
    return "\n".join([*parts, MAIN, f"int main() {{\n{runs}\n}}\n"])


def main():
    source, prefix = Path(sys.argv[1]).read_text(), Path(sys.argv[2]).resolve()
    program = prefix / "meshoptimizer_cases"
    library = ["-L", str(prefix / "lib"), "-lneural_mesh_c", f"-Wl,-rpath,{prefix / 'lib'}"]
    command = ["c++", "-std=c++17", "-x", "c++", "-", "-o", str(program), "-I", str(prefix / "include"), *library]
    subprocess.run(command, input=write_program(source), text=True, check=True)
    said = subprocess.run([str(program)], text=True, check=True, capture_output=True).stdout
    print(said, end="")
    passed, failed, broken = [], {}, []
    for line in said.splitlines():
        if line.startswith("  "):
            broken.append(line.split(": ", 1)[1])
        elif line.startswith("pass "):
            passed.append(line[5:])
        else:
            failed.setdefault(line[5:].split("(")[0], []).append(broken)
            broken = []
    for name in failed:
        print(f"{name}: {EXPECTED.get(name, ([], 'not expected to fail'))[1]}")
    print(f"{len(passed)} of {len(passed) + sum(map(len, failed.values()))} cases hold")
    # Conditions are compared one by one: a case that does not hold may get no worse, and one that holds now leaves `EXPECTED`.
    for name in sorted(failed.keys() | EXPECTED.keys()):
        if any(broken != EXPECTED.get(name, ([],))[0] for broken in failed.get(name, [[]])):
            sys.exit(f"{name}: other conditions fail than expected")


if __name__ == "__main__":
    main()
