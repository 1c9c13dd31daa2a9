import assert from "node:assert/strict";
import { test } from "node:test";

import { View } from "../../../../warehouse_core/viz/player/canvas.js";
import { Player, shortNames } from "../../../../warehouse_core/viz/player/player.js";

function viewOf(columns, rows, width, height) {
  const view = new View(columns, rows, 0.1);
  view.place(width, height, 1);
  return view;
}

test("a floor that fits is in the middle of its canvas and within it", () => {
  for (const [columns, rows] of [[10, 10], [40, 5], [3, 200]]) {
    const view = viewOf(columns, rows, 600, 400);
    assert.ok(Math.abs(view.x(columns / 2) - 300) < 1e-9);
    assert.ok(Math.abs(view.y(rows / 2) - 200) < 1e-9);
    assert.ok(view.x(0) >= 0 && view.x(columns) <= 600);
    assert.ok(view.y(0) >= 0 && view.y(rows) <= 400);
  }
});

test("a place and its point are each other's", () => {
  const view = viewOf(12, 9, 640, 480);
  view.zoomBy(3, 100, 50);
  view.place(640, 480, 1);
  const [column, row] = view.cellAt(view.x(2.5), view.y(7.25));
  assert.ok(Math.abs(column - 2.5) < 1e-9 && Math.abs(row - 7.25) < 1e-9);
});

test("zooming keeps the place under the pointer, in the middle of a large floor", () => {
  const view = viewOf(100, 100, 500, 500);
  view.zoomBy(4, 250, 250);
  view.place(500, 500, 1);
  const before = view.cellAt(300, 200);
  view.zoomBy(2, 300, 200);
  view.place(500, 500, 1);
  const after = view.cellAt(300, 200);
  assert.ok(Math.hypot(before[0] - after[0], before[1] - after[1]) < 1e-6, `${before} ${after}`);
});

test("zooming ends at the whole floor and at 64, and fit undoes it", () => {
  const view = viewOf(10, 10, 500, 500);
  const whole = view.key;
  view.zoomBy(0.1, 0, 0);
  assert.equal(view.zoom, 1);
  for (let i = 0; i < 30; i++) view.zoomBy(2, 0, 0);
  assert.equal(view.zoom, 64);
  view.place(500, 500, 1);
  assert.notEqual(view.key, whole);
  view.fit();
  view.place(500, 500, 1);
  assert.equal(view.key, whole);
});

test("a floor cannot be moved out of its canvas", () => {
  const view = viewOf(20, 20, 400, 400);
  view.zoomBy(4, 200, 200);
  view.place(400, 400, 1);
  view.moveBy(1e6, -1e6);
  view.place(400, 400, 1);
  assert.ok(view.x(0) >= 0 && view.x(0) < view.scale, "the left edge is shown");
  assert.ok(view.y(20) <= 400 && view.y(20) > 400 - view.scale, "the lower edge is shown");
});

test("boxes of neighbours share an edge of whole pixels, and none is empty", () => {
  const view = viewOf(37, 21, 617, 311);
  for (let column = 0; column < 36; column++) {
    const [x, , width] = view.box(column, 3);
    assert.equal(x + width, view.box(column + 1, 3)[0]);
  }
  const small = viewOf(5000, 5000, 100, 100);
  assert.deepEqual(small.box(17, 4, 1, 1, 0.1).slice(2), [1, 1]);
});

test("what is outside of the canvas is not shown", () => {
  const view = viewOf(10, 10, 100, 100);
  view.zoomBy(5, 0, 0);
  view.place(100, 100, 1);
  assert.ok(view.shows(0.5, 0.5, 1));
  assert.ok(!view.shows(9.5, 0.5, 1));
  assert.ok(!view.shows(0.5, 9.5, 1));
});

test("names of tracks leave out what their titles share, and are letters if that is too little", () => {
  const of = (...backends) => backends.map((backend) => `greedy on the ${backend} backend, seed 12`);
  assert.deepEqual(shortNames(of("grid", "physics")), ["grid", "physics"]);
  assert.deepEqual(shortNames(["x y x", "x z x", "x x x"]), ["y", "z", "x"]);
  for (const titles of [["a b", "a b"], ["a", "a b"], ["x y x", "x x"], ["c".repeat(99), "d"]]) {
    assert.deepEqual(shortNames(titles), ["A", "B"]);
  }
});

test("a robot that one of the tracks does not have is not chosen", () => {
  const player = { tracks: [{ robots: 4 }, { robots: 2 }], draw() {} };
  for (const [robot, chosen] of [[1, 1], [2, null], [0, 0], [-1, null], [1, 1], [Number.NaN, null], [0, 0], [null, null]]) {
    Player.prototype.choose.call(player, robot);
    assert.equal(player.chosen, chosen, `${robot}`);
  }
});
