// Data of small tracks, as track.js decodes it.

import { Track } from "../../../../warehouse_core/viz/player/track.js";

/** Return a track on a floor of 10 x 10 cells whose bodies have a list of [x, y, load] each. */
export function trackOf(bodies, changes = {}) {
  const frames = bodies[0].length;
  const column = (part) => bodies.flatMap((poses) => poses.map((pose) => pose[part]));
  const counting = Array.from({ length: frames }, (_, frame) => frame);
  return new Track({
    title: "A track",
    width: 10,
    height: 10,
    outer: 0,
    robots: bodies.length,
    bodies: bodies.length,
    isContinuous: false,
    isFleet: bodies.length > 1,
    time: counting,
    progress: counting,
    x: column(0),
    y: column(1),
    vx: [],
    skid: [],
    load: Int8Array.from(column(2)),
    heading: bodies.flatMap((poses) => poses.map((pose) => pose[3] ?? 127)),
    hits: hitsOf([]),
    tiles: [".".repeat(100)],
    tileAt: counting.map(() => 0),
    captions: counting.map((frame) => `caption ${frame}`),
    captionAt: counting,
    viewRadius: null,
    slippery: [],
    route: { frame: [], x: [], y: [] },
    fleet: null,
    marks: null,
    ...changes,
  });
}

/** Return hits, given as [frame, x, y, robot] in the order of their frames. */
export function hitsOf(hits) {
  const [frame, x, y, robot] = [0, 1, 2, 3].map((part) => hits.map((hit) => hit[part]));
  return { frame, x, y, robot, size: hits.map(() => 1), labels: ["12 N·s"], labelAt: hits.map(() => 0) };
}

/** Return one body that is in the middle of each cell of a row in turn. */
export function along(columns, load = 0) {
  return columns.map((column) => [column + 0.5, 0.5, load]);
}
