// The orders of a fleet at any step. Nothing is drawn here.

const LATE = 3;

/** Return the age of an order: the third of its time that it is in, or 3 when it is late. */
export function ageOf(orders, order, step) {
  const [released, due] = [orders.released[order], orders.due[order]];
  if (step > due) return LATE;
  const third = Math.floor((LATE * (step - released)) / Math.max(due - released, 1));
  return Math.min(Math.max(third, 0), LATE - 1);
}

/** Return the orders that wait after a step, the one due first first. */
export function waitingAt(orders, step) {
  const found = [];
  for (let order = 0; order < orders.released.length; order++) {
    const isTaken = orders.taken[order] >= 0 && orders.taken[order] <= step;
    if (orders.released[order] <= step && !isTaken) found.push(order);
  }
  return found.sort((a, b) => orders.due[a] - orders.due[b]);
}

/** Return for each pickup where orders wait their number and the greatest age. */
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

/** Return the order that a robot carries or was last assigned after a step, or -1. */
export function orderOf(fleet, robot, step) {
  const { orders, assigned } = fleet;
  for (let order = 0; order < orders.released.length; order++) {
    const isTaken = orders.takenBy[order] === robot && orders.taken[order] <= step;
    if (isTaken && !(orders.delivered[order] >= 0 && orders.delivered[order] <= step)) return order;
  }
  const count = assigned.length / 3;
  for (let i = count - 1; i >= 0; i--) {
    if (assigned[i] <= step && assigned[count + i] === robot) {
      const order = assigned[2 * count + i];
      const isTaken = order >= 0 && orders.taken[order] >= 0 && orders.taken[order] <= step;
      return isTaken ? -1 : order;
    }
  }
  return -1;
}

/** Return what a robot did up to a step, the last first: step, "picked" or "delivered", order. */
export function historyOf(orders, robot, step) {
  const found = [];
  for (let order = 0; order < orders.released.length; order++) {
    if (orders.takenBy[order] !== robot) continue;
    const [taken, delivered] = [orders.taken[order], orders.delivered[order]];
    if (taken >= 0 && taken <= step) found.push({ step: taken, what: "picked", order });
    if (delivered >= 0 && delivered <= step) found.push({ step: delivered, what: "delivered", order });
  }
  return found.sort((a, b) => b.step - a.step);
}

/** Return the cell of a robot's next station: the pickup or the dropoff of its order, or -1. */
export function goalOf(track, robot, step) {
  if (!track.fleet?.orders) return -1;
  const { orders } = track.fleet;
  const order = orderOf(track.fleet, robot, step);
  if (order < 0) return -1;
  const isTaken = orders.taken[order] >= 0 && orders.taken[order] <= step;
  return isTaken ? orders.dropoff[order] : orders.pickup[order];
}

/** Return words on the age of an order. */
export function ageWords(orders, order, step) {
  return ["new", "older", "nearly due", "late"][ageOf(orders, order, step)];
}
