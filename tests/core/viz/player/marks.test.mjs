import assert from "node:assert/strict";
import { test } from "node:test";

import { signsOf } from "../../../../warehouse_core/viz/player/legend.js";
import { marksUntil } from "../../../../warehouse_core/viz/player/track.js";
import { along, hitsOf, trackOf } from "./some_tracks.mjs";

const marks = { time: [0, 1, 1, 3], cell: [5, 6, 5, 7], value: [0, 0, 1, 0] };

test("marks at a time are the last of each cell, however the time came about", () => {
  const track = { marks };
  const at = (time) => [...marksUntil(track, time)];
  assert.deepEqual(at(3), [[5, 1], [6, 0], [7, 0]]);
  assert.deepEqual(at(0.5), [[5, 0]]);
  assert.deepEqual(at(1), [[5, 1], [6, 0]]);
  assert.deepEqual(at(0), [[5, 0]]);
});

const theme = { wall: "wall", ink: "ink", light: "light", ice: "ice", shadow: "shadow", orders: [] };

function words(...tracks) {
  return signsOf(tracks, theme).map((sign) => sign.words);
}

test("a legend names what is in the tracks and nothing else", () => {
  assert.deepEqual(words(trackOf([along([0, 1])])), ["robot (empty)"]);
  const tiles = ["#P.?", "#.DC"];
  const loaded = trackOf([along([0, 1], 1)], { tiles, hits: hitsOf([[1, 1, 1, 0]]), slippery: [[1, 1]], viewRadius: 1 });
  assert.deepEqual(words(loaded), [
    "robot (loaded)", "P pickup", "D dropoff", "C charger", "wall", "not seen yet",
    "slippery floor", "what the robot does not see", "hit",
  ]);
});

test("a legend of two tracks names what either has, once", () => {
  const [empty, loaded] = [trackOf([along([0])]), trackOf([along([0], 2)], { robots: 0 })];
  assert.deepEqual(words(empty, loaded), ["robot (empty)", "robot (loaded)", "person"]);
});

test("a legend of a search names its marks and its ends, not the stations", () => {
  const search = trackOf([along([0], -1)], {
    tiles: ["PD"],
    marks: { ...marks, names: ["expanded", "path"], colors: ["red", "blue"] },
  });
  assert.deepEqual(words(search), ["expanded", "path", "S start, G goal"]);
});
