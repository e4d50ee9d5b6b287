// The theme, light or dark, as set in the browser or by the button. Style sheets use data-theme; canvases ask for colours.

'use strict';

const Theme = (() => {
  const root = document.documentElement;
  const dark = window.matchMedia('(prefers-color-scheme: dark)');
  const listeners = [];
  let style = getComputedStyle(root);
  const known = new Map();  // cached values of CSS variables
  let chosen = null;  // theme chosen with the button; null: the browser's theme
  let printing = false;

  function apply() {
    const theme = printing ? 'light' : chosen || (dark.matches ? 'dark' : 'light');
    if (root.dataset.theme === theme) return;
    root.dataset.theme = theme;
    style = getComputedStyle(root);
    known.clear();
    for (const listener of listeners) listener();
  }
  function print(on) {
    printing = on;
    apply();
  }

  // The value of a CSS variable: '--grid' -> '#e8ebef'.
  function color(name) {
    if (!known.has(name)) known.set(name, style.getPropertyValue(name).trim());
    return known.get(name);
  }

  dark.addEventListener('change', apply);
  window.addEventListener('beforeprint', () => print(true));
  window.addEventListener('afterprint', () => print(false));
  apply();
  return {
    color,
    series: (i) => color(`--series-${i % 8}`),
    band: (i) => color(`--band-${i % 5}`),
    toggle() {
      chosen = root.dataset.theme === 'dark' ? 'light' : 'dark';
      apply();
    },
    onChange: (listener) => listeners.push(listener),
    // Calls `draw` with the colours of the light theme and returns its result. The page itself stays as it is.
    onPaper(draw) {
      const theme = root.dataset.theme;
      root.dataset.theme = 'light';
      known.clear();
      try {
        return draw();
      } finally {
        root.dataset.theme = theme;
        known.clear();
      }
    },
  };
})();
