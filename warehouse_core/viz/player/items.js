// Draws items: orders that wait, and the item of a lone robot where it waits or has been put.

import { centerText, MIN_TEXT } from "./canvas.js";
import { LATE, waitingByPickup } from "./orders.js";

/** The side and the middle of an item in a cell, whose letter is in the opposite corner. */
const [SIDE, PLACE] = [0.4, 0.75];
const MIN_SIDE = 4;

/** Draw the orders of a fleet that wait at pickups. */
export function drawWaiting(context, track, moment, view, theme) {
  if (!track.fleet.orders) return;
  const side = Math.max(MIN_SIDE, SIDE * view.scale);
  for (const [cell, { count, age }] of waitingByPickup(track.fleet.orders, moment.step)) {
    const [row, column] = track.rowAndColumn(cell);
    const [x, y] = [view.x(column + PLACE), view.y(row + PLACE)];
    drawBox(context, x, y, side, theme.orders[age], theme);
    if (count > 1) drawCount(context, count, x, y, side, age, theme);
  }
}

/** Write how many orders wait, where there is room for it. */
function drawCount(context, count, x, y, side, age, theme) {
  const size = Math.max(0.7 * side, MIN_TEXT * theme.density);
  centerText(context, size);
  if (Math.max(context.measureText(String(count)).width, size) > side) return;
  context.fillStyle = age === LATE ? theme.light : theme.dark;
  context.fillText(String(count), x, y + 0.06 * size);
}

/** Draw the item of a lone robot where it waits or has been put. */
export function drawItem(context, track, moment, view, theme) {
  const side = Math.max(MIN_SIDE, SIDE * view.scale);
  for (const cell of itemCells(track, moment)) {
    const [row, column] = track.rowAndColumn(cell);
    drawBox(context, view.x(column + PLACE), view.y(row + PLACE), side, theme.item, theme);
  }
}

/** Return where the item of a lone robot waits or has been put. */
function itemCells(track, moment) {
  if (track.load[moment.frame] !== 0) return [];
  for (let frame = moment.frame; frame > 0; frame--) {
    if (track.isLoaded(0, frame - 1)) return [track.cell(0, frame)];
  }
  const tiles = track.tiles[track.tileAt[moment.frame]];
  return [...tiles].flatMap((tile, cell) => (tile === "P" ? [cell] : []));
}

/** Draw a box around its middle. */
export function drawBox(context, x, y, side, color, theme) {
  const [left, top, whole] = [x - side / 2, y - side / 2, side].map(Math.round);
  if (whole < 5) {
    context.fillStyle = theme.dark;
    context.fillRect(left, top, whole, whole);
    return;
  }
  const line = Math.max(1, Math.round(whole / 10));
  context.fillStyle = theme.light;
  context.fillRect(left - line, top - line, whole + 2 * line, whole + 2 * line);
  context.fillStyle = theme.dark;
  context.fillRect(left, top, whole, whole);
  context.fillStyle = color;
  context.fillRect(left + line, top + line, whole - 2 * line, whole - 2 * line);
  context.fillStyle = theme.dark;
  context.fillRect(left + Math.round((whole - line) / 2), top, line, Math.round(0.4 * whole));
}
