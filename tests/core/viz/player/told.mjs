// Prints what the page makes of the packed block on standard input, as JSON; NaN is a word there.
// With the word "frames", what it knows of each frame of the tracks in the block.

import { readFileSync } from "node:fs";

import { decode, Track, unpack } from "../../../../warehouse_core/viz/player/track.js";

function framesOf(packed) {
  const track = new Track(packed);
  return Array.from(track.time, (time, frame) => {
    const moment = track.at(time);
    const bodies = Array.from({ length: track.bodies }, (_, body) => track.pose(body, moment));
    return {
      frame: moment.frame,
      step: track.stepAt(time),
      caption: track.caption(moment),
      tiles: track.tiles[track.tileAt[frame]],
      bodies,
      hits: track.hitsIn(frame),
      waiting: track.waitingAt(moment.step) ?? [],
      battery: bodies.slice(0, track.robots).map((_, body) => track.fleet?.battery[body * track.frames + frame]),
    };
  });
}

const plain = (_, value) => {
  if (ArrayBuffer.isView(value)) return [...value];
  return Number.isNaN(value) ? "NaN" : value;
};
const data = decode(await unpack(readFileSync(0, "latin1")));
const told = process.argv[2] === "frames" ? data.tracks.map(framesOf) : data;
process.stdout.write(JSON.stringify(told, plain));
