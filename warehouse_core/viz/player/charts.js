// A chart next to the floor. The part after the present time is pale, and a cursor marks the time.

import { drawn, element, setText } from "./elements.js";
import { extent, inTime, shown, stepsOf, ticks } from "./scale.js";
import { indexAt } from "./track.js";

/** The height of the lines, and the space to their left and right, as in the style sheet. */
const [HEIGHT, LEFT, RIGHT] = [82, 74, 10];

/** The widest bar, as a share of the time. */
const MAX_BAR = 0.02;

/** The share of the time after which a number below the axis is right-aligned, so that it fits. */
const LAST = 0.97;

/** The tolerance of times, which have single precision in charts. */
const ROUNDING = 1e-3;

export class Chart {
  /** Args: the data of a chart, the names of the tracks, the last time, and the function for a click. */
  constructor(data, names, end, goTo) {
    const { title, series } = data;
    this.data = data;
    this.names = series.every(({ track }) => track === series[0].track) ? [] : names;
    this.end = Math.max(end, 1e-9);
    [this.low, this.high] = extent(series.map(({ y }) => y));
    this.values = series.map(({ kind, color, track }) =>
      keyed(element("span", { className: `key ${kind} ${track ? "other" : ""}` }), color));
    this.veil = drawn("rect", { class: "veil", height: HEIGHT });
    this.cursor = drawn("line", { class: "cursor", y2: HEIGHT });
    const lines = series.map((each) =>
      keyed(drawn("path", { class: `${each.kind} of-${each.track}`, d: this.pathOf(each) }), each.color));
    const size = { viewBox: `0 0 1 ${HEIGHT}`, preserveAspectRatio: "none", width: "100%", height: HEIGHT };
    const area = drawn("svg", { ...size, "aria-hidden": true }, ...lines, this.veil);
    this.svg = drawn("svg", { role: "img" }, area, ...this.axes(), this.cursor);
    const caption = element("figcaption", {}, element("strong", {}, title), ...this.values);
    this.element = element("figure", { className: "chart" }, caption, this.svg);
    const seek = (event) => {
      if (event.buttons & 1) goTo(this.timeAt(event.clientX - this.svg.getBoundingClientRect().left));
    };
    this.svg.addEventListener("pointerdown", (event) => {
      this.svg.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.svg.addEventListener("pointermove", seek);
  }

  timeAt(x) {
    const share = (x - LEFT) / (this.svg.getBoundingClientRect().width - LEFT - RIGHT);
    return Math.min(Math.max(share, 0), 1) * this.end;
  }

  /** Show a time, and write the values at this time above the chart. */
  draw(time) {
    const words = this.data.series.map(({ track, name, steps, x, y }) => {
      const now = time + ROUNDING;
      const value = x.length && x[0] <= now ? y[indexAt(x, now)] : null;
      const text = value === null ? [name, "\u2013"]
        : steps ? [stepsOf(Math.abs(value)), steps]
        : [name, shown(value)];
      return [this.names[track], ...text].filter(Boolean).join(" ");
    });
    for (const [i, text] of words.entries()) setText(this.values[i], text);
    this.text = `${this.data.title}: ${words.join(", ")}`;
    if (this.svg.ariaLabel !== this.text) this.svg.ariaLabel = this.text;
    const share = time / this.end;
    this.veil.setAttribute("x", share);
    this.veil.setAttribute("width", 1 - share);
    for (const end of ["x1", "x2"]) this.cursor.setAttribute(end, `${100 * share}%`);
  }

  /** Return the height of a value, in pixels from the top. */
  y(value) {
    return ((this.high - value) / (this.high - this.low)) * HEIGHT;
  }

  /** Return the numbers along both axes, and the horizontal lines. */
  axes() {
    // Three ticks of values on both sides of 0 may be 0 alone, which has no side.
    const [words, count] = this.data.series.some(({ steps }) => steps) ? [inTime, 5] : [shown, 3];
    const across = ticks(this.low, this.high, count).flatMap((value) => [
      drawn("text", { x: -6, y: this.y(value), class: "left" }, words(value)),
      drawn("line", { x2: "100%", y1: this.y(value), y2: this.y(value), class: value === 0 ? "zero" : "" }),
    ]);
    const down = ticks(0, this.end, 5).map((value) => {
      const share = value / this.end;
      const place = { x: `${100 * share}%`, y: HEIGHT + 16, class: share > LAST ? "last" : "" };
      return drawn("text", place, shown(value, 1));
    });
    return [...across, ...down];
  }

  /** Return the path of a series: horizontally in shares of the time, vertically in pixels. */
  pathOf({ kind, x, y }) {
    const places = Array.from(x, (time, i) => [Math.min(time, this.end) / this.end, this.y(y[i])]);
    if (kind === "dots") return places.map(([px, py]) => `M${px} ${py}h0`).join("");
    if (kind === "bars") {
      const width = Math.min(0.6 / Math.max(x.length, 1), MAX_BAR);
      return places.map(([px, py]) => `M${px - width / 2} ${this.y(0)}h${width}V${py}h${-width}z`).join("");
    }
    let isDown = false;
    return places.map(([px, py]) => {
      const wasDown = isDown;
      isDown = !Number.isNaN(py);
      if (!isDown) return "";
      if (!wasDown) return `M${px} ${py}`;
      return kind === "line" ? `L${px} ${py}` : `H${px}V${py}`;
    }).join("");
  }
}

/** Give an element a colour of the palette, which follows the colour scheme. */
function keyed(keyedElement, color) {
  keyedElement.style.setProperty("--key", `var(--${color})`);
  return keyedElement;
}
