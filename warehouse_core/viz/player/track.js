// A track at any moment. Nothing is drawn here.

const TURN = 120;
const NO_HEADING = 127;

/** Steps in one place, with the same load, after which a robot is stuck. */
const STUCK_VISITS = 3;

/** Return the last index whose time is at most `time`, or 0. Times do not decrease. */
export function indexAt(times, time) {
  let low = 0;
  let high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return low;
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
    this.firstHit = firstOf(data.hits.frame, this.frames);
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
    const found = [];
    for (let i = this.firstHit[frame]; i < this.firstHit[frame + 1]; i++) {
      found.push({
        x: this.hits.x[i],
        y: this.hits.y[i],
        robot: this.hits.robot[i],
        label: this.hits.labels[this.hits.labelAt[i]],
      });
    }
    return found;
  }

  /** Return whether a robot has a hit in a frame that the frame before did not show. */
  isHit(body, frame) {
    const mine = (hit) => hit.robot === body;
    const before = frame ? this.hitsIn(frame - 1).filter(mine) : [];
    return this.hitsIn(frame)
      .filter(mine)
      .some((hit) => !this.isContinuous || !before.some((old) => old.x === hit.x && old.y === hit.y));
  }

  /** Return the points of the planned way in a frame. */
  routeIn(frame) {
    if (!this.route) return [];
    this.routeEnds ??= sums(this.route.count);
    const points = [];
    for (let i = this.routeEnds[frame]; i < this.routeEnds[frame + 1]; i++) {
      points.push([this.route.x[i], this.route.y[i]]);
    }
    return points;
  }
}

/** Return the sums of the first 0, 1, 2, ... numbers. */
export function sums(numbers) {
  const found = new Int32Array(numbers.length + 1);
  for (let i = 0; i < numbers.length; i++) found[i + 1] = found[i] + numbers[i];
  return found;
}

/** Return for each of the places 0, 1, 2, ..., and one more, the index of its first entry in a list in order. */
function firstOf(places, count) {
  const counts = new Int32Array(count);
  for (const place of places) counts[place]++;
  return sums(counts);
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
  return countUntil(track, body, frame, (next) => {
    const cell = track.cell(body, next);
    return next > 0 && track.cell(body, next - 1) === cell ? [] : [cell];
  });
}

/** Return how often robots were held up in each cell up to a step, as a map from cells. */
export function heldUpUntil(track, step) {
  const { step: steps, cell } = track.fleet.heldUp;
  track.firstHeldUp ??= firstOf(steps, track.steps + 1);
  const of = (next) => cell.subarray(track.firstHeldUp[next], track.firstHeldUp[next + 1]);
  return countUntil(track, "held up", step, of);
}

/** Count the cells of each frame or step up to one. What was counted last under a key is counted on from there. */
function countUntil(track, key, frame, cellsIn) {
  track.counted ??= new Map();
  let found = track.counted.get(key);
  if (!(found?.frame <= frame)) found = { frame: -1, counts: new Map() };
  track.counted.set(key, found);
  while (found.frame < frame) {
    for (const cell of cellsIn(++found.frame)) found.counts.set(cell, (found.counts.get(cell) ?? 0) + 1);
  }
  return found.counts;
}
