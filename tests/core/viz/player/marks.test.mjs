import assert from "node:assert/strict";
import { test } from "node:test";

import { marksUntil } from "../../../../warehouse_core/viz/player/track.js";

const marks = { time: [0, 1, 1, 3], cell: [5, 6, 5, 7], value: [0, 0, 1, 0] };

test("marks at a time are the last of each cell, however the time came about", () => {
  const track = { marks };
  const at = (time) => [...marksUntil(track, time)];
  assert.deepEqual(at(3), [[5, 1], [6, 0], [7, 0]]);
  assert.deepEqual(at(0.5), [[5, 0]]);
  assert.deepEqual(at(1), [[5, 1], [6, 0]]);
  assert.deepEqual(at(0), [[5, 0]]);
});
