// The finish of a material: factors, and maps by name.

/** Returns a finish whose maps are what `imageOf` returns for them; undefined stays. */
export function withImages(finish, imageOf) {
  if (!finish) return undefined;
  const maps = Object.entries(finish.maps).map(([name, image]) => [name, imageOf(image)]);
  return { ...finish, maps: Object.fromEntries(maps) };
}
