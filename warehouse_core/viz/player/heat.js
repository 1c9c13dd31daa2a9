// Where the robots of a fleet were held up so far: a map of its own, and the same on the floor.

import { element, partOf, setText } from "./elements.js";
import { heldUpUntil } from "./track.js";

/** Opacity of what is drawn on a floor, whose letters and lines are to be seen. */
const ON_FLOOR = 0.6;

/** Draw on a floor how often robots were held up in each cell. */
export function drawHeat(context, track, moment, view, theme) {
  const [width, height] = [track.width * view.scale, track.height * view.scale];
  context.imageSmoothingEnabled = false;
  context.globalAlpha = ON_FLOOR;
  context.drawImage(heatOf(track, moment.step, theme), view.x(0), view.y(0), width, height);
  context.globalAlpha = 1;
}

/** Return an image with a pixel for each cell; the same until something changes. */
function heatOf(track, step, theme) {
  const key = `${step} ${theme.key}`;
  if (track.heat?.key === key) return track.heat.image;
  const image = element("canvas", { width: track.width, height: track.height });
  const context = image.getContext("2d");
  const counts = heldUpUntil(track, step);
  const [, most] = highestOf(counts);
  for (const [cell, count] of counts) {
    context.fillStyle = theme.heat[Math.round((count / most) * (theme.heat.length - 1))];
    context.fillRect(cell % track.width, Math.floor(cell / track.width), 1, 1);
  }
  track.heat = { key, image };
  return image;
}

/** Return the cell with the highest count, and the count. */
function highestOf(counts) {
  return [...counts].reduce((best, each) => (each[1] > best[1] ? each : best), [-1, 0]);
}

export class HeatMap {
  /** Args: the `Track` of a fleet, and the figure of the page that shows its map. */
  constructor(track, figure) {
    Object.assign(this, { track, figure });
    this.canvas = partOf(figure, "map");
    Object.assign(this.canvas, { width: track.width, height: track.height });
    figure.hidden = !track.fleet.heldUp.step.length;
  }

  /** Draw the map of a moment, with a pixel for each cell, and say which is the highest count. */
  draw(moment, theme) {
    const key = `${moment.step} ${theme.key}`;
    if (this.figure.hidden || key === this.key) return;
    this.key = key;
    const { canvas, track } = this;
    const context = canvas.getContext("2d");
    context.drawImage(this.floorOf(track.tileAt[moment.frame], theme), 0, 0);
    context.drawImage(heatOf(track, moment.step, theme), 0, 0);
    partOf(this.figure, "ramp").style.background = `linear-gradient(to right, ${theme.heat.join()})`;
    this.say(heldUpUntil(track, moment.step));
  }

  /** Return an image of floor and walls; the same until something changes, because floors may be large. */
  floorOf(tileAt, theme) {
    const key = `${tileAt} ${theme.key}`;
    if (this.floor?.key === key) return this.floor.image;
    const { tiles, width, height } = this.track;
    const image = element("canvas", { width, height });
    const context = image.getContext("2d");
    for (let cell = 0; cell < width * height; cell++) {
      context.fillStyle = tiles[tileAt][cell] === "#" ? theme.shelf : theme.floor;
      context.fillRect(cell % width, Math.floor(cell / width), 1, 1);
    }
    this.floor = { key, image };
    return image;
  }

  say(counts) {
    const [cell, most] = highestOf(counts);
    const [row, column] = this.track.rowAndColumn(cell);
    const place = `most at row ${row}, column ${column}`;
    setText(partOf(this.figure, "most"), String(most));
    setText(partOf(this.figure, "peak"), most ? place : "nowhere yet");
    const label = most ? `Robots were held up ${place}: ${most} times` : "No robot was held up yet";
    this.canvas.setAttribute("aria-label", label);
  }
}
