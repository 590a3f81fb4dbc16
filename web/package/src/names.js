// Checks names of options, and names the nearest known one for an unknown one.

/** Throws a TypeError for an option that is not one of `names`. */
export function checkNames(options, names) {
  if (typeof options !== 'object' || options === null) throw new TypeError(`options: ${options} is not an object: give { ratio: 0.1 }`);
  const unknown = Object.keys(options).find((name) => !names.includes(name));
  if (unknown === undefined) return;
  const [nearest, distance] = names.map((name) => [name, editDistance(unknown, name)]).sort((a, b) => a[1] - b[1])[0];
  const meant = distance <= Math.max(2, unknown.length / 3) ? `; did you mean ${nearest}?` : `: choose from ${names.join(', ')}`;
  throw new TypeError(`no such option: ${unknown.slice(0, 80)}${meant}`);
}

/** Returns the number of letters to insert, delete or replace, ignoring case and underscores. */
function editDistance(one, other) {
  const [a, b] = [one, other].map((name) => name.slice(0, 80).toLowerCase().replaceAll('_', ''));
  let row = Array.from({ length: b.length + 1 }, (_, j) => j);
  for (let i = 1; i <= a.length; i++) {
    const above = row;
    row = [i];
    for (let j = 1; j <= b.length; j++) {
      row[j] = Math.min(above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1));
    }
  }
  return row[b.length];
}
