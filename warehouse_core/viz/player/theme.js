// The colours of canvases: those of the palette, light or dark.

import PALETTE from "../../render/palette.json" with { type: "json" };

/** Names of the colours of orders by their age: new, older, nearly due and late. */
const ORDERS = ["item", "order-older", "order-nearly-due", "order-late"];

let known = { key: "" };

/** Return the theme of the page; the same object until something changes. */
export function readTheme() {
  const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
  const key = `${isDark} ${devicePixelRatio}`;
  if (key === known.key) return known;
  const orders = ORDERS.map((name) => PALETTE.both[name]);
  const scheme = isDark ? "dark" : "light";
  const heat = PALETTE.heat[scheme];
  known = { ...PALETTE.both, ...PALETTE[scheme], orders, heat, density: devicePixelRatio, key };
  return known;
}
