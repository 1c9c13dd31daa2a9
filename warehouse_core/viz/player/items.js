// Draws items: orders that wait, and the item of a lone robot where it waits or has been put.

import { centerText } from "./canvas.js";
import { LATE, waitingByPickup } from "./orders.js";

const MIN_DIGIT = 8;

/** Draw the orders of a fleet that wait at pickups. */
export function drawWaiting(context, track, moment, view, theme) {
  if (!track.fleet.orders) return;
  const side = Math.max(4, 0.46 * view.scale);
  for (const [cell, { count, age }] of waitingByPickup(track.fleet.orders, moment.step)) {
    const [row, column] = track.rowAndColumn(cell);
    const [x, y] = [view.x(column + 0.5), view.y(row + 0.5)];
    drawBox(context, x, y, side, theme.orders[age], theme);
    if (side >= MIN_DIGIT && count > 1) drawCount(context, count, x, y, side, age, theme);
  }
}

function drawCount(context, count, x, y, side, age, theme) {
  context.fillStyle = age === LATE ? theme.light : theme.dark;
  centerText(context, 0.7 * side);
  context.fillText(String(count), x, y + 0.04 * side);
}

/** Draw the item of a lone robot where it waits or has been put. */
export function drawItem(context, track, moment, view, theme) {
  const side = Math.max(4, 0.36 * view.scale);
  for (const cell of itemCells(track, moment)) {
    const [row, column] = track.rowAndColumn(cell);
    drawBox(context, view.x(column + 0.76), view.y(row + 0.76), side, theme.item, theme);
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
