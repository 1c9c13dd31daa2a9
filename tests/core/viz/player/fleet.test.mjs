import assert from "node:assert/strict";
import { test } from "node:test";

import { FleetPanel, orderOf } from "../../../../warehouse_core/viz/player/fleet.js";
import { along, trackOf } from "./some_tracks.mjs";

/** Robot 0 delivers order 0 late, robot 1 takes order 1 and keeps it, orders 2 and 3 are not taken. */
const orders = {
  due: [9, 30, 12, 6],
  taken: [4, 5, -1, -1],
  takenBy: [0, 1, -1, -1],
  delivered: [10, -1, -1, -1],
  pickup: [11, 11, 12, 12],
  dropoff: [88, 77, 88, 77],
};
/** Robot 0 gets order 0, then 2, then none; robot 1 gets order 1. */
const assigned = { step: [0, 2, 10, 12], robot: [0, 1, 0, 0], order: [0, 1, 2, -1] };
const fleet = { orders, assigned };

test("a robot's order is the one that it carries, or the last that it was assigned", () => {
  assert.deepEqual([0, 4, 9, 10, 12].map((step) => orderOf(fleet, 0, step)), [0, 0, 0, 2, -1]);
  assert.deepEqual([0, 2, 5, 99].map((step) => orderOf(fleet, 1, step)), [-1, 1, 1, 1]);
});

/** Return the words on the order of robot 0 after each of some steps. */
function wordsAt(steps, changes = {}) {
  const track = trackOf([along([0])], { fleet: { ...fleet, orders: { ...orders, ...changes } } });
  const panel = Object.assign(Object.create(FleetPanel.prototype), { track });
  return steps.map((step) => panel.orderWords(0, { step }));
}

test("a robot is to pick its order at the pickup until it is taken, then carries it to the dropoff", () => {
  assert.deepEqual(wordsAt([0, 3, 4, 9, 10, 12]), [
    "0, to be picked up at (1, 1), due in 9 steps",
    "0, to be picked up at (1, 1), due in 6 steps",
    "0, carried to (8, 8), due in 5 steps",
    "0, carried to (8, 8), due in 0 steps",
    "2, to be picked up at (1, 2), due in 2 steps",
    "none",
  ]);
});

test("an order whose dropoff is its pickup is to be picked until it is taken", () => {
  assert.deepEqual(wordsAt([3, 4], { dropoff: orders.pickup }), [
    "0, to be picked up at (1, 1), due in 6 steps",
    "0, carried to (1, 1), due in 5 steps",
  ]);
});
