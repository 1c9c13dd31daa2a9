// The page: one clock, and everything that is drawn for the time of this clock.

import { readTheme, View } from "./canvas.js";
import { Chart } from "./charts.js";
import { partOf } from "./elements.js";
import { FleetPanel } from "./fleet.js";
import { drawLegend } from "./legend.js";
import { Panel } from "./panel.js";
import { seconds, shown } from "./scale.js";
import { nextEvent, Track } from "./track.js";

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16];

/** Most milliseconds by which one picture advances the clock, so that a hidden page does not run on. */
const MAX_TICK = 1000;

/** The margin around a floor, in cells. */
const MARGIN = 0.1;

/** The ratio of width to height above which a floor is larger above the charts than next to them. */
const WIDE = 2.1;

/** The number of columns of floors, by the number of tracks. */
const COLUMNS = { 1: 1, 2: 2, 4: 2 };
const MAX_COLUMNS = 3;

const MAX_NAME = 16;
const LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";

const WORDS = { hit: "collision", pick: "item picked up", drop: "item delivered" };

/** Return the words in which titles differ, or letters if these words are too long. */
export function shortNames(titles) {
  const lines = titles.map((title) => title.split(" "));
  const least = Math.min(...lines.map((line) => line.length));
  const areSame = (place) => lines.every((line) => line.at(place) === lines[0].at(place));
  let [first, last] = [0, 0];
  while (first < least && areSame(first)) first++;
  while (last < least - first && areSame(-1 - last)) last++;
  const names = lines.map((line) => line.slice(first, line.length - last).join(" "));
  const areShort = names.every((name) => name && name.length <= MAX_NAME);
  return areShort ? names : titles.map((_, i) => LETTERS[i]);
}

export class Player {
  /** Args: the decoded data of a page, and the element that it is shown in. */
  constructor(data, root) {
    this.root = root;
    this.rate = data.rate;
    this.unit = data.unit;
    this.legend = data.legend;
    this.speed = SPEEDS.reduce((best, speed) =>
      Math.abs(Math.log(speed / data.speed)) < Math.abs(Math.log(best / data.speed)) ? speed : best,
    );
    this.tracks = data.tracks.map((track) => new Track(track));
    this.end = Math.max(...this.tracks.map((track) => track.end));
    this.longest = this.tracks.find((track) => track.end === this.end);
    this.time = Math.min(data.opensAt ?? 0, this.end);
    this.isPlaying = false;
    /** True until the reader does something. Until then the page plays by itself, once. */
    this.isOpening = true;
    this.chosen = null;
    /** Whether bodies have arrows for their velocities and the forces of their motors. */
    this.hasArrows = true;
    this.isReduced = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.listeners = [];
    this.build(data);
  }

  build(data) {
    const views = new Map();
    const titles = this.tracks.map((track) => track.title);
    const names = shortNames(titles);
    this.charts = data.charts.map((chart) => new Chart(chart, names, this.end, (time) => this.seek(time)));
    const hasNames = this.charts.some((chart) => chart.names.length);
    this.panels = this.tracks.map((track, i) => {
      const size = `${track.width} ${track.height}`;
      const margin = MARGIN - track.outer;
      if (!views.has(size)) views.set(size, new View(track.width, track.height, margin));
      const title = hasNames && names[i] === LETTERS[i] ? `${names[i]}: ${titles[i]}` : titles[i];
      return new Panel(track, title, views.get(size), this);
    });
    this.views = [...views.values()];
    this.root.classList.toggle("several", this.tracks.length > 1);
    this.root.classList.toggle("panorama", this.tracks.length === 1 && this.views[0].aspect > WIDE);
    const columns = COLUMNS[this.tracks.length] ?? MAX_COLUMNS;
    this.find("floors").style.setProperty("--columns", columns);
    this.root.classList.toggle("many", this.tracks.length > columns);
    this.root.classList.toggle("crowded", this.tracks.length > MAX_COLUMNS + 1);
    this.find("floors").append(...this.panels.map((panel) => panel.element));
    this.find("charts").append(...this.charts.map((chart) => chart.element));
    const fleets = this.tracks.filter((track) => track.isFleet && track.robots > 1);
    this.fleets = fleets.map((track) => new FleetPanel(track, this));
    this.find("charts").before(...this.fleets.map((fleet) => fleet.element));
  }

  find(name) {
    return partOf(this.root, name);
  }

  get density() {
    return this.theme?.density ?? devicePixelRatio;
  }

  /** Draw everything at the present time. The same time always gives the same picture. */
  draw() {
    this.theme = readTheme();
    // With reduced motion, bodies jump from step to step.
    const time = this.isReduced && this.isPlaying ? this.longest.timeOf(this.step) : this.time;
    for (const panel of this.panels) panel.draw(time, this.theme);
    for (const chart of this.charts) chart.draw(time);
    for (const fleet of this.fleets) fleet.draw(time);
    drawLegend(this.find("legend"), this.legend, this.theme);
    for (const listener of this.listeners) listener();
  }

  /** The number of complete steps. */
  get step() {
    return this.longest.at(this.time).step;
  }

  /** Play or pause; at the end, start again. */
  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  play() {
    this.isOpening = false;
    if (this.time >= this.end) this.time = 0;
    this.run(true);
  }

  pause() {
    this.isOpening = false;
    this.run(false);
  }

  /** Play while the page is visible, and stop at the end, until the reader does something. */
  open(isInSight) {
    if (this.isOpening) this.run(isInSight && this.time < this.end);
  }

  run(isPlaying) {
    this.isPlaying = isPlaying;
    this.before = null;
    cancelAnimationFrame(this.coming);
    if (isPlaying) this.coming = requestAnimationFrame((now) => this.tick(now));
    this.draw();
  }

  tick(now) {
    const passed = Math.min(now - (this.before ?? now), MAX_TICK);
    this.time += (passed / 1000) * this.speed * this.rate;
    this.before = now;
    if (this.time >= this.end) {
      this.time = this.end;
      this.isPlaying = false;
    }
    this.draw();
    if (this.isPlaying) this.coming = requestAnimationFrame((next) => this.tick(next));
  }

  /** Pause at a time, or at the nearest time that exists. */
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.end);
    this.pause();
  }

  /** Pause at a step. */
  goTo(step) {
    this.seek(this.longest.timeOf(step));
  }

  /** Pause some steps later, or earlier if negative; within a step, its start and end count as steps. */
  move(steps) {
    const isBetween = this.time > this.longest.timeOf(this.step);
    let step = this.step + steps + (steps < 0 && isBetween ? 1 : 0);
    // A step may take no time: a body that knows its path leaves a bump out.
    while (steps < 0 && step > 0 && this.longest.timeOf(step) >= this.time) step--;
    this.goTo(step);
  }

  /** Pause at the next hit, pickup or drop; if a robot is chosen, only at its events. */
  goToEvent() {
    const found = this.tracks.flatMap((track) => {
      const bodies = this.chosen === null ? [...Array(track.robots).keys()] : [this.chosen];
      const event = nextEvent(track, track.at(this.time).frame, bodies);
      return event ? [{ ...event, time: track.time[event.frame], track }] : [];
    });
    found.sort((a, b) => a.time - b.time);
    const [next] = found;
    const robot = next?.track.robots > 1 ? `robot ${next.body}: ` : "";
    const words = next ? `${robot}${WORDS[next.what]}` : "no more events";
    this.lastEvent = { time: next ? next.time : this.end, words };
    this.seek(this.lastEvent.time);
  }

  /** The event at the present time in words, if `goToEvent` has led there. */
  get event() {
    return this.lastEvent?.time === this.time ? this.lastEvent.words : "";
  }

  /** Choose a robot by its number, or no robot if it is `null` or missing in one of the tracks. */
  choose(robot) {
    const isThere = robot >= 0 && this.tracks.every((track) => robot < track.robots);
    this.chosen = isThere ? robot : null;
    this.draw();
  }

  faster(steps) {
    const place = SPEEDS.indexOf(this.speed) + steps;
    this.speed = SPEEDS[Math.min(Math.max(place, 0), SPEEDS.length - 1)];
    this.draw();
  }

  toggleArrows() {
    this.hasArrows = !this.hasArrows;
    this.draw();
  }

  /** Zoom the views around their centres. */
  zoom(factor) {
    for (const view of this.views) view.zoomBy(factor, view.canvasWidth / 2, view.canvasHeight / 2);
    this.draw();
  }

  /** Move the views by multiples of an eighth of a canvas to the right and down. */
  pan(right, down) {
    for (const view of this.views) {
      view.moveBy((-right * view.canvasWidth) / 8, (-down * view.canvasHeight) / 8);
    }
    this.draw();
  }

  fit() {
    for (const view of this.views) view.fit();
    this.draw();
  }

  /** The present step, and the time if there is a clock, in words. */
  get place() {
    const { longest } = this;
    const clock = this.tracks.some((track) => track.isContinuous) ? `, ${seconds(this.time)}` : "";
    return `${this.unit} ${longest.stepAt(this.time)} of ${longest.steps}${clock}`;
  }

  /** Return a description of a moment of a track, for screen readers. */
  describe(track, moment) {
    const words = [`${track.title}, ${this.unit} ${track.stepAt(moment.time)} of ${track.steps}`];
    if (track.robots === 1 && track.load[moment.frame] >= 0) {
      const [row, column] = track.rowAndColumn(track.cell(0, moment.frame));
      const load = track.isLoaded(0, moment.frame) ? "loaded" : "empty";
      words.push(`${load} robot at row ${row}, column ${column}`);
    } else if (track.robots > 1) words.push(`${shown(track.robots)} robots`);
    const hits = track.hitsIn(moment.frame).length;
    if (hits) words.push(hits === 1 ? "1 collision" : `${hits} collisions`);
    words.push(track.caption(moment));
    return words.filter(Boolean).join("; ");
  }
}
