"""The networks of `src/learned_baselines/dse` and their losses in plain NumPy, point by point, in double precision.

`python3 dse.py` prints the numbers that `src/learned_baselines/dse/mod.rs` holds. Needs NumPy only.
Places and weights are sines of their indices, so that both sides make the same ones. What was pooled is put beside each
point here, as the paper has it, and the best turn comes from a singular value decomposition.
"""

import numpy as np

GROUP, PATCHES = 5, 2
POINTWISE, POOLED, JOINED = [32, 32, 32, 32, 16], [16, 16], [16, 8]


def relu(x):
    return np.maximum(x, 0.0)


def tensor(number, rows, columns):
    """Entry (i, j) of the tensor of that number in the order of the shapes."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    return np.sqrt(2.0 / rows) * np.sin(1.0 + 1.7 * number + 0.9 * i * i + 2.3 * i * j + 1.1 * j)


def shapes_of(network, n_out):
    width = 4
    for name, widths in [("pointwise", POINTWISE), ("pooled", POOLED)]:
        for i, after in enumerate(widths):
            yield f"{network}.{name}_{i}.weights", (width, after)
            yield f"{network}.{name}_{i}.bias", (1, after)
            width = after
    for stage, n in [("coarse", 3), ("fine", n_out)]:
        for name, before, after in [("of_patch", width, JOINED[0]), ("hidden", *JOINED), ("out", JOINED[1], n)]:
            yield f"{network}.{stage}.{name}.weights", (before, after)
            yield f"{network}.{stage}.{name}.bias", (1, after)
    for stage in ["coarse", "fine"]:
        yield f"{network}.{stage}.of_point", (4, JOINED[0])


shapes = [*shapes_of("classifier", 1), *shapes_of("map", 2)]
t = {name: tensor(number, *shape) for number, (name, shape) in enumerate(shapes)}
places = np.array([[np.sin(1.3 * i + 2.1 * a) if i % GROUP else 0.0 for a in range(3)] for i in range(PATCHES * GROUP)])
exact = np.array([[np.cos(0.8 * i), np.sin(1.9 * i)] for i in range(PATCHES * GROUP)])


def with_distances(x):
    return np.column_stack([x, np.maximum(np.linalg.norm(x - x[0], axis=1), 1e-4)])


def layer(x, name):
    return x @ t[name + ".weights"] + t[name + ".bias"]


def run(network, patch):
    seen = with_distances(patch)
    for i in range(5):
        seen = relu(layer(seen, f"{network}.pointwise_{i}"))
    pooled = seen.max(axis=0, keepdims=True)
    for i in range(2):
        pooled = relu(layer(pooled, f"{network}.pooled_{i}"))
    x = patch
    for stage in ["coarse", "fine"]:
        name = f"{network}.{stage}"
        beside = np.concatenate([with_distances(x), np.repeat(pooled, GROUP, axis=0)], axis=1)
        weights = np.concatenate([t[name + ".of_point"], t[name + ".of_patch.weights"]])
        x = relu(beside @ weights + t[name + ".of_patch.bias"])
        x = layer(relu(layer(x, name + ".hidden")), name + ".out")
    return x


patches = places.reshape(PATCHES, GROUP, 3)
logits = np.concatenate([run("classifier", patch) for patch in patches])[:, 0]
maps = np.concatenate([run("map", patch) for patch in patches])

entropies = []
for i, z in enumerate(logits):
    if i % GROUP:
        p = 1.0 / (1.0 + np.exp(-z))
        entropies.append(-np.log(p) if i % 3 == 1 else -np.log(1.0 - p))

errors = []
for found, wanted in zip(maps.reshape(PATCHES, GROUP, 2), exact.reshape(PATCHES, GROUP, 2)):
    u, _, v = np.linalg.svd(found.T @ wanted)
    turned = found @ (u @ v)
    radial = np.linalg.norm(found, axis=1) - np.linalg.norm(wanted, axis=1)
    errors.extend(((turned - wanted) ** 2).sum(axis=1) + radial**2)


def constant(name, kind, value):
    print(f"const {name}: {kind} = {value};")


constant("LOGITS", f"[f64; {len(logits)}]", logits.tolist())
constant("MAP", f"[f64; {maps.size}]", maps.ravel().tolist())
constant("NEIGHBOUR_LOSS", "f64", np.mean(entropies))
constant("MAP_LOSS", "f64", np.mean(errors))
