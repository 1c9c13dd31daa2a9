// The legend: what the tracks of a page have in them, and nothing else.

import { element } from "./elements.js";
import { isBorder, placesOf } from "./floor.js";
import { AGES } from "./orders.js";

/** Return the signs of tracks: words, a shape of the style sheet, and a colour. */
export function signsOf(tracks, theme) {
  const has = (test) => tracks.some(test);
  const hasTile = (tile) => has((track) => track.tiles.some((tiles) => tiles.includes(tile)));
  const hasWall = (onBorder) =>
    has((track) => track.tiles.some((tiles) =>
      placesOf(track, tiles, "#").some(([row, column]) => isBorder(track, row, column) === onBorder)));
  const hasLoad = (test) => has((track) => track.load.some(test));
  const isFleet = has((track) => track.isFleet && track.robots > 1);
  const marks = tracks.find((track) => track.marks)?.marks;
  const signs = [
    [has((track) => track.robots > 0) && hasLoad((load) => load === 0), "robot, empty", "disc", theme.robot],
    [hasLoad((load) => load > 0), "robot with an item", "disc box", theme.loaded],
    [has((track) => track.bodies > track.robots), "person", "diamond", theme.person],
    [hasTile("P") && !marks, "P pickup", "square up", theme.pickup],
    [hasTile("D") && !marks, "D dropoff", "square down", theme.dropoff],
    [hasTile("C") && !marks, "C charger", "square diagonal", theme.charger],
    ...AGES.map((words, age) => [
      isFleet && has((track) => track.fleet?.orders), `order, ${words}`, "square", theme.orders[age],
    ]),
    [hasWall(false), "shelf", "square", theme.shelf],
    [hasWall(true), "wall", "square", theme.wall],
    [hasTile("?"), "not seen yet", "square", theme.unseen],
    [has((track) => track.slippery.length), "slippery floor", "square", theme.ice],
    [has((track) => track.robots === 1 && track.viewRadius !== null && !track.isFleet),
      "what the robot does not see", "square", theme.shadow],
    [has((track) => track.hits.frame.length), "hit", "star", theme.hit],
    [has((track) => track.route && !track.marks), "plan", "dots", theme.ink],
    [has((track) => track.fleet?.plans.frame.length), "plan of a robot", "line", theme.robot],
    [has((track) => track.fleet?.pushes.frame.length), "pushes", "arrow", theme.ink],
    ...(marks ? marks.names.map((name, i) => [true, name, "square", marks.colors[i]]) : []),
    [Boolean(marks), "S start, G goal", "disc", theme.light],
  ];
  return signs.filter(([isThere]) => isThere).map(([, words, shape, color]) => ({ words, shape, color }));
}

/** Fill a list with the signs of tracks, if the theme is another one than before. */
export function drawLegend(list, tracks, theme) {
  if (list.dataset.key === theme.key) return;
  list.dataset.key = theme.key;
  list.replaceChildren(
    ...signsOf(tracks, theme).map(({ words, shape, color }) => {
      const sign = element("span", { className: `sign ${shape}`, ariaHidden: "true" });
      sign.style.setProperty("--sign", color);
      return element("li", {}, sign, words);
    }),
  );
}
