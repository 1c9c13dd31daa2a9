// A track at any moment, and the block of bytes from which it is read. Nothing is drawn here.

import LOOK from "../../render/tiles.json" with { type: "json" };

const KINDS = { i1: Int8Array, i2: Int16Array, i4: Int32Array, f4: Float32Array };

const TURN = 120;

const NO_HEADING = 127;

/** Return the bytes of a compressed block that is given as base64. */
export async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Return the JSON value at the start of a block, with its references replaced by arrays; see tracks.py. */
export function decode(block) {
  const length = new DataView(block).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(block, 4, length));
  const start = 4 + length;
  return JSON.parse(text, (_, value) => (value?.$ ? column(block, start, value.$) : value));
}

function column(block, start, [kind, offset, length, isDelta, unit]) {
  const stored = new KINDS[kind](block, start + offset, length);
  if (!isDelta && unit === 1) return stored;
  const values = unit === 1 ? new Int32Array(length) : new Float64Array(length);
  let sum = 0;
  for (let i = 0; i < length; i++) {
    sum = isDelta ? sum + stored[i] : stored[i];
    values[i] = sum * unit;
  }
  return values;
}

/** Return the number of times that are at most `time`. The times do not decrease. */
function countAt(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Return the last index whose time is at most `time`, or 0. The times do not decrease. */
export function indexAt(times, time) {
  return Math.max(countAt(times, time) - 1, 0);
}

/** Return the indices of the entries that belong to a frame. The frames do not decrease. */
function entriesIn(frames, frame) {
  const first = countAt(frames, frame - 1);
  return Array.from({ length: countAt(frames, frame) - first }, (_, i) => first + i);
}

/** Return the angle at a share of the turn from one angle to another, in the shorter direction. */
export function angleBetween(from, to, share) {
  const difference = ((to - from + 1.5 * TURN) % TURN) - TURN / 2;
  return from + share * difference;
}

export class Track {
  constructor(data) {
    Object.assign(this, data);
    this.frames = data.time.length;
    this.end = data.time[this.frames - 1];
    /** The number of the frame in which each step is complete. */
    this.stepFrames = [];
    for (let frame = 0; frame < this.frames; frame++) {
      if (Math.floor(data.progress[frame]) === this.stepFrames.length) this.stepFrames.push(frame);
    }
    this.steps = Math.ceil(data.progress[this.frames - 1]);
  }

  /**
   * Return a moment: its frame, the next frame, the share of the time between them, and the step. Bodies
   * drive from frame to frame. Robots on the grid jump: their next frame is the same one.
   */
  at(time) {
    const frame = indexAt(this.time, time);
    const step = Math.floor(this.progress[frame]);
    if (!this.isContinuous) return { time, frame, next: frame, share: 0, step };
    const next = Math.min(frame + 1, this.frames - 1);
    const lasts = this.time[next] - this.time[frame];
    const share = lasts > 0 ? Math.min(Math.max((time - this.time[frame]) / lasts, 0), 1) : 0;
    return { time, frame, next: share > 0 ? next : frame, share, step };
  }

  /** Return the number of the present step, or of the previous one if no step has begun. */
  stepAt(time) {
    return Math.ceil(this.progress[this.at(time).next]);
  }

  /** Return the time at which a step is complete. */
  timeOf(step) {
    return this.time[this.stepFrames[Math.min(Math.max(step, 0), this.stepFrames.length - 1)]];
  }

  /** Return the caption of a moment, which is about the present step, or at its end about this step. */
  caption(moment) {
    return this.captions[this.captionAt[this.captionsNext ? moment.frame : moment.next]];
  }

  /** Return the pose of a body at a moment, or `null` if it is not shown. The heading is in radians. */
  pose(body, { frame, next = frame, share = 0 }) {
    const from = body * this.frames + frame;
    if (this.load[from] < 0) return null;
    const after = body * this.frames + next;
    const to = this.load[after] < 0 ? from : after;
    return {
      x: this.x[from] + share * (this.x[to] - this.x[from]),
      y: this.y[from] + share * (this.y[to] - this.y[from]),
      heading: this.headingBetween(from, to, share),
      load: this.load[from],
    };
  }

  /** Return the velocity in m/s and the motor's force in N of a body at a moment, or `null` if they are unknown. */
  push(body, { frame, next = frame, share = 0 }) {
    if (!this.vx.length) return null;
    const [from, to] = [body * this.frames + frame, body * this.frames + next];
    const [vx, vy] = [this.vx, this.vy].map((list) => list[from] + share * (list[to] - list[from]));
    const [fx, fy] = [this.fx[to], this.fy[to]]; // of the time that ends then
    return { velocity: [vx, vy], force: [fx, fy], brakes: vx * fx + vy * fy < -LOOK.braking.power };
  }

  headingBetween(from, to, share) {
    const [first, last] = [this.heading[from], this.heading[to]];
    if (last === NO_HEADING) return null;
    const angle = first === NO_HEADING ? last : angleBetween(first, last, share);
    return (angle / TURN) * 2 * Math.PI;
  }

  /** Return the cell of a body in a frame, as the number row * width + column. */
  cell(body, frame) {
    const place = body * this.frames + frame;
    return Math.floor(this.y[place]) * this.width + Math.floor(this.x[place]);
  }

  /** Return a cell, given by its number, as `[row, column]`. */
  rowAndColumn(cell) {
    return [Math.floor(cell / this.width), cell % this.width];
  }

  isLoaded(body, frame) {
    return this.load[body * this.frames + frame] > 0;
  }

  /** Return the battery level of a robot of a fleet, from 0 to 1. */
  batteryLevel(robot, frame) {
    return this.fleet.battery[robot * this.frames + frame];
  }

  /** Return the hits in a frame. */
  hitsIn(frame) {
    const { x, y, robot, size, labels, labelAt } = this.hits;
    return entriesIn(this.hits.frame, frame).map((i) => (
      { x: x[i], y: y[i], robot: robot[i], size: size[i], label: labels[labelAt[i]] }
    ));
  }

  /** Return whether a frame shows a hit of a robot that the previous frame did not show. */
  isHit(body, frame) {
    const mine = (hit) => hit.robot === body;
    const before = frame ? this.hitsIn(frame - 1).filter(mine) : [];
    return this.hitsIn(frame)
      .filter(mine)
      .some((hit) => !this.isContinuous || !before.some((old) => old.x === hit.x && old.y === hit.y));
  }

  /** Return the points of the planned path of a single robot in a frame. */
  routeIn(frame) {
    const { x, y } = this.route;
    return entriesIn(this.route.frame, frame).map((i) => [x[i], y[i]]);
  }

  /** Return the planned paths of a fleet in a frame, and the shortest paths from their ends to the goals. */
  plansIn(frame) {
    const { plans, paths } = this.fleet;
    return entriesIn(plans.frame, frame).map((i) => {
      const cells = paths.subarray(plans.end[i - 1] ?? 0, plans.end[i]);
      return { robot: plans.robot[i], isWish: plans.isWish[i] > 0, cells };
    });
  }

  /** Return the orders that wait at pickups after a step, or nothing if the track has no orders. */
  waitingAt(step) {
    const waiting = this.fleet?.waiting;
    if (!waiting?.step.length) return null;
    const { cell, number, age } = waiting;
    return entriesIn(waiting.step, step).map((i) => ({ cell: cell[i], count: number[i], age: age[i] }));
  }

  /** Return the pairs of robots in a frame of which the first pushes the second. */
  pushesIn(frame) {
    const { pushes } = this.fleet;
    return entriesIn(pushes.frame, frame).map((i) => [pushes.pusher[i], pushes.robot[i]]);
  }
}

/** Return the names of the events of a robot in a frame: "hit", "pick" or "drop". */
export function eventsOf(track, body, frame) {
  const found = [];
  const [before, now] = [track.isLoaded(body, frame - 1), track.isLoaded(body, frame)];
  if (!before && now) found.push("pick");
  if (before && !now) found.push("drop");
  if (track.isHit(body, frame)) found.push("hit");
  return found;
}

/** Return the first event of some bodies after a frame, or `null`. */
export function nextEvent(track, frame, bodies) {
  for (let next = frame + 1; next < track.frames; next++) {
    for (const body of bodies) {
      const [what] = eventsOf(track, body, next);
      if (what) return { frame: next, body, what };
    }
  }
  return null;
}

/** Return a map from cells to the number of visits of a body up to a frame. */
export function visitsUntil(track, body, frame) {
  return grown(track, `visits of ${body}`, frame + 1, (counts, next) => {
    const cell = track.cell(body, next);
    if (next === 0 || track.cell(body, next - 1) !== cell) counts.set(cell, (counts.get(cell) ?? 0) + 1);
  });
}

/** Return a map from cells to the number of times robots were held up there up to a step. */
export function heldUpUntil(track, until) {
  const { step, cell } = track.fleet.heldUp;
  return grown(track, "held up", countAt(step, until), (counts, i) =>
    counts.set(cell[i], (counts.get(cell[i]) ?? 0) + 1));
}

/** Return a map from the cells that a search has marked up to a time to the numbers of their colours. */
export function marksUntil(track, until) {
  const { time, cell, value } = track.marks;
  return grown(track, "marks", countAt(time, until), (colors, i) => colors.set(cell[i], value[i]));
}

/** Return a map with the first `count` entries of a list. The map of an earlier time is extended if possible. */
function grown(track, name, count, add) {
  track.grown ??= {};
  let known = track.grown[name];
  if (!(known?.count <= count)) known = track.grown[name] = { count: 0, map: new Map() };
  while (known.count < count) add(known.map, known.count++);
  return known.map;
}
