// Draws robots and people, items, and hits.

import LOOK from "../../render/tiles.json" with { type: "json" };
import { LARGE_TEXT } from "./canvas.js";

const { radius: RADIUS, rim: RIM, letter: LETTER, name: NAME } = LOOK.robot;
const MIN_RADIUS = 2;
const MIN_SHAPE = 4;
const MIN_DETAIL = 7;

/** The radius in pixels from which on a body has a chassis; a smaller one is a disc. */
const MIN_BODY = 8;
const ARROWS = LOOK.arrows;

/** The share of a cell that a number may fill, so that numbers of neighbours stay apart. */
const MAX_NUMBER = 0.75;

/** In fleets of more than `FEW` robots, only batteries below `LOW_SHARE` are shown. */
const { few: FEW, low: LOW_SHARE, top: BAR_TOP, height: BAR_HEIGHT } = LOOK.battery;

const { side: SIDE, place: PLACE, line: LINE, tape: TAPE } = LOOK.item;
const MIN_SIDE = 4;

/** Draw the robots and people. `chosen` is the number of a robot, or `null`. */
export function drawRobots(brush, track, moment, chosen) {
  const size = nameSize(brush, track);
  const radius = Math.max(RADIUS * brush.scale, MIN_RADIUS, size && radiusAround(brush, track, size));
  const pixels = radius / RADIUS;
  const shown = bodiesIn(brush.view, track, moment);
  const hasDetail = radius >= MIN_DETAIL;
  const isBody = track.isContinuous && radius >= MIN_BODY;
  drawBatteries(brush, shown, track, moment, radius);
  if (isBody) drawUndercarriages(brush, shown, track, moment, pixels);
  if (hasDetail) drawNoses(brush, isBody ? shown.filter(({ isPerson }) => isPerson) : shown, radius);
  drawBodies(brush, shown, radius, isBody);
  for (const { x, y, load } of shown) {
    // The item of a single robot on the grid has the letter of the robot on it.
    const side = isBody ? LOOK.carried.side * pixels : Math.max(2, SIDE * pixels, 0.8 * size);
    if (load > 0 && !track.isFleet) drawBox(brush, x, y, side, "item");
    else if (load > 0) drawCarried(brush, x, y, load, pixels, size || hasDetail);
  }
  if (size && (track.robots > 1 || !isBody)) drawNames(brush, shown, track, size);
  const mine = shown.find((item) => item.body === chosen);
  if (!mine) return;
  drawRing(brush, mine, radius);
  const bottom = mine.y - 2 * radius - 4 * brush.theme.density;
  if (!size) brush.label("dark", "light", String(chosen), mine.x, bottom, brush.minText);
}

/** Return the position, colour, heading and load of each visible body. */
function bodiesIn(view, track, moment) {
  const shown = [];
  for (let body = 0; body < track.bodies; body++) {
    const pose = track.pose(body, moment);
    if (!pose || !view.shows(pose.x, pose.y, 1)) continue;
    const [x, y, color] = [view.x(pose.x), view.y(pose.y), colorOf(track, body, pose, moment)];
    shown.push({ body, x, y, color, heading: pose.heading, load: pose.load, isPerson: body >= track.robots });
  }
  return shown;
}

/** Return the name of the colour of a body. */
export function colorOf(track, body, pose, moment) {
  if (body >= track.robots) return "person";
  if (track.fleet && track.batteryLevel(body, moment.frame) <= 0) return "stranded";
  return pose.load > 0 ? "loaded" : "robot";
}

/** Draw the discs or chassis of robots and the diamonds of people, one path for each colour. */
function drawBodies(brush, shown, radius, isBody) {
  const pixels = radius / RADIUS;
  for (const color of new Set(shown.map((item) => item.color))) {
    const items = shown.filter((item) => item.color === color);
    if (radius < MIN_SHAPE) {
      // Small bodies are squares, because browsers are slow to fill a path of a thousand circles.
      for (const { x, y } of items) brush.rect(color, x - radius, y - radius, 2 * radius, 2 * radius);
      continue;
    }
    brush.begin(color);
    for (const { x, y, heading, isPerson } of items) {
      if (isPerson) brush.trace("H", x, y, pixels);
      else if (isBody) brush.trace("chassis", x, y, pixels, heading ?? 0);
      else brush.circle(x, y, radius);
    }
    brush.paint(color, "rim", Math.max(1, RIM * pixels));
  }
  if (isBody) traceRobots(brush, shown, "front", pixels, "light", "rim");
}

/** Draw a shape of each robot that heads somewhere, in one path. */
function traceRobots(brush, shown, name, pixels, color, lineColor) {
  brush.begin(color);
  for (const { x, y, heading, isPerson } of shown) {
    if (!isPerson) brush.trace(name, x, y, pixels, heading ?? 0);
  }
  brush.paint(color, lineColor, Math.max(1, (RIM / 2) * pixels));
}

/** Draw what is below a chassis: two wheels or a ring, and the brake light. */
function drawUndercarriages(brush, shown, track, moment, pixels) {
  brush.begin("rim");
  for (const { x, y, heading, isPerson } of shown) {
    if (isPerson) continue;
    for (const corners of LOOK.drives[track.drive] ?? []) brush.outline(corners, x, y, pixels, heading ?? 0);
  }
  brush.context.fill();
  const braking = shown.filter(({ body, isPerson }) => !isPerson && track.push(body, moment)?.brakes);
  traceRobots(brush, braking, "brake", pixels, "brake", "light");
}

/** Draw arrows for the forces and the velocities of bodies, from their centres. */
export function drawArrows(brush, track, moment) {
  if (RADIUS * brush.scale < MIN_BODY) return;
  for (const [name, wide] of [["force", ARROWS.wide], ["velocity", 1]]) {
    for (const { body, x, y } of bodiesIn(brush.view, track, moment)) {
      const [right, down] = track.push(body, moment)?.[name] ?? [0, 0];
      const length = ARROWS[name] * Math.hypot(right, down);
      if (length < ARROWS.shortest) continue;
      const tip = Math.min(ARROWS.start + length, ARROWS.longest) * brush.scale;
      drawArrow(brush, name, x, y, Math.atan2(down, right), tip, wide);
    }
  }
}

function drawArrow(brush, color, x, y, angle, tip, wide) {
  const { context, scale, theme } = brush;
  const [toX, toY] = [x + tip * Math.cos(angle), y + tip * Math.sin(angle)];
  const width = LOOK.lines.arrow * wide * scale;
  context.lineCap = "butt";
  for (const [style, edge] of [[theme.paper, RIM * scale], [theme[color], 0]]) {
    Object.assign(context, { strokeStyle: style, lineWidth: width + edge });
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(toX, toY);
    context.stroke();
    brush.begin(color);
    brush.trace("arrow", toX, toY, wide * scale, angle);
    brush.paint(color, "paper", edge || 0.1);
  }
}

/** Draw the nose of each robot that has a heading: a wedge at its rim. */
function drawNoses(brush, shown, radius) {
  brush.begin("rim");
  for (const { x, y, heading } of shown) {
    if (heading !== null) brush.trace("nose", x, y, radius / RADIUS, heading);
  }
  brush.context.fill();
}

/** Draw the item of a robot of a fleet in the colour of its order's age, either next to its number or on it. */
function drawCarried(brush, x, y, load, pixels, isNextToNumber) {
  const away = isNextToNumber ? LOOK.carried.away * pixels : 0;
  drawBox(brush, x + away, y - away, Math.max(2, LOOK.carried.side * pixels), brush.theme.orders[load - 1]);
}

/** Draw the battery below each robot; in large fleets only below robots with a low battery. */
function drawBatteries(brush, shown, track, moment, radius) {
  if (!track.fleet || radius < MIN_SHAPE) return;
  const pixels = radius / RADIUS;
  const [length, height] = [2 * radius, Math.max(2, BAR_HEIGHT * pixels)];
  for (const { body, x, y, isPerson } of shown) {
    if (isPerson) continue;
    const level = track.batteryLevel(body, moment.frame);
    if (level >= (track.robots > FEW ? LOW_SHARE : 1)) continue;
    const [left, top] = [x - radius, y + BAR_TOP * pixels];
    brush.rect("dark", left - 1, top - 1, length + 2, height + 2);
    brush.rect("light", left, top, length, height);
    brush.rect(level < LOW_SHARE ? "warning" : "battery", left, top, level * length, height);
  }
}

/** Return a text as wide as the longest number of a robot. */
function longestName(track) {
  return "8".repeat(track.robots > 1 ? String(track.robots - 1).length : 1);
}

/** Return the size of the letters and numbers on bodies, or 0 if they do not fit into cells. */
function nameSize(brush, track) {
  const name = longestName(track);
  const size = Math.max(Math.min(LETTER, NAME / name.length) * brush.scale, brush.minText);
  brush.centerText(size);
  return brush.widthOf(name) <= MAX_NUMBER * brush.scale ? size : 0;
}

/** Return the radius of a disc around the longest number; small robots are enlarged to it. */
function radiusAround(brush, track, size) {
  return Math.hypot(brush.widthOf(longestName(track)), 0.75 * size) / 2 + 1;
}

function drawNames(brush, shown, track, size) {
  const isLarge = size >= LARGE_TEXT * brush.theme.density;
  brush.centerText(size);
  for (const { body, x, y, color, load, isPerson } of shown) {
    const name = isPerson ? "H" : track.robots > 1 ? String(body) : load > 0 ? "r" : "R";
    const place = [name, x, y + 0.06 * size];
    const isDark = color === "loaded";
    if (isDark || isLarge) brush.write(isDark ? "dark" : "light", ...place);
    else brush.writeOutlined("light", "dark", ...place);
  }
}

function drawRing({ context, theme }, { x, y }, radius) {
  for (const [strokeStyle, width] of [[theme.light, 5], [theme.accent, 3]]) {
    Object.assign(context, { strokeStyle, lineWidth: width * theme.density });
    context.beginPath();
    context.arc(x, y, Math.max(radius * 1.5, 8 * theme.density), 0, 2 * Math.PI);
    context.stroke();
  }
}

/** Draw where the robot of another track is. */
export function drawGhost({ context, view, scale, theme }, { ghost }, { frame }) {
  if (!ghost.x.length) return;
  Object.assign(context, { strokeStyle: theme.ink, lineWidth: Math.max(theme.density, RIM * scale), lineCap: "butt" });
  context.setLineDash([3, 2].map((part) => part * context.lineWidth));
  context.beginPath();
  context.arc(view.x(ghost.x[frame]), view.y(ghost.y[frame]), RADIUS * scale, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
}

/** Draw the rays of a range scan, if they are wanted, and the outlines of the things around a robot. */
export function drawThings({ context, view, scale, theme }, { lines, frames }, { frame }, hasRays) {
  if (!lines) return;
  for (const isRay of hasRays ? [false, true] : [false]) {
    const lineWidth = Math.max(0.7 * theme.density, LOOK.lines[isRay ? "ray" : "outline"] * scale);
    Object.assign(context, { strokeStyle: theme.ink, lineWidth, lineCap: "butt" });
    context.setLineDash(isRay ? [lineWidth, 2 * lineWidth] : []);
    context.beginPath();
    for (let line = 0, at = frame; line < lines.isRay.length; line++, at += frames) {
      if (lines.isRay[line] !== isRay) continue;
      context.moveTo(view.x(lines.x[at]), view.y(lines.y[at]));
      context.lineTo(view.x(lines.toX[at]), view.y(lines.toY[at]));
    }
    context.stroke();
  }
  context.setLineDash([]);
}

/** Draw the items that lie on the floor: orders that wait, with their number if it fits, or a single item. */
export function drawItems(brush, track, moment) {
  const side = Math.max(MIN_SIDE, SIDE * brush.scale);
  const size = Math.max(0.7 * side, brush.minText);
  for (const { cell, count, age } of track.waitingAt(moment.step) ?? lyingItems(track, moment)) {
    const [row, column] = track.rowAndColumn(cell);
    const [x, y] = [brush.view.x(column + PLACE), brush.view.y(row + PLACE)];
    drawBox(brush, x, y, side, brush.theme.orders[age]);
    brush.centerText(size);
    if (count < 2 || Math.max(brush.widthOf(String(count)), size) > side) continue;
    brush.write(age === LOOK.ages.length - 1 ? "light" : "dark", String(count), x, y + 0.06 * size);
  }
}

/** Return the items of a single robot: where they wait, or where the last one has been dropped. */
function lyingItems(track, moment) {
  if (track.robots !== 1 || track.load[moment.frame] !== 0) return [];
  const tiles = [...track.tiles[track.tileAt[moment.frame]]];
  let cells = tiles.flatMap((tile, cell) => (tile === "P" ? [cell] : []));
  for (let frame = moment.frame; frame > 0; frame--) {
    if (!track.isLoaded(0, frame - 1)) continue;
    cells = [track.cell(0, frame)];
    break;
  }
  return cells.map((cell) => ({ cell, count: 1, age: 0 }));
}

/** Draw an item, a box with a strip of tape, around its centre. */
function drawBox(brush, x, y, side, color) {
  const [left, top, whole] = [x - side / 2, y - side / 2, side].map(Math.round);
  if (whole < 5) {
    brush.rect("dark", left, top, whole, whole);
    return;
  }
  const line = Math.max(1, Math.round((LINE / SIDE) * whole));
  brush.rect("light", left - line, top - line, whole + 2 * line, whole + 2 * line);
  brush.rect("dark", left, top, whole, whole);
  brush.rect(color, left + line, top + line, whole - 2 * line, whole - 2 * line);
  brush.rect("dark", left + Math.round((whole - line) / 2), top, line, Math.round((TAPE / SIDE) * whole));
}

export function drawHits(brush, track, moment) {
  const { view, scale, theme } = brush;
  const hits = track.hitsIn(moment.frame);
  const pixels = Math.max(20, scale * (track.robots > 1 ? 0.7 : 1));
  for (const { x, y, size } of hits) {
    brush.begin("hit");
    brush.trace("hit", view.x(x), view.y(y), pixels * size);
    brush.paint("hit", "dark", Math.max(1, pixels / 40));
  }
  const last = hits.at(-1);
  if (!last?.label) return;
  const size = Math.max(12 * theme.density, 0.3 * scale);
  brush.label("hit", "dark", last.label, view.x(last.x), view.y(last.y) - (pixels * last.size) / 4 - 0.3 * size, size);
}
