// The part of the page about a fleet: the chosen robot, where robots were held up, and waiting orders.

import { kept } from "./canvas.js";
import { copy, element, partOf, setText } from "./elements.js";
import { heatOf, highestOf, mapOf } from "./floor.js";
import { AGES, ageOf, historyOf, isTaken, orderOf, waitingAt } from "./orders.js";
import { shown, stepsOf } from "./scale.js";
import { heldUpUntil } from "./track.js";

const MAX_ROWS = 8;

export class FleetPanel {
  /** Args: the `Track` of a fleet, and the `Player` of the page. */
  constructor(track, player) {
    Object.assign(this, { track, player });
    this.element = copy("fleet-template");
    this.find = (name) => partOf(this.element, name);
    this.number = this.find("number");
    this.find("name").textContent = track.title;
    this.element.ariaLabel = `Fleet: ${track.title}`;
    this.number.max = track.robots - 1;
    this.number.addEventListener("input", () => player.choose(Number.parseInt(this.number.value, 10)));
    this.find("heat").addEventListener("change", (event) => {
      player.hasHeat = event.target.checked; // on all floors
      for (const fleet of player.fleets) fleet.find("heat").checked = player.hasHeat;
      player.draw();
    });
    this.map = this.find("map");
    Object.assign(this.map, { width: track.width, height: track.height });
    this.find("heat-map").hidden = !track.fleet.heldUp.step.length;
    this.orders = this.find("orders");
    this.orders.hidden = !track.fleet.orders;
  }

  /** Show everything about a moment, if the step or the robot has changed. */
  draw(time) {
    const moment = this.track.at(time);
    const { chosen: robot, theme } = this.player;
    kept(this, "map", `${moment.step} ${theme.key}`, () => this.drawMap(moment, theme));
    kept(this, "words", `${moment.frame} ${robot}`, () => {
      this.sayRobot(robot, moment);
      if (this.track.fleet.orders) this.sayOrders(moment.step);
    });
  }

  /** Draw a map of where robots were held up so far, one pixel per cell, and name the worst cell. */
  drawMap(moment, theme) {
    const { track, map } = this;
    const context = map.getContext("2d");
    context.drawImage(mapOf(track, track.tileAt[moment.frame], theme), 0, 0);
    context.drawImage(heatOf(track, moment.step, theme), 0, 0);
    this.find("ramp").style.background = `linear-gradient(to right, ${theme.heat.join()})`;
    const [cell, most] = highestOf([...heldUpUntil(track, moment.step)]);
    const [row, column] = track.rowAndColumn(cell);
    const place = `most often at row ${row}, column ${column}`;
    const none = "No robot was held up so far.";
    const times = most === 1 ? "1 time" : `${most} times`;
    this.find("scale").hidden = !most;
    setText(this.find("most"), times);
    setText(this.find("peak"), most ? place : none);
    map.ariaLabel = most ? `Robots were held up ${place}: ${times}` : none;
  }

  sayRobot(robot, moment) {
    this.find("robot").hidden = robot === null;
    this.find("hint").hidden = robot !== null;
    if (robot === null) return;
    if (document.activeElement !== this.number) this.number.value = robot;
    const { track } = this;
    const pose = track.pose(robot, moment);
    const level = track.batteryLevel(robot, moment.frame);
    setText(this.find("battery"), level > 0 ? `${shown(100 * level, 0)}%` : "empty");
    setText(this.find("where"), `row ${Math.floor(pose.y)}, column ${Math.floor(pose.x)}`);
    setText(this.find("order"), this.orderWords(robot, moment));
    setText(this.find("history"), this.historyWords(robot, moment.step));
  }

  orderWords(robot, { frame, step }) {
    const { track } = this;
    if (!track.fleet.orders) return track.isLoaded(robot, frame) ? "loaded" : "";
    const { orders } = track.fleet;
    const order = orderOf(track.fleet, robot, step);
    if (order < 0) return "none";
    const [words, goals] = isTaken(orders, order, step)
      ? ["carried to", orders.dropoff]
      : ["to be picked up at", orders.pickup];
    const due = orders.due[order] - step;
    const time = due >= 0 ? `due in ${stepsOf(due)}` : `${stepsOf(-due)} late`;
    return `${order}, ${words} ${this.cellWords(goals[order])}, ${time}`;
  }

  historyWords(robot, step) {
    const { track } = this;
    if (!track.fleet.orders) return "";
    const { orders } = track.fleet;
    const lines = historyOf(orders, robot, step).map(({ step: at, what, order }) => {
      const late = what === "delivered" ? at - orders.due[order] : 0;
      return `step ${at}: ${what} order ${order}${late > 0 ? `, ${stepsOf(late)} late` : ""}`;
    });
    return lines.join("\n") || "nothing yet";
  }

  sayOrders(step) {
    const { orders } = this.track.fleet;
    const waiting = waitingAt(orders, step);
    setText(partOf(this.orders, "waiting"), `${waiting.length} waiting (times in steps)`);
    const rows = waiting.slice(0, MAX_ROWS).map((order) => {
      const due = orders.due[order] - step;
      const cells = [
        String(order),
        this.cellWords(orders.pickup[order]),
        String(step - orders.released[order]),
        due >= 0 ? `in ${due}` : `${-due} late`,
        AGES[ageOf(orders, order, step)],
      ];
      return element("tr", {}, ...cells.map((text) => element("td", {}, text)));
    });
    partOf(this.orders, "rows").replaceChildren(...rows);
  }

  cellWords(cell) {
    return `(${this.track.rowAndColumn(cell).join(", ")})`;
  }
}
