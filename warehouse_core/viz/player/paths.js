// Draws the trails and the planned paths of robots, and arrows from robots to those that they push.

import LOOK from "../../render/tiles.json" with { type: "json" };
import { colorOf } from "./bodies.js";

const { trail: { steps: TRAIL_STEPS }, lines: LINES } = LOOK;
const TRAIL_SHADES = 8;
const STEPS_AHEAD = 20;

/** Draw the trail of a robot in its last steps. Older parts are paler, and loaded parts are dashed. */
export function drawTrail(brush, track, body, moment) {
  const { context, scale, theme } = brush;
  const width = Math.max(1.5 * theme.density, scale * LINES.trail);
  context.lineCap = "butt";
  for (const { places, shade, isLoaded, length } of trailOf(track, body, moment)) {
    context.globalAlpha = 0.2 + (0.7 * shade) / TRAIL_SHADES;
    context.setLineDash(isLoaded ? [scale / 5, scale / 5] : []);
    context.lineDashOffset = length * scale;
    brush.line(isLoaded ? "loaded" : "robot", width, places);
  }
  context.globalAlpha = 1;
  context.setLineDash([]);
}

/** Return the trail of a robot as lines of one style each, with the total length of earlier lines. */
function trailOf(track, body, moment) {
  const { step } = moment;
  const oldest = track.stepFrames[Math.max(0, step - TRAIL_STEPS)];
  const lines = [];
  let length = 0;
  let before = track.pose(body, { frame: oldest });
  for (let frame = oldest + 1; frame <= moment.frame + 1; frame++) {
    const after = track.pose(body, frame > moment.frame ? moment : { frame });
    if (before && after && (before.x !== after.x || before.y !== after.y)) {
      const age = step - track.progress[Math.min(frame, moment.frame)];
      const shade = Math.min(Math.ceil(TRAIL_SHADES * (1 - age / (TRAIL_STEPS + 1))), TRAIL_SHADES);
      const isLoaded = before.load > 0;
      if (lines.at(-1)?.shade !== shade || lines.at(-1).isLoaded !== isLoaded) {
        lines.push({ places: [[before.x, before.y]], shade, isLoaded, length });
      }
      lines.at(-1).places.push([after.x, after.y]);
      length += Math.hypot(after.x - before.x, after.y - before.y);
    }
    before = after;
  }
  return lines;
}

/** Draw the skid marks of a body so far: a line on each side of its path. */
export function drawSkids(brush, track, body, moment) {
  const { context, view, scale } = brush;
  const { apart, width } = LOOK.skid;
  brush.begin("dark");
  for (let frame = 1; frame <= moment.frame && track.skid.length; frame++) {
    if (!track.skid[body * track.frames + frame]) continue;
    const [before, after] = [frame - 1, frame].map((each) => track.pose(body, { frame: each }));
    const [right, down] = [before.y - after.y, after.x - before.x];
    const share = apart / Math.max(Math.hypot(right, down), 1e-9);
    for (const side of [-share, share]) {
      context.moveTo(view.x(before.x + side * right), view.y(before.y + side * down));
      context.lineTo(view.x(after.x + side * right), view.y(after.y + side * down));
    }
  }
  Object.assign(context, { lineWidth: width * scale, globalAlpha: 0.5, lineCap: "butt" });
  context.stroke();
  context.globalAlpha = 1;
}

/** Draw a planned path as dots, and the path that a search has found as a line. */
export function drawRoute(brush, track, moment) {
  const places = track.routeIn(moment.frame);
  if (!track.marks) drawDots(brush, places, "ink");
  else if (places.length) {
    brush.line("light", Math.max(3, 0.42 * brush.scale), places);
    brush.line("warning", Math.max(3, 0.24 * brush.scale), places);
  }
}

/** Draw the next steps of a chosen robot, as dots. */
export function drawAhead(brush, track, body, moment) {
  const step = track.stepAt(moment.time);
  const poses = track.stepFrames.slice(step, step + STEPS_AHEAD).map((frame) => track.pose(body, { frame }));
  drawDots(brush, poses.filter(Boolean).map(({ x, y }) => [x, y]), "accent");
}

function drawDots(brush, places, color) {
  const { context, view } = brush;
  const radius = Math.max(1.2, (LINES.route / 2) * view.scale);
  brush.begin(color);
  places.forEach(([x, y], i) => {
    const [nextX, nextY] = places[i + 1] ?? places[i];
    for (const between of [0, 0.5]) {
      brush.circle(view.x(x + between * (nextX - x)), view.y(y + between * (nextY - y)), radius);
    }
  });
  context.fill();
}

/** Draw the planned paths of a fleet as lines, and from their ends the shortest paths to the goals as dots. */
export function drawPlans(brush, track, moment) {
  const { context, scale } = brush;
  context.lineCap = "round";
  for (const { robot, isWish, cells } of track.plansIn(moment.frame)) {
    const color = colorOf(track, robot, track.pose(robot, moment), moment);
    context.setLineDash(isWish ? [0.1, scale / 3] : []);
    const places = Array.from(cells, (cell) => track.rowAndColumn(cell));
    const width = Math.max(2, scale * LINES[isWish ? "wish" : "plan"]);
    brush.line(color, width, places.map(([row, column]) => [column + 0.5, row + 0.5]));
  }
  context.setLineDash([]);
}

/** Draw an arrow from each robot that pushes another one. */
export function drawPushes(brush, track, moment) {
  const pixels = Math.max(brush.scale, 14);
  for (const [pusher, robot] of track.pushesIn(moment.frame)) {
    const [from, to] = [track.pose(pusher, moment), track.pose(robot, moment)];
    const angle = Math.atan2(to.y - from.y, to.x - from.x);
    const [x, y] = [brush.view.x((from.x + to.x) / 2), brush.view.y((from.y + to.y) / 2)];
    brush.begin("dark");
    brush.trace("push", x, y, pixels, angle);
    brush.paint("dark", "light", 1);
  }
}
