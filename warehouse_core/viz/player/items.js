// Draws items: orders that wait, and the item of a lone robot where it waits or has been put.

import { waitingByPickup } from "./orders.js";

const MIN_DIGIT = 8;

/** Draw the orders of a fleet that wait at pickups. */
export function drawWaiting(context, track, moment, view, theme) {
  const step = Math.floor(track.progress[moment.frame]);
  if (!track.fleet.orders) return;
  const side = Math.max(4, 0.46 * view.scale);
  for (const [cell, { count, age }] of waitingByPickup(track.fleet.orders, step)) {
    const [x, y] = [view.x((cell % track.width) + 0.5), view.y(Math.floor(cell / track.width) + 0.5)];
    drawBox(context, x - side / 2, y - side / 2, side, theme.colors.orders[age], theme);
    if (side >= MIN_DIGIT && count > 1) drawCount(context, count, x, y, side, age, theme);
  }
}

function drawCount(context, count, x, y, side, age, theme) {
  context.fillStyle = age === 3 ? theme.light : theme.dark;
  context.font = `bold ${Math.round(0.7 * side)}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(String(count), x, y + 0.04 * side);
}

/** Draw the item of a lone robot where it waits or has been put. */
export function drawItem(context, track, moment, view, theme) {
  const side = Math.max(4, 0.36 * view.scale);
  for (const cell of itemCells(track, moment)) {
    const [column, row] = [cell % track.width, Math.floor(cell / track.width)];
    const [x, y] = [view.x(column + 0.76), view.y(row + 0.76)];
    drawBox(context, x - side / 2, y - side / 2, side, theme.item, theme);
  }
}

/** Return where the item of a lone robot waits or has been put. */
function itemCells(track, moment) {
  const load = track.load[moment.frame];
  if (load !== 0) return [];
  for (let frame = moment.frame; frame > 0; frame--) {
    if (track.load[frame - 1] > 0) return [track.cell(0, frame)];
  }
  const tiles = track.tiles[track.tileAt[moment.frame]];
  return [...tiles].flatMap((tile, cell) => (tile === "P" ? [cell] : []));
}

export function drawBox(context, x, y, side, color, theme) {
  const [left, top, whole] = [Math.round(x), Math.round(y), Math.round(side)];
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
