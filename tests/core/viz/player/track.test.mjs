import assert from "node:assert/strict";
import { test } from "node:test";

import {
  angleBetween,
  heldUpUntil,
  indexAt,
  marksUntil,
  nextEvent,
  visitsUntil,
} from "../../../../warehouse_core/viz/player/track.js";
import { along, hitsOf, trackOf } from "./some_tracks.mjs";

test("an index at a time is the last of those that are not later, as a plain search says", () => {
  const times = [0, 1, 1, 1, 2.5, 4];
  for (let time = -1; time <= 5; time += 0.25) {
    assert.equal(indexAt(times, time), Math.max(times.findLastIndex((each) => each <= time), 0), `${time}`);
  }
});

test("a heading turns the short way round", () => {
  assert.equal(angleBetween(0, 30, 0.5), 15);
  assert.equal(angleBetween(110, 10, 0.5), 120);
  assert.equal(angleBetween(10, 110, 0.5), 0);
  assert.equal(angleBetween(60, 60, 0.3), 60);
});

const BODY = { isContinuous: true };

test("a robot on the grid jumps to the next cell, with its heading and its caption", () => {
  const track = trackOf([[[0.5, 0.5, 0, 0], [1.5, 0.5, 1, 30]]]);
  assert.deepEqual(track.pose(0, track.at(0.99)), { x: 0.5, y: 0.5, heading: 0, load: 0 });
  assert.deepEqual(track.pose(0, track.at(1)), { x: 1.5, y: 0.5, heading: Math.PI / 2, load: 1 });
  assert.deepEqual([0.99, 1].map((time) => track.caption(track.at(time))), ["caption 0", "caption 1"]);
  assert.deepEqual([0.99, 1].map((time) => track.stepAt(time)), [0, 1]);
});

test("a body has the velocity of the moment, the force until the next frame, and a brake light", () => {
  const push = { vx: [0, 1, 0], vy: [0, 0, 0], fx: [40, 57, -42], fy: [0, 0, 0] };
  const track = trackOf([along([0, 1, 2])], { ...BODY, ...push });
  assert.deepEqual(track.push(0, track.at(0.25)), { velocity: [0.25, 0], force: [57, 0], brakes: false });
  assert.deepEqual(track.push(0, track.at(1.75)), { velocity: [0.25, 0], force: [-42, 0], brakes: true });
  assert.equal(track.push(0, track.at(1.99)).brakes, false, "it stands almost still");
  assert.equal(trackOf([along([0, 1])], BODY).push(0, { frame: 0 }), null);
});

test("a body glides between two frames and keeps its load until the second", () => {
  const track = trackOf([[[0.5, 0.5, 0, 0], [1.5, 0.5, 1, 30]]], BODY);
  assert.deepEqual(track.pose(0, track.at(0.25)), { x: 0.75, y: 0.5, heading: (7.5 / 120) * 2 * Math.PI, load: 0 });
  assert.deepEqual(track.pose(0, track.at(1)), { x: 1.5, y: 0.5, heading: Math.PI / 2, load: 1 });
});

test("times before the start and after the end are those", () => {
  const track = trackOf([along([0, 1, 2])]);
  assert.equal(track.pose(0, track.at(-3)).x, 0.5);
  assert.equal(track.pose(0, track.at(99)).x, 2.5);
  assert.equal(track.timeOf(-1), 0);
  assert.equal(track.timeOf(99), 2);
});

test("a robot that is not shown in a frame has no pose there and does not glide to it", () => {
  const track = trackOf([[[4.5, 4.5, 0], [0, 0, -1], [5.5, 4.5, 0]]], BODY);
  assert.deepEqual(track.pose(0, track.at(0.5)), { x: 4.5, y: 4.5, heading: null, load: 0 });
  assert.equal(track.pose(0, track.at(1)), null);
  assert.equal(track.pose(0, track.at(1.5)), null);
  assert.equal(track.pose(0, track.at(2)).x, 5.5);
});

test("an unknown heading is none, until it is known", () => {
  const track = trackOf([[[0.5, 0.5, 0], [0.5, 0.5, 0, 30], [0.5, 0.5, 0]]], BODY);
  assert.equal(track.pose(0, track.at(0)).heading, null);
  assert.equal(track.pose(0, track.at(0.5)).heading, Math.PI / 2);
  assert.equal(track.pose(0, track.at(1.5)).heading, null);
});

test("a cell has the row and the column that its number stands for", () => {
  const track = trackOf([[[7.5, 2.5, 0]]], { width: 9 });
  assert.deepEqual(track.rowAndColumn(track.cell(0, 0)), [2, 7]);
});

test("frames within a step belong to it, and each step has the frame in which it is complete", () => {
  const progress = [0, 0.5, 1, 4 / 3, 5 / 3, 2];
  const time = [0, 2, 4, 5, 6, 7];
  const track = trackOf([along([0, 0, 1, 1, 1, 2])], { time, progress, ...BODY });
  assert.deepEqual(track.stepFrames, [0, 2, 5]);
  assert.deepEqual([0, 1, 2, 3].map((step) => track.timeOf(step)), [0, 4, 7, 7]);
  assert.deepEqual([0, 0.1, 2, 4, 4.1, 6.9, 7].map((at) => track.stepAt(at)), [0, 1, 1, 1, 2, 2, 2]);
  assert.equal(track.steps, 2);
  assert.deepEqual([0, 0.1, 3.9, 4, 6.9, 7].map((at) => track.at(at).step), [0, 0, 0, 1, 1, 2]);
});

test("the caption is that of the step under way", () => {
  const track = trackOf([along([0, 1, 2])], BODY);
  assert.equal(track.caption(track.at(1)), "caption 1");
  assert.equal(track.caption(track.at(1.1)), "caption 2");
  track.captionsNext = true;
  assert.equal(track.caption(track.at(1.1)), "caption 1");
});

test("each frame has its own hits", () => {
  const hits = hitsOf([[0, 1, 1, 0], [2, 2, 2, 1], [2, 3, 3, 0]]);
  const track = trackOf([along([0, 0, 0]), along([1, 1, 1])], { hits });
  const shown = [0, 1, 2].map((frame) => track.hitsIn(frame).map((hit) => hit.x));
  assert.deepEqual(shown, [[1], [], [2, 3]]);
  assert.deepEqual(track.hitsIn(2)[0], { x: 2, y: 2, robot: 1, size: 1, label: "12 N·s" });
});

test("a hit that is shown for several frames is one event, and in steps each is one", () => {
  const hits = hitsOf([[1, 1, 1, 0], [2, 1, 1, 0], [2, 2, 2, 0], [3, 2, 2, 0]]);
  const isHit = (isContinuous) => {
    const track = trackOf([along([0, 1, 2, 3])], { hits, isContinuous });
    return [0, 1, 2, 3].map((frame) => track.isHit(0, frame));
  };
  assert.deepEqual(isHit(true), [false, true, true, false]);
  assert.deepEqual(isHit(false), [false, true, true, true]);
});

test("a route is that of its frame", () => {
  const route = { frame: [0, 2, 2], x: [1, 2, 3], y: [4, 5, 6] };
  const track = trackOf([along([0, 1, 2])], { route });
  assert.deepEqual([0, 1, 2].map((frame) => track.routeIn(frame)), [[[1, 4]], [], [[2, 5], [3, 6]]]);
  assert.deepEqual(trackOf([along([0])]).routeIn(0), []);
});

test("the next event is a pick, a drop or a hit, of the robots asked for", () => {
  const loads = [0, 0, 1, 1, 0].map((load, frame) => [frame + 0.5, 0.5, load]);
  const track = trackOf([loads, along([5, 6, 7, 8, 9])], { hits: hitsOf([[3, 8, 1, 1]]) });
  const walk = (bodies) => {
    const found = [];
    for (let event = nextEvent(track, 0, bodies); event; event = nextEvent(track, event.frame, bodies)) {
      found.push([event.frame, event.body, event.what]);
    }
    return found;
  };
  assert.deepEqual(walk([0, 1]), [[2, 0, "pick"], [3, 1, "hit"], [4, 0, "drop"]]);
  assert.deepEqual(walk([1]), [[3, 1, "hit"]]);
});

test("a robot that starts with an item has picked nothing, whatever the one before it did", () => {
  const track = trackOf([along([0, 1]), along([3, 4], 1)]);
  assert.equal(nextEvent(track, 0, [0, 1]), null);
});

test("orders wait after the steps that say so, and a track without any has none", () => {
  const waiting = { step: [0, 2, 2], cell: [5, 5, 7], number: [1, 2, 1], age: [0, 1, 3] };
  const track = trackOf([along([0, 1, 2])], { fleet: { waiting } });
  assert.deepEqual(track.waitingAt(2), [{ cell: 5, count: 2, age: 1 }, { cell: 7, count: 1, age: 3 }]);
  assert.deepEqual(track.waitingAt(1), []);
  assert.equal(trackOf([along([0])]).waitingAt(0), null);
  assert.equal(trackOf([along([0])], { fleet: { waiting: { step: [] } } }).waitingAt(0), null);
});

test("visits and held-up robots are the same after going back as from the start", () => {
  const heldUp = { step: [1, 1, 2, 4], cell: Int32Array.of(1, 4, 4, 1) };
  const fresh = () => trackOf([along([0, 1, 0, 1, 2]), along([2, 4, 4, 4, 4])], { fleet: { heldUp } });
  const used = fresh();
  for (const frame of [4, 1, 3, 0, 2]) {
    assert.deepEqual(visitsUntil(used, 0, frame), visitsUntil(fresh(), 0, frame), `${frame}`);
    assert.deepEqual(heldUpUntil(used, frame), heldUpUntil(fresh(), frame), `${frame}`);
  }
  assert.deepEqual([...visitsUntil(used, 0, 3)], [[0, 2], [1, 2]]);
  assert.deepEqual([...visitsUntil(used, 1, 3)], [[2, 1], [4, 1]]);
  assert.deepEqual([...heldUpUntil(used, 4)], [[1, 2], [4, 2]]);
  assert.deepEqual([...heldUpUntil(used, 1)], [[1, 1], [4, 1]]);
  assert.deepEqual([...heldUpUntil(used, 0)], []);
});

const marks = { time: [0, 1, 1, 3], cell: [5, 6, 5, 7], value: [0, 0, 1, 0] };

test("marks at a time are the last of each cell, however the time came about", () => {
  const track = { marks };
  const at = (time) => [...marksUntil(track, time)];
  assert.deepEqual(at(3), [[5, 1], [6, 0], [7, 0]]);
  assert.deepEqual(at(0.5), [[5, 0]]);
  assert.deepEqual(at(1), [[5, 1], [6, 0]]);
  assert.deepEqual(at(0), [[5, 0]]);
});
