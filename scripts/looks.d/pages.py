"""The page of all pictures, the blind page, and the table of figures."""

import html
import json
import math
import statistics
from collections import defaultdict

OURS = ("neural-mesh", "neural-mesh looks")

STYLE = """
body { font: 15px/1.4 system-ui, sans-serif; margin: 2rem; color: #222; }
.row { display: flex; flex-wrap: wrap; gap: .75rem; margin-bottom: 2rem; }
figure { margin: 0; width: 20rem; } img { width: 100%; border: 1px solid #ddd; } .best { font-weight: bold; }
button { font: inherit; padding: .5rem 1rem; } .pair figure { width: min(32vw, 32rem); cursor: pointer; }
"""

BLIND = """<!doctype html><meta charset="utf-8"><title>Which is nearer?</title><style>%s</style>
<h1>Which result looks more like the original?</h1>
<p id="left"></p><div class="row pair">
<figure><img id="original"><figcaption>original</figcaption></figure>
<figure><img class="choice"><figcaption>A</figcaption></figure><figure><img class="choice"><figcaption>B</figcaption></figure></div>
<button id="equal">Both alike</button> <button id="save">Save the choices</button>
<script>
const pairs = %s;
const choices = [];
const shuffled = pairs.map((pair) => [Math.random(), pair]).sort((a, b) => a[0] - b[0]).map(([, pair]) => pair);
let at = 0, shown = [];
function show() {
  document.getElementById('left').textContent = `${choices.length} chosen, ${shuffled.length - at} left`;
  if (at === shuffled.length) return;
  const pair = shuffled[at];
  shown = Math.random() < 0.5 ? pair.results : [...pair.results].reverse();
  document.getElementById('original').src = pair.original;
  document.querySelectorAll('.choice').forEach((image, k) => { image.src = shown[k].picture; });
}
function choose(k) {
  if (at === shuffled.length) return;
  const { asset, ratio } = shuffled[at++];
  choices.push({ asset, ratio, methods: shown.map((it) => it.method), chosen: k < 0 ? 'both' : shown[k].method });
  show();
}
document.querySelectorAll('.choice').forEach((image, k) => image.addEventListener('click', () => choose(k)));
document.getElementById('equal').addEventListener('click', () => choose(-1));
document.getElementById('save').addEventListener('click', () => {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([JSON.stringify(choices, null, 1)], { type: 'application/json' }));
  link.download = 'choices.json';
  link.click();
});
show();
</script>
"""


def by_case(rows):
    cases = defaultdict(list)
    for row in rows:
        cases[row["asset"], row["ratio"]].append(row)
    return cases


def picture_of(row):
    return f"results/{row['asset']}/{row['ratio']} {row['method']}.png"


def is_as_large(one, other):
    return abs(int(one["faces"]) / int(other["faces"]) - 1) < 0.05


def write_pages(work, rows):
    """Writes `index.html` and `blind.html`."""
    text, pairs = [f'<!doctype html><meta charset="utf-8"><title>What a viewer sees</title><style>{STYLE}</style>'], []
    for (asset, ratio), results in by_case(rows).items():
        original = f"results/{asset}/original.png"
        least = min(float(row["flip"]) for row in results)
        text.append(f'<h2>{html.escape(asset)}, ratio {ratio}</h2><div class="row">')
        text.append(f'<figure><img loading="lazy" src="{html.escape(original)}"><figcaption>original</figcaption></figure>')
        for row in results:
            caption = f"{row['method']}: FLIP {float(row['flip']):.4f}, {int(row['faces']):,} faces"
            mark = ' class="best"' if float(row["flip"]) == least else ""
            image = f'<img loading="lazy" src="{html.escape(picture_of(row))}">'
            text.append(f"<figure>{image}<figcaption{mark}>{html.escape(caption)}</figcaption></figure>")
        text.append("</div>")
        shown = [{"method": row["method"], "picture": picture_of(row), "faces": int(row["faces"])} for row in results]
        pairs += [
            {"asset": asset, "ratio": ratio, "original": original, "results": [one, other]}
            for k, one in enumerate(shown)
            for other in shown[k + 1 :]
            if is_as_large(one, other)
        ]
    (work / "index.html").write_text("\n".join(text))
    (work / "blind.html").write_text(BLIND % (STYLE, json.dumps(pairs).replace("<", "\\u003c")))


def median(numbers):
    return statistics.median(numbers) if numbers else math.nan


def print_table(rows):
    """Prints FLIP of `looks` over the default and over the best peer, as medians over assets, by ratio."""
    print(f"{'ratio':>6} {'assets':>6} {'over the default':>17} {'over the best peer':>19} {'of':>4} {'peer 3 % better':>16}")
    cases = by_case(rows)
    for ratio in sorted({row["ratio"] for row in rows}, key=float, reverse=True):
        over_default, over_peer = [], []
        for (_, own_ratio), results in cases.items():
            flips = {row["method"]: float(row["flip"]) for row in results}
            if own_ratio != ratio or any(name not in flips for name in OURS):
                continue
            default = next(row for row in results if row["method"] == OURS[0])
            peers = [flips[row["method"]] for row in results if row["method"] not in OURS and is_as_large(row, default)]
            over_default.append(flips[OURS[1]] / max(flips[OURS[0]], 1e-9))
            over_peer += [flips[OURS[1]] / max(min(peers), 1e-9)] if peers else []
        n_worse = sum(quotient > 1.03 for quotient in over_peer)
        print(f"{ratio:>6} {len(over_default):>6} {median(over_default):>17.3f} {median(over_peer):>19.3f} {len(over_peer):>4} {n_worse:>16}")
