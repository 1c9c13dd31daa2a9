// The colours of canvases: those of the style sheet, light or dark, and those of the data.

const NAMES = [
  "paper", "ink", "quiet", "accent", "warning", "floor", "line", "wall", "board", "unseen",
  "stripe", "shadow", "visited", "ice", "wave", "item", "rim", "dark", "light",
];

let known = { key: "" };

/** Return the theme of an element; the same object until something changes. */
export function readTheme(element, colors) {
  const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
  const key = `${isDark} ${devicePixelRatio}`;
  if (key === known.key) return known;
  const style = getComputedStyle(element);
  const named = NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]);
  known = { ...Object.fromEntries(named), colors, density: devicePixelRatio, key };
  return known;
}
