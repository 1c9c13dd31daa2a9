// The legend: what the tracks of a page have in them, and nothing else.

import LOOK from "../../render/tiles.json" with { type: "json" };
import { kept } from "./canvas.js";
import { element } from "./elements.js";
import { isBorder, placesOf } from "./floor.js";
import { AGES } from "./orders.js";

/** Return the signs of tracks: words, classes of the style sheet, a colour, and a shape of tiles.json. */
export function signsOf(tracks, theme) {
  const { words } = LOOK;
  const has = (test) => tracks.some(test);
  const hasTile = (tile) => has((track) => track.tiles.some((tiles) => tiles.includes(tile)));
  const hasWall = (onBorder) =>
    has((track) => track.tiles.some((tiles) =>
      placesOf(track, tiles, "#").some(([row, column]) => isBorder(track, row, column) === onBorder)));
  const hasLoad = (test) => has((track) => track.load.some(test));
  const isFleet = has((track) => track.isFleet && track.robots > 1);
  const marks = tracks.find((track) => track.marks)?.marks;
  const isSeen = (track) => track.robots === 1 && track.viewRadius !== null && !track.isFleet;
  const signs = [
    [has((track) => track.robots > 0) && hasLoad((load) => load === 0), words.R, "disc", "robot"],
    [hasLoad((load) => load > 0), words.r, "disc box", "loaded"],
    [has((track) => track.bodies > track.robots), words.H, "", "person", "H"],
    ...[..."PDC"].map((tile) => [
      hasTile(tile) && !marks, `${tile} ${words[tile]}`, "square on", words[tile], tile,
    ]),
    ...AGES.map((age, i) => [
      isFleet && has((track) => track.fleet?.orders), `order, ${age}`, "square", theme.orders[i],
    ]),
    [hasWall(false), words.shelf, "square", "shelf"],
    [hasWall(true), words.wall, "square", "wall"],
    [hasTile("?"), words.unseen, "square", "unseen"],
    [has((track) => track.slippery.length), words.ice, "square", "ice"],
    [has(isSeen), words.shadow, "square", "shadow"],
    [has((track) => track.hits.frame.length), words.hit, "", "hit", "hit"],
    [has((track) => track.route && !track.marks), words.plan, "dots", "ink"],
    [has((track) => track.fleet?.plans.frame.length), words.plans, "line", "robot"],
    [has((track) => track.fleet?.pushes.frame.length), words.pushes, "", "ink", "push"],
    ...(marks?.names ?? []).map((name, i) => [true, name, "square", marks.colors[i]]),
    [Boolean(marks), words.ends, "disc", "light"],
  ];
  return signs.filter(([isThere]) => isThere).map(([, text, look, color, shape]) =>
    ({ words: text, look, color: theme[color] ?? color, shape }));
}

/** Fill a list with the signs of tracks, if the theme is another one than before. */
export function drawLegend(list, tracks, theme) {
  kept(list, "signs", theme.key, () => list.replaceChildren(
    ...signsOf(tracks, theme).map(({ words, look, color, shape }) => {
      const sign = element("span", { className: `sign ${look}`, ariaHidden: "true" });
      sign.style.setProperty("--sign", color);
      if (shape) sign.style.setProperty("--shape", clipOf(LOOK.shapes[shape], look ? 1 : 1.4));
      return element("li", {}, sign, words);
    }),
  ));
}

/** Return a shape, enlarged by a factor, as one that is cut out of the sign. */
function clipOf(corners, factor) {
  const percent = (part) => `${50 + 100 * factor * part}%`;
  return `polygon(${corners.map(([x, y]) => `${percent(x)} ${percent(y)}`).join()})`;
}
