// Prints what the page knows of each frame of the packed tracks on standard input, as JSON.

import { readFileSync } from "node:fs";

import { waitingByPickup } from "../../../../warehouse_core/viz/player/orders.js";
import { decode, Track, unpack } from "../../../../warehouse_core/viz/player/track.js";

const data = decode(await unpack(readFileSync(0, "latin1")));
const frames = data.tracks.map((packed) => {
  const track = new Track(packed);
  return Array.from(track.time, (time, frame) => {
    const moment = track.at(time);
    const bodies = Array.from({ length: track.bodies }, (_, body) => track.pose(body, moment));
    const orders = track.fleet?.orders;
    return {
      frame: moment.frame,
      step: track.stepAt(time),
      caption: track.caption(moment),
      tiles: track.tiles[track.tileAt[frame]],
      bodies,
      hits: track.hitsIn(frame),
      waiting: orders ? [...waitingByPickup(orders, track.progress[frame])] : [],
      battery: bodies.slice(0, track.robots).map((_, body) => track.fleet?.battery[body * track.frames + frame]),
    };
  });
});
process.stdout.write(JSON.stringify(frames));
