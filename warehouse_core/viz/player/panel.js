// One track on the page: its floor, the action of the robot with its reason, its battery and its ending.

import { drawArrows, drawGhost, drawHits, drawItems, drawRobots, drawThings } from "./bodies.js";
import { Brush, kept } from "./canvas.js";
import { copy, element, partOf, setText } from "./elements.js";
import { drawEnds, drawFloor, drawLetters, drawMarks, drawSight, drawVisits } from "./floor.js";
import { seconds, shown } from "./scale.js";
import { drawAhead, drawPlans, drawPushes, drawRoute, drawSkids, drawTrail } from "./paths.js";

const TAP = 6;
const LOW = 0.2;

export class Panel {
  /** Args: a `Track`, its title, the `View` that it shares with other panels, and the `Player` of the page. */
  constructor(track, title, view, player) {
    Object.assign(this, { track, view, player });
    this.element = copy("panel-template");
    const names = ["title", "floor", "caption", "ending", "battery", "level", "units", "facts"];
    this.parts = Object.fromEntries(names.map((name) => [name, partOf(this.element, name)]));
    this.parts.title.textContent = title;
    this.parts.battery.hidden = !track.battery.length;
    this.parts.facts.hidden = !this.factsAt(track.at(0));
    this.canvas = this.parts.floor;
    this.canvas.style.aspectRatio = view.aspect;
    this.listen();
  }

  /** Draw the panel at a time, in the colours of a theme. */
  draw(time, theme) {
    const moment = this.track.at(time);
    this.drawFloor(moment, theme);
    this.say(moment);
  }

  drawFloor(moment, theme) {
    const { clientWidth, clientHeight } = this.canvas;
    const size = [clientWidth, clientHeight].map((pixels) => Math.round(pixels * theme.density));
    if (size.includes(0)) return;
    if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) {
      [this.canvas.width, this.canvas.height] = size;
    }
    const { track, view } = this;
    view.place(...size, theme.density);
    const index = track.tileAt[moment.frame];
    const key = `${view.key} ${index} ${theme.key}`;
    const still = kept(this, "still", key, () => this.drawStill(track.tiles[index], theme));
    const context = this.canvas.getContext("2d");
    context.drawImage(still, 0, 0);
    this.drawMoving(new Brush(context, view, theme), moment);
  }

  /** Return a canvas with everything that does not move. */
  drawStill(tiles, theme) {
    const { width, height } = this.canvas;
    const still = element("canvas", { width, height });
    const brush = new Brush(still.getContext("2d", { alpha: false }), this.view, theme);
    brush.rect("paper", 0, 0, width, height);
    drawFloor(brush, this.track, tiles);
    return still;
  }

  /** Draw everything that changes, from the lowest to the highest. */
  drawMoving(brush, moment) {
    const { track, player } = this;
    const { chosen } = player;
    const watched = chosen ?? (track.robots === 1 && track.bodies > 0 ? 0 : null);
    if (track.marks) drawMarks(brush, track, moment);
    if (watched !== null) drawVisits(brush, track, watched, moment);
    if (watched !== null && !track.isFleet) drawSight(brush, track, watched, moment);
    drawRoute(brush, track, moment);
    if (track.fleet) drawPlans(brush, track, moment);
    if (track.marks) drawEnds(brush, track);
    if (chosen !== null) drawAhead(brush, track, chosen, moment);
    if (watched !== null) drawTrail(brush, track, watched, moment);
    for (let body = 0; track.slippery.length && body < track.robots; body++) drawSkids(brush, track, body, moment);
    drawLetters(brush, track, moment);
    drawThings(brush, track, moment, player.hasArrows);
    drawGhost(brush, track, moment);
    if (track.fleet) drawItems(brush, track, moment);
    if (player.hasArrows) drawArrows(brush, track, moment);
    drawRobots(brush, track, moment, chosen);
    if (!track.fleet) drawItems(brush, track, moment);
    if (track.fleet) drawPushes(brush, track, moment);
    drawHits(brush, track, moment);
  }

  say(moment) {
    const { track, parts } = this;
    const caption = track.caption(moment);
    const isOver = moment.frame === track.frames - 1;
    setText(parts.caption, caption || (moment.frame === 0 ? "ready" : ""));
    setText(parts.ending, isOver ? track.ending : "");
    parts.ending.hidden = !isOver || !track.ending;
    const place = this.player.describe(track, moment);
    if (place !== this.place) this.canvas.setAttribute("aria-label", place);
    this.place = place;
    setText(parts.facts, this.factsAt(moment));
    if (!track.battery.length) return;
    const left = track.battery[moment.step];
    const level = Math.min(Math.max(left / track.fullBattery, 0), 1) || 0;
    parts.level.style.width = `${100 * level}%`;
    parts.battery.classList.toggle("low", level < LOW);
    const warning = level >= LOW ? "" : level > 0 ? " low!" : " empty!";
    setText(parts.units, `battery ${shown(left)} of ${shown(track.fullBattery)}${warning}`);
  }

  /**
   * Return the time and energy so far, and the strength of weak motors. The grid has no time and energy
   * of its own, which dashes show next to bodies.
   */
  factsAt({ time, frame }) {
    const { end, energy, isMeasured, motorStrength } = this.track;
    const facts = [];
    if (isMeasured) facts.push(seconds(Math.min(time, end)), `${shown(energy[frame], 0)} J`);
    else if (this.player.tracks.some((track) => track.isMeasured)) facts.push("\u2013 s", "\u2013 J");
    if (motorStrength < 1) facts.push(`motors at ${shown(100 * motorStrength, 0)}% of their force`);
    return facts.join(", ");
  }

  /** Let the pointer pan and zoom the floor, and choose a robot of a fleet. */
  listen() {
    const pointers = new Map();
    let moved = 0;
    const at = (event) => [event.offsetX, event.offsetY].map((part) => part * this.player.density);
    this.canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, at(event));
      if (pointers.size === 1) moved = 0;
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const [before, now] = [pointers.get(event.pointerId), at(event)];
      if (!before) return;
      const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
      if (other) this.view.zoomBy(distance(now, other) / Math.max(distance(before, other), 1), ...other);
      else if (this.view.zoom > 1) this.view.moveBy(now[0] - before[0], now[1] - before[1]);
      moved += distance(before, now);
      pointers.set(event.pointerId, now);
      this.player.draw();
    });
    const end = (event) => {
      const isTap = pointers.size === 1 && moved < TAP * this.player.density;
      if (pointers.delete(event.pointerId) && isTap && event.type === "pointerup") this.tap(...at(event));
    };
    this.canvas.addEventListener("pointerup", end);
    this.canvas.addEventListener("pointercancel", end);
    this.canvas.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        this.view.zoomBy(1.2 ** -Math.sign(event.deltaY), ...at(event));
        this.player.draw();
      },
      { passive: false },
    );
  }

  /** Choose the robot of a fleet at a point, or no robot. */
  tap(x, y) {
    if (this.track.isFleet) this.player.choose(this.robotAt(x, y, this.track.at(this.player.time)));
  }

  /** Return the robot nearest to a point, or `null` if no robot is close. */
  robotAt(x, y, moment) {
    const [column, row] = this.view.cellAt(x, y);
    let [nearest, least] = [null, Math.max(0.8, (10 * this.player.density) / this.view.scale)];
    for (let robot = 0; robot < this.track.robots; robot++) {
      const pose = this.track.pose(robot, moment);
      const away = pose ? Math.hypot(pose.x - column, pose.y - row) : Infinity;
      if (away < least) [nearest, least] = [robot, away];
    }
    return nearest;
  }
}

function distance([x, y], [otherX, otherY]) {
  return Math.hypot(x - otherX, y - otherY);
}
