// The legend, which explains the signs that signs.py has found in the tracks of the page.

import LOOK from "../../render/tiles.json" with { type: "json" };
import { kept } from "./canvas.js";
import { element } from "./elements.js";

/** Style class, colour, and shape in tiles.json of each sign. Signs that are not listed are squares. */
const LOOKS = {
  R: ["disc", "robot"], r: ["disc box", "loaded"], H: ["", "person", "H"], stranded: ["disc", "stranded"],
  P: ["square on", "pickup", "P"], D: ["square on", "dropoff", "D"], C: ["square on", "charger", "C"],
  chassis: ["", "robot", "chassis"], "chassis-loaded": ["", "loaded", "chassis"], brake: ["line", "brake"],
  velocity: ["", "velocity", "push"], force: ["", "force", "push"], skid: ["line", "dark"],
  trail: ["line", "robot"], "trail-loaded": ["line dashed", "loaded"], low: ["line", "warning"],
  plan: ["dots", "ink"], plans: ["line", "robot"], wishes: ["dots", "robot"], pushes: ["", "ink", "push"],
  path: ["line", "warning"], hit: ["", "hit", "hit"], ends: ["disc", "light"],
  ghost: ["ghost", "ink"], ray: ["dots", "ink"], outline: ["line", "ink"],
};

/** Return the style class, the colour and the shape of a sign. */
export function lookOf(name, theme) {
  const [, age] = name.split("order-");
  if (age) return { look: "square", color: theme.orders[age] };
  const [look, color, shape] = LOOKS[name] ?? ["square", name];
  return { look, color: theme[color] ?? color, shape };
}

/** Fill a list with signs, given as names and labels, if the theme has changed. */
export function drawLegend(list, signs, theme) {
  kept(list, "signs", theme.key, () => list.replaceChildren(
    ...signs.map(([name, words]) => {
      const { look, color, shape } = lookOf(name, theme);
      const sign = element("span", { className: `sign ${look}`, ariaHidden: "true" });
      sign.style.setProperty("--sign", color);
      if (shape) sign.style.setProperty("--shape", clipOf(LOOK.shapes[shape], look ? 1 : 1.4));
      return element("li", {}, sign, words);
    }),
  ));
}

/** Return a shape, enlarged by a factor, as the clip path of a sign. */
function clipOf(corners, factor) {
  const percent = (part) => `${50 + 100 * factor * part}%`;
  return `polygon(${corners.map(([x, y]) => `${percent(x)} ${percent(y)}`).join()})`;
}
