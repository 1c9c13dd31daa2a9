// Draws what tints the cells of a floor: visits, sight, and the marks of a search.

import { centerText, fillOutlined } from "./canvas.js";
import { outerOf } from "./floor.js";
import { visitsUntil } from "./track.js";

/** Darken what a robot does not see, around the window of its view. */
export function drawSight(context, track, body, moment, view, theme) {
  const pose = track.pose(body, moment);
  if (track.viewRadius === null || !pose) return;
  const [column, row] = [Math.floor(pose.x) - track.viewRadius, Math.floor(pose.y) - track.viewRadius];
  const side = 2 * track.viewRadius + 1;
  const outer = outerOf(track);
  const [left, top] = [Math.max(column, outer), Math.max(row, outer)];
  const right = Math.min(column + side, track.width - outer);
  const bottom = Math.min(row + side, track.height - outer);
  context.fillStyle = theme.shadow;
  context.beginPath();
  context.rect(...view.box(outer, outer, track.width - 2 * outer, track.height - 2 * outer));
  context.rect(...view.box(left, top, right - left, bottom - top));
  context.fill("evenodd");
}

/** Tint the cells that a robot has been to, the more the oftener. */
export function drawVisits(context, track, body, moment, view, theme) {
  for (const [cell, count] of visitsUntil(track, body, moment.frame)) {
    if (count < 2) continue;
    const [row, column] = track.rowAndColumn(cell);
    context.globalAlpha = Math.min(0.12 * (count - 1), 0.5);
    context.fillStyle = theme.visited;
    context.fillRect(...view.box(column, row));
  }
  context.globalAlpha = 1;
}

/** Draw the cells of a search in the colours that they have by now. */
export function drawMarks(context, track, moment, view) {
  for (const [cell, index] of marksUntil(track, moment.time, track.marks)) {
    const [row, column] = track.rowAndColumn(cell);
    context.fillStyle = track.marks.colors[index];
    context.fillRect(...view.box(column, row, 1, 1, 0.03));
  }
}

/** Draw the start and the goal of a search as letters. */
export function drawEnds(context, track, view, theme) {
  track.marks.ends.forEach(([row, column], i) => {
    const [x, y, radius] = [view.x(column + 0.5), view.y(row + 0.5), Math.max(8, 0.46 * view.scale)];
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    fillOutlined(context, theme.light, theme.dark, Math.max(1, radius / 8));
    context.fillStyle = theme.dark;
    centerText(context, 1.3 * radius);
    context.fillText("SG"[i], x, y + 0.08 * radius);
  });
}

/** Return the mark of each cell at a time, as a map. */
export function marksUntil(track, until, { time, cell, value }) {
  const known = track.marked && track.marked.until <= until;
  const found = known ? track.marked : { until: -1, next: 0, cells: new Map() };
  while (found.next < time.length && time[found.next] <= until) {
    found.cells.set(cell[found.next], value[found.next]);
    found.next++;
  }
  found.until = until;
  track.marked = found;
  return found.cells;
}
