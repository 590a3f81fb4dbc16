"""The network of `src/learned_baselines/potamias` in plain NumPy, pair by pair, in double precision.

`python3 potamias.py` prints the numbers that the tests of `src/learned_baselines/potamias/mod.rs` hold. Needs NumPy only.
Points and weights are sines of their indices, so that both sides make the same ones.
"""

import numpy as np

N, K, WIDTH, LATENT, SAMPLES = 20, 15, 4, 1, [2, 5, 13]


def relu(x):
    return np.maximum(x, 0.0)


def tensor(number, rows, columns):
    """Entry (i, j) of the tensor of that number in the order of the shapes."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    return np.sin(1.0 + 1.7 * number + 0.9 * i + 2.3 * j)


shapes = []
for layer in range(3):
    shapes += [(3 if layer == 0 else WIDTH, WIDTH), (WIDTH, WIDTH)]
    if layer > 0:
        shapes += [(2 * WIDTH, WIDTH), (1, WIDTH)]
shapes += [(WIDTH, LATENT), (LATENT, WIDTH), (LATENT, WIDTH), (4, WIDTH), (1, WIDTH), (WIDTH, 1), (WIDTH, 3)]
tensors = iter([tensor(number, *shape) for number, shape in enumerate(shapes)])

points = np.array([[np.sin(1.3 * i), np.cos(0.7 * i), np.sin(0.4 * i * i)] for i in range(N)])
distances = np.linalg.norm(points[:, None] - points[None], axis=-1)
neighbours = [[j for j in np.argsort(distances[i]) if j != i][:K] for i in range(N)]
radii = np.array([np.mean([distances[i, j] for j in neighbours[i]]) for i in range(N)])
unit = radii.mean()
x, radii = (points - points.mean(axis=0)) / unit, radii / unit

features = x
for layer in range(3):
    theta, phi = next(tensors), next(tensors)
    largest = np.array([np.max([(features[i] - features[j]) @ theta for j in neighbours[i]], axis=0) for i in range(N)])
    seen = relu(largest @ phi)
    if layer > 0:
        mixed, bias = next(tensors), next(tensors)
        seen = relu(np.concatenate([features, seen], axis=1) @ mixed + bias)
    features = seen
latent = features @ next(tensors)

own, near, offset, bias, attention, moved = tensors
closeness, result = np.sqrt(len(SAMPLES) / N), []
for s in SAMPLES:
    hidden = [
        relu(latent[s] @ own + latent[j] @ near + np.append((x[j] - x[s]) / radii[s], closeness) @ offset + bias[0])
        for j in neighbours[s]
    ]
    logits = np.array([(h @ attention)[0] for h in hidden])
    shares = np.exp(logits - logits.max()) / np.exp(logits - logits.max()).sum()
    result.append(x[s] + radii[s] * sum(share * h for share, h in zip(shares, hidden)) @ moved)

print("latent", latent[:6, 0].tolist())
print("refined", np.array(result).tolist())
