// Draws the ways of robots: trails, planned ways, and who pushes whom.

import { fillOutlined } from "./canvas.js";
import { colorOf } from "./bodies.js";

const TRAIL_STEPS = 40;
const TRAIL_SHADES = 8;
const WAY_STEPS = 20;

/** Draw the way of a robot in its last steps, the older the paler, dashed where it was loaded. */
export function drawTrail(context, track, body, moment, view, theme) {
  const { step } = moment;
  const oldest = track.stepFrames[Math.max(0, step - TRAIL_STEPS)];
  const lines = [];
  let before = track.pose(body, { frame: oldest });
  for (let frame = oldest + 1; frame <= moment.frame + 1; frame++) {
    const after = track.pose(body, frame > moment.frame ? moment : { frame });
    if (before && after && (before.x !== after.x || before.y !== after.y)) {
      const age = step - track.progress[Math.min(frame, moment.frame)];
      const shade = Math.ceil(TRAIL_SHADES * (1 - age / (TRAIL_STEPS + 1)));
      addToLine(lines, before, after, Math.min(shade, TRAIL_SHADES));
    }
    before = after;
  }
  context.lineCap = "butt";
  context.lineJoin = "round";
  context.lineWidth = Math.max(1.5 * theme.density, view.scale / 11);
  for (const { points, shade, isLoaded, length } of lines) {
    context.globalAlpha = 0.2 + (0.7 * shade) / TRAIL_SHADES;
    context.strokeStyle = theme[isLoaded ? "loaded" : "robot"];
    context.setLineDash(isLoaded ? [view.scale / 5, view.scale / 5] : []);
    context.lineDashOffset = length * view.scale;
    strokeLine(context, points, view);
  }
  context.globalAlpha = 1;
  context.setLineDash([]);
}

/** Add a segment to the last of some lines, or begin another one if it looks different. */
function addToLine(lines, before, after, shade) {
  const isLoaded = before.load > 0;
  const last = lines.at(-1);
  const drawn = last ? last.length + lengthOf(last.points) : 0;
  if (last?.shade !== shade || last.isLoaded !== isLoaded) {
    lines.push({ points: [[before.x, before.y]], shade, isLoaded, length: drawn });
  }
  lines.at(-1).points.push([after.x, after.y]);
}

function lengthOf(points) {
  let sum = 0;
  for (let i = 1; i < points.length; i++) {
    sum += Math.hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]);
  }
  return sum;
}

function strokeLine(context, points, view) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(view.x(x), view.y(y));
  context.stroke();
}

/** Draw a planned way as dots, and the path that a search has found as a line. */
export function drawRoute(context, track, moment, view, theme) {
  const points = track.routeIn(moment.frame);
  if (!points.length) return;
  if (!track.marks) {
    drawDots(context, points, view, theme.ink);
    return;
  }
  context.lineJoin = "round";
  for (const [color, width] of [[theme.light, 0.42], [theme.warning, 0.24]]) {
    context.strokeStyle = color;
    context.lineWidth = Math.max(3, width * view.scale);
    strokeLine(context, points, view);
  }
}

/** Draw where a chosen robot drives next, as dots. */
export function drawWayAhead(context, track, body, moment, view, theme) {
  const points = [];
  const step = track.stepAt(moment.time);
  for (const frame of track.stepFrames.slice(step, step + WAY_STEPS)) {
    const pose = track.pose(body, { frame });
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

export function drawPlans(context, track, moment, view, theme) {
  context.lineCap = "round";
  context.lineJoin = "round";
  for (const { robot, isWish, cells } of plansOf(track).get(moment.frame)?.lines ?? []) {
    const pose = track.pose(robot, moment);
    context.strokeStyle = colorOf(track, robot, pose, moment, theme);
    context.lineWidth = Math.max(2, view.scale / (isWish ? 8 : 5));
    context.setLineDash(isWish ? [0.1, view.scale / 3] : []);
    const places = Array.from(cells, (cell) => track.rowAndColumn(cell));
    strokeLine(context, places.map(([row, column]) => [column + 0.5, row + 0.5]), view);
  }
  context.setLineDash([]);
}

/** Draw an arrow from each robot that pushes to the one that it pushes. */
export function drawPushes(context, track, moment, view, theme) {
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
    fillOutlined(context, theme.dark, theme.light, 1);
  }
}
