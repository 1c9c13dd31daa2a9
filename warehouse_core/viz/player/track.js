// A track at any moment, and the block of bytes that it is read from. Nothing is drawn here.

const KINDS = { i1: Int8Array, i2: Int16Array, i4: Int32Array, f4: Float32Array };

const TURN = 120;
const NO_HEADING = 127;

/** Steps in one place, with the same load, after which a robot is stuck. */
const STUCK_VISITS = 3;

/** Return the bytes of a compressed block, given as base64. */
export async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Return the JSON value at the start of a block, with arrays in place of references; see tracks.py. */
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

/** Return how many of some times, which do not decrease, are at most `time`. */
function countAt(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Return the last index whose time is at most `time`, or 0. Times do not decrease. */
export function indexAt(times, time) {
  return Math.max(countAt(times, time) - 1, 0);
}

/** Return the indices of the entries of a frame, whose frames do not decrease. */
function entriesIn(frames, frame) {
  const first = countAt(frames, frame - 1);
  return Array.from({ length: countAt(frames, frame) - first }, (_, i) => first + i);
}
/** Return the angle a share of the way from one to another, the short way round. */
export function angleBetween(from, to, share) {
  const difference = ((to - from + 1.5 * TURN) % TURN) - TURN / 2;
  return from + share * difference;
}

export class Track {
  constructor(data) {
    Object.assign(this, data);
    this.frames = data.time.length;
    this.end = data.time[this.frames - 1];
    /** The frame in which each step is complete. */
    this.stepFrames = [];
    for (let frame = 0; frame < this.frames; frame++) {
      if (Math.floor(data.progress[frame]) === this.stepFrames.length) this.stepFrames.push(frame);
    }
    this.steps = Math.ceil(data.progress[this.frames - 1]);
  }

  /** Return a moment: its frame, the next one, the share of the way there, and the steps complete. */
  at(time) {
    const frame = indexAt(this.time, time);
    const next = Math.min(frame + 1, this.frames - 1);
    const lasts = this.time[next] - this.time[frame];
    const share = lasts > 0 ? Math.min(Math.max((time - this.time[frame]) / lasts, 0), 1) : 0;
    return { time, frame, next: share > 0 ? next : frame, share, step: Math.floor(this.progress[frame]) };
  }

  /** Return the number of the step that is under way, or was the last one. */
  stepAt(time) {
    return Math.ceil(this.progress[this.at(time).next]);
  }

  /** Return the time at which a step is complete. */
  timeOf(step) {
    return this.time[this.stepFrames[Math.min(Math.max(step, 0), this.stepFrames.length - 1)]];
  }

  /** Return the words for a moment: on the step that is under way or, at its end, on that one. */
  caption(moment) {
    return this.captions[this.captionAt[this.tellsNext ? moment.frame : moment.next]];
  }

  /** Return the pose of a body at a moment, or `null` if it is not shown. A heading is in radians. */
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

  headingBetween(from, to, share) {
    const [first, last] = [this.heading[from], this.heading[to]];
    if (last === NO_HEADING) return null;
    const angle = first === NO_HEADING ? last : angleBetween(first, last, share);
    return (angle / TURN) * 2 * Math.PI;
  }

  /** Return the number of the cell of a body in a frame, row * width + column. */
  cell(body, frame) {
    const place = body * this.frames + frame;
    return Math.floor(this.y[place]) * this.width + Math.floor(this.x[place]);
  }

  /** Return the `[row, column]` of the number of a cell. */
  rowAndColumn(cell) {
    return [Math.floor(cell / this.width), cell % this.width];
  }

  isLoaded(body, frame) {
    return this.load[body * this.frames + frame] > 0;
  }

  /** Return how full the battery of a robot of a fleet is, from 0 to 1. */
  batteryLevel(robot, frame) {
    return this.fleet.battery[robot * this.frames + frame];
  }

  /** Return the hits that a frame shows. */
  hitsIn(frame) {
    const { x, y, robot, labels, labelAt } = this.hits;
    return entriesIn(this.hits.frame, frame).map((i) => (
      { x: x[i], y: y[i], robot: robot[i], label: labels[labelAt[i]] }
    ));
  }

  /** Return whether a robot has a hit in a frame that the frame before did not show. */
  isHit(body, frame) {
    const mine = (hit) => hit.robot === body;
    const before = frame ? this.hitsIn(frame - 1).filter(mine) : [];
    return this.hitsIn(frame)
      .filter(mine)
      .some((hit) => !this.isContinuous || !before.some((old) => old.x === hit.x && old.y === hit.y));
  }

  /** Return the points of the planned way of a lone robot in a frame. */
  routeIn(frame) {
    const { frame: frames, x, y } = this.route ?? { frame: [] };
    return entriesIn(frames, frame).map((i) => [x[i], y[i]]);
  }

  /** Return the planned ways of a fleet in a frame, and those that robots wish for. */
  plansIn(frame) {
    const { plans, ways } = this.fleet;
    return entriesIn(plans.frame, frame).map((i) => {
      const cells = ways.subarray(plans.end[i - 1] ?? 0, plans.end[i]);
      return { robot: plans.robot[i], isWish: plans.isWish[i] > 0, cells };
    });
  }

  /** Return who pushes whom in a frame, the pusher first. */
  pushesIn(frame) {
    const { pushes } = this.fleet;
    return entriesIn(pushes.frame, frame).map((i) => [pushes.pusher[i], pushes.robot[i]]);
  }
}

/** Return the words for what happened to a robot in a frame: "hit", "pick", "drop" or "stuck". */
export function eventsOf(track, body, frame) {
  const found = [];
  const [before, now] = [track.isLoaded(body, frame - 1), track.isLoaded(body, frame)];
  if (!before && now) found.push("pick");
  if (before && !now) found.push("drop");
  if (track.isHit(body, frame)) found.push("hit");
  if (stuckFrames(track, body).has(frame)) found.push("stuck");
  return found;
}

/** Return the next frame after `frame` in which something happens, and what, or `null`. */
export function nextEvent(track, frame, bodies) {
  for (let next = frame + 1; next < track.frames; next++) {
    for (const body of bodies) {
      const [what] = eventsOf(track, body, next);
      if (what) return { frame: next, body, what };
    }
  }
  return null;
}

/** Return the frames in which a robot has come to a cell too often without a pick or a drop. */
export function stuckFrames(track, body) {
  track.stuck ??= new Map();
  if (!track.stuck.has(body)) track.stuck.set(body, new Set(findStuck(track, body)));
  return track.stuck.get(body);
}

function* findStuck(track, body) {
  let visits = new Map();
  let isStuck = false;
  let [lastCell, lastLoad] = [-1, 0];
  for (const frame of track.stepFrames) {
    const load = track.isLoaded(body, frame);
    if (load !== lastLoad) visits = new Map();
    const cell = track.cell(body, frame);
    const count = (visits.get(cell) ?? 0) + 1;
    visits.set(cell, count);
    if (count === 1) isStuck = false;
    if (count >= STUCK_VISITS && !isStuck && (cell !== lastCell || track.robots === 1)) {
      isStuck = true;
      yield frame;
    }
    [lastCell, lastLoad] = [cell, load];
  }
}

/** Return how often a body was in each cell up to a frame, as a map from cells to counts. */
export function visitsUntil(track, body, frame) {
  return grown(track, `visits of ${body}`, frame + 1, (counts, next) => {
    const cell = track.cell(body, next);
    if (next === 0 || track.cell(body, next - 1) !== cell) counts.set(cell, (counts.get(cell) ?? 0) + 1);
  });
}

/** Return how often robots were held up in each cell up to a step, as a map from cells. */
export function heldUpUntil(track, until) {
  const { step, cell } = track.fleet.heldUp;
  return grown(track, "held up", countAt(step, until), (counts, i) =>
    counts.set(cell[i], (counts.get(cell[i]) ?? 0) + 1));
}

/** Return the colour, by its number, of each cell that a search has marked until a time, as a map. */
export function marksUntil(track, until) {
  const { time, cell, value } = track.marks;
  return grown(track, "marks", countAt(time, until), (colors, i) => colors.set(cell[i], value[i]));
}

/** Return a map to which the first entries of a list are added; what it has from an earlier time stays. */
function grown(track, name, count, add) {
  track.grown ??= {};
  let known = track.grown[name];
  if (!(known?.count <= count)) known = track.grown[name] = { count: 0, map: new Map() };
  while (known.count < count) add(known.map, known.count++);
  return known.map;
}
