import assert from "node:assert/strict";
import { test } from "node:test";

import { extent, inTime, seconds, shown, stepsOf, ticks } from "../../../../warehouse_core/viz/player/scale.js";

test("ticks are round, lie within the axis and are about as many as asked for", () => {
  assert.deepEqual(ticks(0, 10, 5), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(ticks(-1, 0.5, 3), [-1, -0.5, 0, 0.5]);
  assert.deepEqual(ticks(0, 0.3, 3), [0, 0.1, 0.2, 0.3]);
  for (const [low, high] of [[0, 1e-9], [-7.3, 1234.5], [-3, -1], [0, 2 ** 31], [1e6, 1e6 + 1]]) {
    const found = ticks(low, high, 4);
    assert.ok(found.length >= 2 && found.length <= 9, `${found}`);
    assert.ok(found.every((value) => value >= low - 1e-9 && value <= high + 1e-9 * Math.abs(high)), `${found}`);
  }
});

test("an axis without a length has one tick", () => {
  assert.deepEqual(ticks(3, 3, 5), [3]);
  assert.deepEqual(ticks(0, Number.NaN, 5), [0]);
});

test("an extent holds 0, leaves out NaN, and is never empty", () => {
  assert.deepEqual(extent([[3, Number.NaN, 7], [5]]), [0, 7]);
  assert.deepEqual(extent([[-3, -1]]), [-3, 0]);
  assert.deepEqual(extent([[Number.NaN], []]), [0, 1]);
});

test("numbers are shown with groups, few digits and a minus sign", () => {
  assert.equal(shown(-12345.678), "\u221212,345.68");
  assert.equal(shown(0.126, 1), "0.1");
  assert.equal(shown(Number.NaN), "unknown");
});

test("a time has a decimal whatever its last bits are, as in test_wording.py", () => {
  const times = [49.75, 49.74999999999999, 49.749, 0.25, 0.15];
  assert.deepEqual(times.map(seconds), ["49.8 s", "49.8 s", "49.7 s", "0.3 s", "0.2 s"]);
});

test("one step has no plural", () => {
  assert.deepEqual([0, 1, 1234].map(stepsOf), ["0 steps", "1 step", "1,234 steps"]);
});

test("a number of steps after a deadline is in words, as in test_charts.py", () => {
  assert.deepEqual([-1234, 0, 7].map(inTime), ["1,234 early", "on time", "7 late"]);
});
