// The legend, which explains the signs that signs.py has found in the tracks of the page.

import LOOK from "../../render/tiles.json" with { type: "json" };
import { kept } from "./canvas.js";
import { element } from "./elements.js";

/** Fill a list with signs, each given as its words, style class, colour and shape, if the theme has changed. */
export function drawLegend(list, signs, theme) {
  kept(list, "signs", theme.key, () => list.replaceChildren(
    ...signs.map(([words, style, color, shape]) => {
      const sign = element("span", { className: `sign ${style}`, ariaHidden: "true" });
      sign.style.setProperty("--sign", theme[color] ?? color);
      if (shape) sign.style.setProperty("--shape", clipOf(LOOK.shapes[shape], style ? 1 : 1.4));
      return element("li", {}, sign, words);
    }),
  ));
}

/** Return a shape, enlarged by a factor, as the clip path of a sign. */
function clipOf(corners, factor) {
  const percent = (part) => `${50 + 100 * factor * part}%`;
  return `polygon(${corners.map(([x, y]) => `${percent(x)} ${percent(y)}`).join()})`;
}
