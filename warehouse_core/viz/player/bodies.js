// Draws robots and people, their batteries, and hits.

import { centerText, drawLabel, fillOutlined, LARGE_TEXT, MIN_TEXT, writeOutlined } from "./canvas.js";
import { drawBox } from "./items.js";

const RADIUS = 0.34;
const MIN_RADIUS = 2;
const MIN_SHAPE = 4;
const MIN_DETAIL = 7;

/** The share of a cell that a number may fill, so that those of neighbours stay apart. */
const MAX_NUMBER = 0.75;

/** Up to so many robots show their batteries; more do only where they are low. */
const FEW = 12;
const LOW_SHARE = 0.25;

/** Draw robots and people. `chosen` and `hovered` are numbers of robots, or `null`. */
export function drawRobots(context, track, moment, view, theme, chosen, hovered) {
  const size = nameSize(context, track, view, theme);
  const radius = Math.max(RADIUS * view.scale, MIN_RADIUS, size && radiusAround(context, track, size));
  const groups = new Map();
  const shown = [];
  for (let body = 0; body < track.bodies; body++) {
    const pose = track.pose(body, moment);
    if (!pose || !view.shows(pose.x, pose.y, 1)) continue;
    const color = colorOf(track, body, pose, moment, theme);
    const [x, y] = [view.x(pose.x), view.y(pose.y)];
    const item = { body, x, y, color, heading: pose.heading, load: pose.load };
    shown.push(item);
    if (!groups.has(color)) groups.set(color, []);
    groups.get(color).push(item);
  }
  if (radius >= MIN_DETAIL) drawNoses(context, shown, radius, theme);
  for (const [color, items] of groups) {
    if (radius < MIN_SHAPE) {
      // Squares: a browser fills a path of a thousand circles slowly.
      context.fillStyle = color;
      for (const { x, y } of items) context.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
      continue;
    }
    context.beginPath();
    for (const { body, x, y } of items) outline(context, x, y, radius, body >= track.robots);
    fillOutlined(context, color, theme.rim, Math.max(1, radius / 8));
  }
  drawItems(context, shown, track, radius, theme, size || radius >= MIN_DETAIL);
  drawBatteries(context, shown, track, moment, radius, theme);
  if (size) drawNames(context, shown, track, size, theme);
  const mine = shown.find((item) => item.body === chosen);
  if (mine) drawRing(context, mine, radius, theme);
  if (size || !track.isFleet) return;
  for (const { body, x, y } of shown) {
    if (body !== chosen && body !== hovered) continue;
    const bottom = y - 2 * radius - 4 * theme.density;
    drawLabel(context, String(body), x, bottom, MIN_TEXT * theme.density, [theme.dark, theme.light]);
  }
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

export function colorOf(track, body, pose, moment, theme) {
  if (body >= track.robots) return theme.person;
  if (track.fleet && track.batteryLevel(body, moment.frame) <= 0) return theme.stranded;
  return theme[pose.load > 0 ? "loaded" : "robot"];
}

/** Draw the nose of each robot that has a heading: a wedge at its rim. */
function drawNoses(context, shown, radius, theme) {
  context.fillStyle = theme.rim;
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
function drawItems(context, shown, track, radius, theme, isBeside) {
  const side = Math.max(2, (track.isFleet ? 0.85 : 1.2) * radius);
  for (const { x, y, load } of shown) {
    if (load <= 0) continue;
    // The number of a robot of a fleet stays readable beside its item.
    const away = track.isFleet && isBeside ? 0.8 * radius : 0;
    const color = track.isFleet ? theme.orders[load - 1] : theme.item;
    drawBox(context, x + away, y - away, side, color, theme);
  }
}

/** Draw a bar below each robot whose battery is low, or of a few robots below each. */
function drawBatteries(context, shown, track, moment, radius, theme) {
  if (!track.fleet || radius < MIN_SHAPE) return;
  const [length, height] = [2 * radius, Math.max(2, 0.3 * radius)];
  for (const { body, x, y } of shown) {
    if (body >= track.robots) continue;
    const level = track.batteryLevel(body, moment.frame);
    if (level >= (track.robots > FEW ? LOW_SHARE : 1)) continue;
    const [left, top] = [x - radius, y + 0.8 * radius];
    context.fillStyle = theme.dark;
    context.fillRect(left - 1, top - 1, length + 2, height + 2);
    context.fillStyle = theme.light;
    context.fillRect(left, top, length, height);
    context.fillStyle = level < LOW_SHARE ? theme.warning : theme.battery;
    context.fillRect(left, top, level * length, height);
  }
}

/** Return the longest number of a robot. */
function longestName(track) {
  return "8".repeat(track.robots > 1 ? String(track.robots - 1).length : 1);
}

/** Return the size of the letters and numbers on bodies, or 0 if cells have no room for them. */
function nameSize(context, track, view, theme) {
  const name = longestName(track);
  const fitting = Math.min(1.1, 2 / name.length) * RADIUS * view.scale;
  const size = Math.max(fitting, MIN_TEXT * theme.density);
  centerText(context, size);
  return context.measureText(name).width <= MAX_NUMBER * view.scale ? size : 0;
}

/** Return the radius of a disc that holds the longest number: small robots grow around theirs. */
function radiusAround(context, track, size) {
  return Math.hypot(context.measureText(longestName(track)).width, 0.75 * size) / 2 + 1;
}

function drawNames(context, shown, track, size, theme) {
  const isLarge = size >= LARGE_TEXT * theme.density;
  centerText(context, size);
  for (const { body, x, y, color, load } of shown) {
    const isPerson = body >= track.robots;
    const name = isPerson ? "H" : track.robots > 1 ? String(body) : load > 0 ? "r" : "R";
    const place = [name, x, y + 0.06 * size];
    const isDark = color === theme.loaded;
    context.fillStyle = isDark ? theme.dark : theme.light;
    if (isDark || isLarge) context.fillText(...place);
    else writeOutlined(context, ...place, [theme.light, theme.dark], theme.density);
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

export function drawHits(context, track, moment, view, theme) {
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
    fillOutlined(context, theme.hit, theme.dark, Math.max(1, radius / 10));
  }
  const last = hits.at(-1);
  if (!last?.label) return;
  const size = Math.max(12 * theme.density, 0.3 * view.scale);
  const bottom = view.y(last.y) - radius - 0.3 * size;
  drawLabel(context, last.label, view.x(last.x), bottom, size, [theme.hit, theme.dark]);
}
