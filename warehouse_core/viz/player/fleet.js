// The part of the page about a fleet: the chosen robot, and where robots were held up.

import { kept } from "./canvas.js";
import { copy, partOf, setText } from "./elements.js";
import { heatOf, highestOf, mapOf } from "./floor.js";
import { shown } from "./scale.js";
import { heldUpUntil } from "./track.js";

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
    this.map = this.find("map");
    Object.assign(this.map, { width: track.width, height: track.height });
    this.find("heat-map").hidden = !track.fleet.heldUp.step.length;
  }

  /** Show everything about a moment, if the step or the robot has changed. */
  draw(time) {
    const moment = this.track.at(time);
    const { chosen: robot, theme } = this.player;
    kept(this, "map", `${moment.step} ${theme.key}`, () => this.drawMap(moment, theme));
    kept(this, "words", `${moment.frame} ${robot}`, () => this.sayRobot(robot, moment));
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
    setText(this.find("load"), track.isLoaded(robot, moment.frame) ? "loaded" : "empty");
  }
}
