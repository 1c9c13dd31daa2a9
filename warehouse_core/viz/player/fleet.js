// What the page tells about a fleet: a chosen robot, and the orders that wait.

import { ageWords, goalOf, historyOf, orderOf, waitingAt } from "./orders.js";
import { copy, setText } from "./panel.js";
import { shown } from "./scale.js";

const MAX_ROWS = 8;

export class FleetPanel {
  /** Args: the `Track` of a fleet, and the page's `Player`. */
  constructor(track, player) {
    Object.assign(this, { track, player });
    this.element = copy("fleet-template");
    this.find = (name) => this.element.querySelector(`[data-part="${name}"]`);
    this.number = this.find("number");
    this.number.max = track.robots - 1;
    this.number.addEventListener("input", () => {
      const robot = Number.parseInt(this.number.value, 10);
      player.choose(robot >= 0 && robot < track.robots ? robot : null);
    });
    this.find("heat").addEventListener("change", (event) => {
      player.hasHeat = event.target.checked;
      player.draw();
    });
    this.find("heat").parentElement.hidden = !track.hits.frame.length;
    this.orders = this.find("orders");
    this.orders.hidden = !track.fleet.orders;
    this.findOrders = (name) => this.orders.querySelector(`[data-part="${name}"]`);
  }

  /** Write everything about a moment, if the step or the robot is another one. */
  draw(time) {
    const { track } = this;
    const moment = track.at(time);
    const step = Math.floor(track.progress[moment.frame]);
    const robot = this.player.chosen;
    const key = `${moment.frame} ${robot}`;
    if (key === this.key) return;
    this.key = key;
    this.sayRobot(robot, moment, step);
    if (track.fleet.orders) this.sayOrders(step);
  }

  sayRobot(robot, moment, step) {
    this.find("robot").hidden = robot === null;
    this.find("hint").hidden = robot !== null;
    if (robot === null) return;
    if (document.activeElement !== this.number) this.number.value = robot;
    const { track } = this;
    const pose = track.pose(robot, moment);
    const level = track.fleet.battery[robot * track.frames + moment.frame];
    setText(this.find("battery"), level > 0 ? `${shown(100 * level, 0)}%` : "empty");
    setText(this.find("where"), `row ${Math.floor(pose.y)}, column ${Math.floor(pose.x)}`);
    setText(this.find("order"), this.orderWords(robot, step));
    setText(this.find("history"), this.historyWords(robot, step));
  }

  orderWords(robot, step) {
    const { track } = this;
    if (!track.fleet.orders) return track.load[robot * track.frames] > 0 ? "loaded" : "";
    const { orders } = track.fleet;
    const order = orderOf(track.fleet, robot, step);
    if (order < 0) return "none";
    const goal = goalOf(track, robot, step);
    const isTaken = goal === orders.dropoff[order];
    const due = orders.due[order] - step;
    const time = due >= 0 ? `due in ${due}` : `late by ${-due}`;
    return `${order}, ${isTaken ? "carried to" : "to be picked at"} ${this.cellWords(goal)}, ${time}`;
  }

  historyWords(robot, step) {
    const { track } = this;
    if (!track.fleet.orders) return "";
    const { orders } = track.fleet;
    const lines = historyOf(orders, robot, step).map(({ step: at, what, order }) => {
      const late = what === "delivered" ? at - orders.due[order] : 0;
      return `step ${at}: ${what} order ${order}${late > 0 ? `, ${late} late` : ""}`;
    });
    return lines.join("\n") || "nothing yet";
  }

  sayOrders(step) {
    const { orders } = this.track.fleet;
    const waiting = waitingAt(orders, step);
    setText(this.findOrders("waiting"), `${waiting.length} waiting`);
    const rows = waiting.slice(0, MAX_ROWS).map((order) => {
      const row = document.createElement("tr");
      const due = orders.due[order] - step;
      const cells = [
        String(order),
        this.cellWords(orders.pickup[order]),
        String(step - orders.released[order]),
        due >= 0 ? `in ${due}` : `${-due} late`,
        ageWords(orders, order, step),
      ];
      for (const text of cells) row.append(Object.assign(document.createElement("td"), { textContent: text }));
      return row;
    });
    this.findOrders("rows").replaceChildren(...rows);
  }

  cellWords(cell) {
    return `(${Math.floor(cell / this.track.width)}, ${cell % this.track.width})`;
  }
}
