// Draws all that moves, in order, over a floor.

import { drawHits, drawRobots } from "./bodies.js";
import { drawLetters } from "./floor.js";
import { drawHeat } from "./heat.js";
import { drawItem, drawWaiting } from "./items.js";
import { drawEnds, drawMarks, drawSight, drawVisits } from "./layers.js";
import { drawPlans, drawPushes, drawRoute, drawTrail, drawWayAhead } from "./ways.js";

/** Draw everything that moves at a moment. `chosen` and `hovered` are numbers of robots, or `null`. */
export function drawScene(context, track, moment, view, theme, { chosen, hasHeat }, hovered) {
  const watched = chosen ?? (track.robots === 1 && track.bodies > 0 ? 0 : null);
  if (track.marks) drawMarks(context, track, moment, view);
  if (watched !== null) drawVisits(context, track, watched, moment, view, theme);
  if (hasHeat && track.fleet) drawHeat(context, track, moment, view, theme);
  if (watched !== null && !track.isFleet) drawSight(context, track, watched, moment, view, theme);
  drawRoute(context, track, moment, view, theme);
  if (track.fleet) drawPlans(context, track, moment, view, theme);
  if (track.marks) drawEnds(context, track, view, theme);
  if (chosen !== null) drawWayAhead(context, track, chosen, moment, view, theme);
  if (watched !== null) drawTrail(context, track, watched, moment, view, theme);
  drawLetters(context, track, moment, view, theme);
  if (track.fleet) drawWaiting(context, track, moment, view, theme);
  drawRobots(context, track, moment, view, theme, chosen, hovered);
  if (track.robots === 1) drawItem(context, track, moment, view, theme);
  if (track.fleet) drawPushes(context, track, moment, view, theme);
  drawHits(context, track, moment, view, theme);
}
