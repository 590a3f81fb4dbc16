// The light or dark theme: the system's, until the reader chooses one.

const dark = matchMedia('(prefers-color-scheme: dark)');

/** Wires up the choice of the theme; `changed` is called with the colours of the 3-D view. */
export function makeTheme(changed) {
  const choice = document.getElementById('theme');
  const update = () => {
    const isDark = choice.value === 'dark' || (choice.value === 'system' && dark.matches);
    document.documentElement.dataset.theme = isDark ? 'dark' : 'light';
    changed(colours());
  };
  choice.addEventListener('change', update);
  dark.addEventListener('change', update);
  update();
}

function colours() {
  const style = getComputedStyle(document.documentElement);
  const names = ['stage', 'surface', 'result', 'wire'];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}
