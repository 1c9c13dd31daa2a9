// A chart beside the floor: its lines so far in full, what is to come pale, and a cursor.

import { element } from "./elements.js";
import { extent, shown, ticks } from "./scale.js";
import { indexAt } from "./track.js";

const HEIGHT = 110;
const [LEFT, RIGHT, TOP, BOTTOM] = [50, 10, 8, 20];
const PALE = 0.25;

/** Times of charts have single precision. */
const ROUNDING = 1e-3;
const DASHES = [[], [6, 4], [2, 3], [8, 3, 2, 3]];

export class Chart {
  /** Args: the data of a chart, the names of the tracks, the end of time, what a click calls. */
  constructor(data, names, end, goTo) {
    this.data = data;
    const { series } = data;
    this.names = series.every(({ track }) => track === series[0].track) ? [] : names;
    this.end = Math.max(end, 1e-9);
    this.range = extent(series.map(({ y }) => y));
    this.caption = element("figcaption");
    this.canvas = element("canvas");
    this.canvas.setAttribute("role", "img");
    this.element = element("figure", { className: "chart" }, this.caption, this.canvas);
    const seek = (event) => {
      if (event.buttons & 1) goTo(this.timeAt(event.offsetX));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.canvas.addEventListener("pointermove", seek);
  }

  timeAt(x) {
    const share = (x - LEFT) / (this.canvas.clientWidth - LEFT - RIGHT);
    return Math.min(Math.max(share, 0), 1) * this.end;
  }

  /** Draw the chart at a time, in the colours of a theme. */
  draw(time, theme) {
    this.say(time, theme);
    const width = Math.round(this.canvas.clientWidth * theme.density);
    if (!width) return;
    const height = Math.round(HEIGHT * theme.density);
    const key = `${width} ${theme.key}`;
    if (key !== this.key) this.prepare(width, height, theme);
    this.key = key;
    const context = this.canvas.getContext("2d");
    const x = Math.round(this.x(time));
    context.clearRect(0, 0, width, height);
    context.globalAlpha = PALE;
    context.drawImage(this.lines, 0, 0);
    context.globalAlpha = 1;
    context.save();
    context.beginPath();
    context.rect(0, 0, x, height);
    context.clip();
    context.drawImage(this.lines, 0, 0);
    context.restore();
    context.drawImage(this.axes, 0, 0);
    context.fillStyle = theme.accent;
    context.fillRect(x, 0, Math.max(1, Math.round(1.5 * theme.density)), height - BOTTOM * theme.density);
  }

  /** Write the values at a time above the chart. */
  say(time, theme) {
    const words = this.data.series.map((series) => {
      const name = [this.names[series.track], series.name].filter(Boolean).join(" ");
      const now = time + ROUNDING;
      const known = series.x.length && series.x[0] <= now;
      const value = known ? shown(series.y[indexAt(series.x, now)]) : "\u2013";
      return { series, text: `${name} ${value}` };
    });
    const text = `${this.data.title}: ${words.map((word) => word.text).join(", ")}`;
    if (text === this.text && theme.key === this.spokenKey) return;
    [this.text, this.spokenKey] = [text, theme.key];
    this.canvas.setAttribute("aria-label", text);
    this.caption.replaceChildren(
      element("strong", {}, this.data.title),
      ...words.map(({ series, text: value }) => {
        const className = `key ${series.kind} ${series.track ? "other" : ""}`;
        const span = element("span", { className }, value);
        span.style.setProperty("--key", theme[series.color]);
        return span;
      }),
    );
  }

  /** Draw axes and lines once; they stay the same until the size or the colours change. */
  prepare(width, height, theme) {
    Object.assign(this, { width, height, density: theme.density });
    Object.assign(this.canvas, { width, height });
    [this.axes, this.lines] = [element("canvas", { width, height }), element("canvas", { width, height })];
    this.drawAxes(this.axes.getContext("2d"), theme);
    for (const series of this.data.series) this.drawSeries(this.lines.getContext("2d"), series, theme);
  }

  x(time) {
    const room = this.width - (LEFT + RIGHT) * this.density;
    return LEFT * this.density + (Math.min(time, this.end) / this.end) * room;
  }

  y(value) {
    const [low, high] = this.range;
    const room = this.height - (TOP + BOTTOM) * this.density;
    return TOP * this.density + ((high - value) / (high - low)) * room;
  }

  drawAxes(context, theme) {
    context.font = `${12 * theme.density}px system-ui, sans-serif`;
    context.fillStyle = theme.quiet;
    context.textBaseline = "middle";
    context.textAlign = "right";
    for (const value of ticks(...this.range, 3)) {
      const y = Math.round(this.y(value));
      context.fillText(shown(value), (LEFT - 6) * theme.density, y);
      context.globalAlpha = value === 0 ? 0.6 : 0.2;
      context.fillRect(LEFT * theme.density, y, this.width - (LEFT + RIGHT) * theme.density, 1);
      context.globalAlpha = 1;
    }
    context.textBaseline = "bottom";
    context.textAlign = "center";
    for (const value of ticks(0, this.end, 5)) {
      const words = shown(value, 1);
      const half = context.measureText(words).width / 2;
      context.fillText(words, Math.min(this.x(value), this.width - half), this.height - 2);
    }
  }

  drawSeries(context, series, theme) {
    const color = theme[series.color];
    context.strokeStyle = color;
    context.fillStyle = color;
    context.lineWidth = (series.kind === "thin" ? 1 : 2) * theme.density;
    context.lineJoin = "round";
    context.setLineDash(DASHES[series.track % DASHES.length].map((part) => part * theme.density));
    if (series.kind === "bars") this.drawBars(context, series);
    else if (series.kind === "dots") this.drawDots(context, series, theme);
    else this.drawLine(context, series);
  }

  drawLine(context, { kind, x, y }) {
    context.beginPath();
    let isDown = false;
    for (let i = 0; i < x.length; i++) {
      if (Number.isNaN(y[i])) {
        isDown = false;
        continue;
      }
      const [px, py] = [this.x(x[i]), this.y(y[i])];
      if (!isDown) context.moveTo(px, py);
      else {
        if (kind !== "line") context.lineTo(px, this.y(y[i - 1]));
        context.lineTo(px, py);
      }
      isDown = true;
    }
    context.stroke();
  }

  drawBars(context, { x, y }) {
    const room = (this.x(this.end) - this.x(0)) / Math.max(x.length, 1);
    const width = Math.max(1, Math.min(0.6 * room, 6 * this.density));
    for (let i = 0; i < x.length; i++) {
      const [top, bottom] = [this.y(Math.max(y[i], 0)), this.y(Math.min(y[i], 0))];
      context.fillRect(this.x(x[i]) - width / 2, top, width, Math.max(bottom - top, 1));
    }
  }

  drawDots(context, { x, y }, theme) {
    const radius = 2.5 * theme.density;
    context.beginPath();
    for (let i = 0; i < x.length; i++) {
      const [px, py] = [this.x(x[i]), this.y(y[i])];
      context.moveTo(px + radius, py);
      context.arc(px, py, radius, 0, 2 * Math.PI);
    }
    context.fill();
  }
}
