import assert from "node:assert/strict";
import { test } from "node:test";

import {
  ageOf,
  ageWords,
  goalOf,
  historyOf,
  orderOf,
  waitingAt,
  waitingByPickup,
} from "../../../../warehouse_core/viz/player/orders.js";

/** Robot 0 delivers order 0 late, robot 1 takes order 1 and keeps it, orders 2 and 3 are not taken. */
const orders = {
  released: [0, 2, 3, 3],
  due: [9, 30, 12, 6],
  taken: [4, 5, -1, -1],
  takenBy: [0, 1, -1, -1],
  delivered: [10, -1, -1, -1],
  pickup: [11, 11, 12, 12],
  dropoff: [88, 77, 88, 77],
};
/** Steps, robots and orders: robot 0 gets order 0, then 2, then none; robot 1 gets order 1. */
const fleet = { orders, assigned: [0, 2, 10, 12, 0, 1, 0, 0, 0, 1, 2, -1] };

test("an order ages by thirds of its time, and is late after it is due", () => {
  const ages = [0, 2, 3, 5, 6, 8, 9, 10].map((step) => ageOf(orders, 0, step));
  assert.deepEqual(ages, [0, 0, 1, 1, 2, 2, 2, 3]);
  assert.equal(ageWords(orders, 0, 10), "late");
  assert.equal(ageOf({ released: [5], due: [5] }, 0, 5), 0);
});

test("orders wait from their release until they are taken, the one due first first", () => {
  assert.deepEqual([0, 2, 3, 4, 5].map((step) => waitingAt(orders, step)), [
    [0], [0, 1], [3, 0, 2, 1], [3, 2, 1], [3, 2],
  ]);
  assert.deepEqual([...waitingByPickup(orders, 8)], [[12, { count: 2, age: 3 }]]);
  assert.deepEqual(waitingByPickup(orders, 2).get(11), { count: 2, age: 0 });
});

test("a robot's order is the one that it carries, or the last that it was assigned", () => {
  assert.deepEqual([0, 4, 9, 10, 12].map((step) => orderOf(fleet, 0, step)), [0, 0, 0, 2, -1]);
  assert.deepEqual([0, 2, 5, 99].map((step) => orderOf(fleet, 1, step)), [-1, 1, 1, 1]);
});

test("a robot's goal is the pickup of its order until it is taken, then the dropoff", () => {
  const track = { fleet };
  assert.deepEqual([0, 3, 4, 9, 10, 12].map((step) => goalOf(track, 0, step)), [11, 11, 88, 88, 12, -1]);
  assert.equal(goalOf({ fleet: {} }, 0, 0), -1);
});

test("a history has what a robot did so far, the last first", () => {
  assert.deepEqual(historyOf(orders, 0, 3), []);
  assert.deepEqual(historyOf(orders, 0, 10), [
    { step: 10, what: "delivered", order: 0 },
    { step: 4, what: "picked", order: 0 },
  ]);
  assert.deepEqual(historyOf(orders, 1, 99), [{ step: 5, what: "picked", order: 1 }]);
});
