// The state of the orders of a fleet after any step. Nothing is drawn here.

import LOOK from "../../render/tiles.json" with { type: "json" };

/** The ages of an order in words: one for each third of its time until due, and one for late orders. */
export const AGES = LOOK.ages;
export const LATE = AGES.length - 1;

/** Return the age of an order: the present third of its time until due, or `LATE`. */
export function ageOf(orders, order, step) {
  const [released, due] = [orders.released[order], orders.due[order]];
  if (step > due) return LATE;
  const third = Math.floor((LATE * (step - released)) / Math.max(due - released, 1));
  return Math.min(Math.max(third, 0), LATE - 1);
}

/** Return whether an order has been picked up after a step. */
export function isTaken(orders, order, step) {
  return isPast(orders.taken[order], step);
}

/** Return whether something that happens at step `at`, or never if it is -1, has happened after a step. */
function isPast(at, step) {
  return at >= 0 && at <= step;
}

/** Return the orders that wait after a step, sorted by the step at which they are due. */
export function waitingAt(orders, step) {
  const found = [];
  for (let order = 0; order < orders.released.length; order++) {
    if (orders.released[order] <= step && !isTaken(orders, order, step)) found.push(order);
  }
  return found.sort((a, b) => orders.due[a] - orders.due[b]);
}

/** Return for each pickup with waiting orders their number and their greatest age. */
export function waitingByPickup(orders, step) {
  const places = new Map();
  for (const order of waitingAt(orders, step)) {
    const pickup = orders.pickup[order];
    const place = places.get(pickup) ?? { count: 0, age: 0 };
    place.count++;
    place.age = Math.max(place.age, ageOf(orders, order, step));
    places.set(pickup, place);
  }
  return places;
}

/** Return the order that a robot carries or is assigned to after a step, or -1. */
export function orderOf({ orders, assigned }, robot, step) {
  const carried = Array.from(orders.taken.keys()).find((order) =>
    orders.takenBy[order] === robot && isTaken(orders, order, step) && !isPast(orders.delivered[order], step));
  if (carried !== undefined) return carried;
  const last = assigned.robot.findLastIndex((each, i) => each === robot && assigned.step[i] <= step);
  const order = assigned.order[last] ?? -1;
  return order < 0 || isTaken(orders, order, step) ? -1 : order;
}

/** Return the actions of a robot up to a step, latest first: step, "picked up" or "delivered", order. */
export function historyOf(orders, robot, step) {
  const found = [];
  for (let order = 0; order < orders.released.length; order++) {
    if (orders.takenBy[order] !== robot) continue;
    for (const [what, at] of [["picked up", orders.taken[order]], ["delivered", orders.delivered[order]]]) {
      if (isPast(at, step)) found.push({ step: at, what, order });
    }
  }
  return found.sort((a, b) => b.step - a.step);
}
