// Draws what moves: robots with items, people, trails, planned ways, hits and orders.

import { ageOf, orderOf, waitingByPickup } from "./orders.js";
import { heldUpUntil, visitsUntil } from "./track.js";

const RADIUS = 0.34;
const MIN_RADIUS = 2;
const MIN_DETAIL = 7;
const MIN_NUMBER = 8;
const TRAIL_FRAMES = 120;
const WAY_STEPS = 20;
const MAX_HEAT = 0.75;

/** Draw everything that moves at a moment. `chosen` is the number of a robot, or `null`. */
export function drawBodies(context, track, moment, view, theme, { chosen, hasHeat }) {
  const watched = chosen ?? (track.robots === 1 && track.bodies > 0 ? 0 : null);
  if (track.marks) drawMarks(context, track, moment, view, theme);
  if (watched !== null) drawVisits(context, track, watched, moment, view, theme);
  if (hasHeat) drawHeat(context, track, moment, view, theme);
  if (watched !== null && !track.isFleet) drawSight(context, track, watched, moment, view, theme);
  drawRoute(context, track.routeIn(moment.frame), view, theme);
  if (track.fleet) drawPlans(context, track, moment, view, theme);
  if (chosen !== null) drawWayAhead(context, track, chosen, moment, view, theme);
  if (watched !== null) drawTrail(context, track, watched, moment, view, theme);
  drawWaiting(context, track, moment, view, theme);
  drawRobots(context, track, moment, view, theme, chosen);
  if (track.fleet) drawPushes(context, track, moment, view, theme);
  drawHits(context, track, moment, view, theme);
}

function drawRobots(context, track, moment, view, theme, chosen) {
  const radius = Math.max(RADIUS * view.scale, MIN_RADIUS);
  const groups = new Map();
  const shown = [];
  for (let body = 0; body < track.bodies; body++) {
    const pose = track.pose(body, moment);
    if (!pose || !view.shows(pose.x, pose.y, 1)) continue;
    const color = colorOf(track, body, pose, moment, theme);
    const [x, y] = [view.x(pose.x), view.y(pose.y)];
    const item = { body, x, y, heading: pose.heading, load: pose.load };
    shown.push(item);
    if (!groups.has(color)) groups.set(color, []);
    groups.get(color).push(item);
  }
  if (radius >= MIN_DETAIL) drawNoses(context, shown, radius, theme);
  for (const [color, items] of groups) {
    context.fillStyle = color;
    context.beginPath();
    for (const { body, x, y } of items) outline(context, x, y, radius, body >= track.robots);
    context.fill();
    if (radius < 4) continue;
    context.strokeStyle = theme.dark;
    context.lineWidth = Math.max(1, radius / 8);
    context.stroke();
  }
  drawItems(context, shown, track, radius, theme);
  drawBatteries(context, shown, track, moment, radius, theme);
  if (radius >= MIN_NUMBER) drawNames(context, shown, track, radius, theme);
  const mine = shown.find((item) => item.body === chosen);
  if (mine) drawRing(context, mine, radius, theme);
}

function outline(context, x, y, radius, isPerson) {
  if (isPerson) {
    context.moveTo(x, y - radius);
    for (const [dx, dy] of [[1, 0], [0, 1], [-1, 0]]) context.lineTo(x + dx * radius, y + dy * radius);
    context.closePath();
  } else {
    context.moveTo(x + radius, y);
    context.arc(x, y, radius, 0, 2 * Math.PI);
  }
}

function colorOf(track, body, pose, moment, theme) {
  if (body >= track.robots) return theme.colors.H;
  if (track.fleet && share(track, body, moment) <= 0) return theme.colors.stranded;
  return theme.colors[pose.load > 0 ? "r" : "R"];
}

function share(track, body, moment) {
  return track.fleet.battery[body * track.frames + moment.frame];
}

/** Draw the nose of each robot that has a heading: a wedge at its rim. */
function drawNoses(context, shown, radius, theme) {
  context.fillStyle = theme.dark;
  context.beginPath();
  for (const { x, y, heading } of shown) {
    if (heading === null) continue;
    const at = (angle, reach) => [
      x + reach * radius * Math.cos(heading + angle),
      y + reach * radius * Math.sin(heading + angle),
    ];
    context.moveTo(...at(0, 1.42));
    context.lineTo(...at(0.5, 0.95));
    context.lineTo(...at(-0.5, 0.95));
  }
  context.fill();
}

/** Draw a box on each loaded robot, of the colour of its order's age. */
function drawItems(context, shown, track, radius, theme) {
  const side = Math.max(2, 0.95 * radius);
  for (const { x, y, load } of shown) {
    if (load <= 0) continue;
    const away = radius < MIN_DETAIL ? 0 : 0.55 * radius;
    const color = track.isFleet ? theme.colors.orders[load - 1] : theme.item;
    drawBox(context, x + away - side / 2, y - away - side / 2, side, color, theme);
  }
}

function drawBox(context, x, y, side, color, theme) {
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

/** Draw a bar below each robot whose battery is low, or of a few robots below each. */
function drawBatteries(context, shown, track, moment, radius, theme) {
  if (!track.fleet || radius < 4) return;
  const [length, height] = [2 * radius, Math.max(2, 0.3 * radius)];
  for (const { body, x, y } of shown) {
    if (body >= track.robots) continue;
    const level = share(track, body, moment);
    if (level >= 0.25 && track.robots > 12) continue;
    const [left, top] = [x - radius, y + 0.8 * radius];
    context.fillStyle = theme.dark;
    context.fillRect(left - 1, top - 1, length + 2, height + 2);
    context.fillStyle = theme.light;
    context.fillRect(left, top, length, height);
    context.fillStyle = level < 0.25 ? theme.colors.warning : theme.colors.battery;
    context.fillRect(left, top, level * length, height);
  }
}

function drawNames(context, shown, track, radius, theme) {
  context.textAlign = "center";
  context.textBaseline = "middle";
  const isLone = track.robots === 1;
  const digits = isLone ? 1 : String(track.robots - 1).length;
  const size = Math.min(1.1, 2 / digits) * radius;
  if (size < MIN_NUMBER) return;
  context.font = `bold ${Math.round(size)}px system-ui, sans-serif`;
  for (const { body, x, y, load } of shown) {
    const isPerson = body >= track.robots;
    const name = isPerson ? "H" : isLone ? (load > 0 ? "r" : "R") : String(body);
    context.fillStyle = !isPerson && load > 0 ? theme.dark : theme.light;
    context.fillText(name, x, y + 0.06 * size);
  }
}

function drawRing(context, { x, y }, radius, theme) {
  for (const [color, width] of [[theme.light, 5], [theme.accent, 3]]) {
    context.strokeStyle = color;
    context.lineWidth = width * theme.density;
    context.beginPath();
    context.arc(x, y, Math.max(radius * 1.5, 8 * theme.density), 0, 2 * Math.PI);
    context.stroke();
  }
}

/** Darken what a robot does not see, around the window of its view. */
function drawSight(context, track, body, moment, view, theme) {
  const pose = track.pose(body, moment);
  if (track.viewRadius === null || !pose) return;
  const [column, row] = [Math.floor(pose.x) - track.viewRadius, Math.floor(pose.y) - track.viewRadius];
  const side = 2 * track.viewRadius + 1;
  const [left, top] = [Math.max(column, 0), Math.max(row, 0)];
  const [right, bottom] = [Math.min(column + side, track.width), Math.min(row + side, track.height)];
  context.fillStyle = theme.shadow;
  context.beginPath();
  context.rect(...view.box(0, 0, track.width, track.height));
  context.rect(...view.box(left, top, right - left, bottom - top));
  context.fill("evenodd");
}

/** Tint the cells that a robot has been to, the more the oftener. */
function drawVisits(context, track, body, moment, view, theme) {
  for (const [cell, count] of visitsUntil(track, body, moment.frame)) {
    if (count < 2) continue;
    context.globalAlpha = Math.min(0.12 * (count - 1), 0.5);
    context.fillStyle = theme.visited;
    context.fillRect(...view.box(cell % track.width, Math.floor(cell / track.width)));
  }
  context.globalAlpha = 1;
}

/** Draw how often robots were held up in each cell so far. */
function drawHeat(context, track, moment, view, theme) {
  const counts = heldUpUntil(track, moment.frame);
  const most = Math.max(1, ...counts.values());
  context.fillStyle = theme.colors.warning;
  for (const [cell, count] of counts) {
    context.globalAlpha = 0.1 + (MAX_HEAT - 0.1) * (count / most);
    context.fillRect(...view.box(cell % track.width, Math.floor(cell / track.width)));
  }
  context.globalAlpha = 1;
}

function drawTrail(context, track, body, moment, view, theme) {
  context.lineCap = "round";
  context.lineWidth = Math.max(1.5 * theme.density, view.scale / 11);
  const first = Math.max(0, moment.frame - TRAIL_FRAMES);
  let before = track.pose(body, { frame: first, next: first, share: 0 });
  for (let frame = first + 1; frame <= moment.frame + 1; frame++) {
    const isLast = frame > moment.frame;
    const after = track.pose(body, isLast ? moment : { frame, next: frame, share: 0 });
    if (before && after && (before.x !== after.x || before.y !== after.y)) {
      context.globalAlpha = 0.15 + 0.75 * (1 - (moment.frame + 1 - frame) / TRAIL_FRAMES);
      context.strokeStyle = theme.colors[before.load > 0 ? "r" : "R"];
      context.setLineDash(before.load > 0 ? [view.scale / 5, view.scale / 5] : []);
      context.beginPath();
      context.moveTo(view.x(before.x), view.y(before.y));
      context.lineTo(view.x(after.x), view.y(after.y));
      context.stroke();
    }
    before = after;
  }
  context.globalAlpha = 1;
  context.setLineDash([]);
}

function drawRoute(context, points, view, theme) {
  if (points.length) drawDots(context, points, view, theme.ink);
}

/** Draw where a chosen robot drives next, as dots. */
function drawWayAhead(context, track, body, moment, view, theme) {
  const points = [];
  const step = Math.ceil(track.progress[moment.next]);
  for (const frame of track.stepFrames.slice(step, step + WAY_STEPS)) {
    const pose = track.pose(body, { frame, next: frame, share: 0 });
    if (pose) points.push([pose.x, pose.y]);
  }
  drawDots(context, points, view, theme.accent);
}

function drawDots(context, points, view, color) {
  context.fillStyle = color;
  const radius = Math.max(1.2, view.scale / 14);
  context.beginPath();
  for (let i = 0; i < points.length; i++) {
    const [x, y] = points[i];
    const [nextX, nextY] = points[i + 1] ?? points[i];
    for (const between of [0, 0.5]) {
      const px = view.x(x + between * (nextX - x));
      const py = view.y(y + between * (nextY - y));
      context.moveTo(px + radius, py);
      context.arc(px, py, radius, 0, 2 * Math.PI);
    }
  }
  context.fill();
}

/** Return the plans of a fleet by frame: for each its lines of robot, kind and cells. */
function plansOf(track) {
  if (track.planLines) return track.planLines;
  const { plans, ways, pushes } = track.fleet;
  const [count, pushCount] = [plans.length / 4, pushes.length / 3];
  const found = new Map();
  const at = (frame) => {
    if (!found.has(frame)) found.set(frame, { lines: [], pushes: [] });
    return found.get(frame);
  };
  for (let i = 0, first = 0; i < count; i++) {
    const [frame, robot, kind, length] = [0, 1, 2, 3].map((part) => plans[part * count + i]);
    at(frame).lines.push({ robot, isWish: kind === 1, cells: ways.subarray(first, first + length) });
    first += length;
  }
  for (let i = 0; i < pushCount; i++) {
    at(pushes[i]).pushes.push([pushes[2 * pushCount + i], pushes[pushCount + i]]);
  }
  track.planLines = found;
  return found;
}

function drawPlans(context, track, moment, view, theme) {
  context.lineCap = "round";
  context.lineJoin = "round";
  for (const { robot, isWish, cells } of plansOf(track).get(moment.frame)?.lines ?? []) {
    const pose = track.pose(robot, moment);
    context.strokeStyle = colorOf(track, robot, pose, moment, theme);
    context.lineWidth = Math.max(2, view.scale / (isWish ? 8 : 5));
    context.setLineDash(isWish ? [0.1, view.scale / 3] : []);
    context.beginPath();
    cells.forEach((cell, i) => {
      const x = view.x((cell % track.width) + 0.5);
      const y = view.y(Math.floor(cell / track.width) + 0.5);
      if (i) context.lineTo(x, y);
      else context.moveTo(x, y);
    });
    context.stroke();
  }
  context.setLineDash([]);
}

/** Draw an arrow from each robot that pushes to the one that it pushes. */
function drawPushes(context, track, moment, view, theme) {
  const radius = Math.max(0.3 * view.scale, 4);
  for (const [pusher, robot] of plansOf(track).get(moment.frame)?.pushes ?? []) {
    const [from, to] = [track.pose(pusher, moment), track.pose(robot, moment)];
    const angle = Math.atan2(to.y - from.y, to.x - from.x);
    const [x, y] = [view.x((from.x + to.x) / 2), view.y((from.y + to.y) / 2)];
    context.beginPath();
    for (const turn of [0, 2.4, -2.4]) {
      context.lineTo(x + radius * Math.cos(angle + turn), y + radius * Math.sin(angle + turn));
    }
    context.closePath();
    context.fillStyle = theme.dark;
    context.strokeStyle = theme.light;
    context.lineWidth = 1;
    context.fill();
    context.stroke();
  }
}

/** Draw the items that wait: orders of a fleet at pickups, or the one of a lone robot. */
function drawWaiting(context, track, moment, view, theme) {
  const step = Math.floor(track.progress[moment.frame]);
  const side = Math.max(4, 0.46 * view.scale);
  if (track.fleet?.orders) {
    for (const [cell, { count, age }] of waitingByPickup(track.fleet.orders, step)) {
      const [x, y] = [view.x((cell % track.width) + 0.5), view.y(Math.floor(cell / track.width) + 0.5)];
      drawBox(context, x - side / 2, y - side / 2, side, theme.colors.orders[age], theme);
      if (side >= MIN_NUMBER && count > 1) drawCount(context, count, x, y, side, age, theme);
    }
  } else if (track.robots === 1) {
    for (const cell of itemCells(track, moment)) {
      const [column, row] = [cell % track.width, Math.floor(cell / track.width)];
      const [x, y] = [view.x(column + 0.68), view.y(row + 0.68)];
      drawBox(context, x - side / 2, y - side / 2, side, theme.item, theme);
    }
  }
}

function drawCount(context, count, x, y, side, age, theme) {
  context.fillStyle = age === 3 ? theme.light : theme.dark;
  context.font = `bold ${Math.round(0.7 * side)}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(String(count), x, y + 0.04 * side);
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

function drawHits(context, track, moment, view, theme) {
  const hits = track.hitsIn(moment.frame);
  const radius = Math.max(5, 0.26 * view.scale * (track.robots > 1 ? 0.7 : 1));
  for (const { x, y } of hits) {
    context.beginPath();
    for (let point = 0; point < 10; point++) {
      const reach = point % 2 ? 0.45 * radius : radius;
      const angle = (point / 10) * 2 * Math.PI - Math.PI / 2;
      context.lineTo(view.x(x) + reach * Math.cos(angle), view.y(y) + reach * Math.sin(angle));
    }
    context.closePath();
    context.fillStyle = theme.colors.hit;
    context.strokeStyle = theme.dark;
    context.lineWidth = Math.max(1, radius / 10);
    context.fill();
    context.stroke();
  }
  const last = hits.at(-1);
  if (last?.label) drawLabel(context, last, radius, view, theme);
}

function drawLabel(context, { x, y, label }, radius, view, theme) {
  const size = Math.max(12 * theme.density, 0.3 * view.scale);
  context.font = `bold ${Math.round(size)}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const width = context.measureText(label).width + size;
  const middle = Math.min(Math.max(view.x(x), width / 2), view.canvasWidth - width / 2);
  const top = view.y(y) - radius - 1.7 * size;
  context.fillStyle = theme.colors.hit;
  context.fillRect(middle - width / 2, top, width, 1.4 * size);
  context.fillStyle = theme.dark;
  context.fillText(label, middle, top + 0.72 * size);
}

/** Draw the cells of a search in the colours that they have by now, and its ends. */
function drawMarks(context, track, moment, view, theme) {
  const { time, cell, value, colors, ends } = track.marks;
  const now = marksUntil(track, moment.time, { time, cell, value });
  for (const [place, index] of now) {
    context.fillStyle = colors[index];
    context.fillRect(...view.box(place % track.width, Math.floor(place / track.width), 1, 1, 0.03));
  }
  ends.forEach(([row, column], i) => {
    const [x, y, radius] = [view.x(column + 0.5), view.y(row + 0.5), Math.max(8, 0.46 * view.scale)];
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = theme.light;
    context.strokeStyle = theme.dark;
    context.lineWidth = Math.max(1, radius / 8);
    context.fill();
    context.stroke();
    context.fillStyle = theme.dark;
    context.font = `bold ${Math.round(1.3 * radius)}px system-ui, sans-serif`;
    context.textAlign = "center";
    context.textBaseline = "middle";
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

/** Return the cell of a robot's next station: the pickup or the dropoff of its order, or -1. */
export function goalOf(track, robot, step) {
  if (!track.fleet?.orders) return -1;
  const { orders } = track.fleet;
  const order = orderOf(track.fleet, robot, step);
  if (order < 0) return -1;
  const isTaken = orders.taken[order] >= 0 && orders.taken[order] <= step;
  return isTaken ? orders.dropoff[order] : orders.pickup[order];
}

/** Return words on the age of an order. */
export function ageWords(orders, order, step) {
  return ["new", "older", "nearly due", "late"][ageOf(orders, order, step)];
}
