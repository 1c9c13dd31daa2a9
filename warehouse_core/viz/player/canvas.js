// Canvases: the colours of the page, where the floor is in a canvas, and a brush that draws there.

import PALETTE from "../../render/palette.json" with { type: "json" };
import LOOK from "../../render/tiles.json" with { type: "json" };

/** The size of the smallest text, in pixels of the style sheet. */
export const MIN_TEXT = 11;

/** The size from which on bold text is legible with less contrast (WCAG 1.4.3). */
export const LARGE_TEXT = 19;

/** Names of the colours of orders by their age: new, older, nearly due and late. */
const ORDERS = ["item", "order-older", "order-nearly-due", "order-late"];

const MAX_CELL = 96;
const MAX_ZOOM = 64;

/** Return what a function makes for a key; it is made again only for another key. */
export function kept(owner, name, key, make) {
  owner.kept ??= {};
  if (owner.kept[name]?.key !== key) owner.kept[name] = { key, made: make() };
  return owner.kept[name].made;
}

/** Return the theme of the page, light or dark; the same object until something changes. */
export function readTheme() {
  const scheme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  const key = `${scheme} ${devicePixelRatio}`;
  return kept(readTheme, "theme", key, () => {
    const orders = ORDERS.map((name) => PALETTE.both[name]);
    const heat = PALETTE.heat[scheme];
    return { ...PALETTE.both, ...PALETTE[scheme], orders, heat, density: devicePixelRatio, key };
  });
}

/** Where the floor is in a canvas: places are in cells, pixels are those of the device. */
export class View {
  /** Args: columns and rows of the floor, and the cells around it that are shown too. */
  constructor(columns, rows, margin) {
    Object.assign(this, { columns, rows, margin });
    this.fit();
  }

  fit() {
    this.zoom = 1;
    this.middle = [this.columns / 2, this.rows / 2];
  }

  /** Fit the floor into a canvas of a size in pixels, times the zoom. */
  place(canvasWidth, canvasHeight, density) {
    Object.assign(this, { canvasWidth, canvasHeight });
    const [wide, high] = [this.columns + 2 * this.margin, this.rows + 2 * this.margin];
    const fitting = Math.min(canvasWidth / wide, canvasHeight / high);
    this.scale = Math.min(fitting, MAX_CELL * density) * this.zoom;
    this.middle = [
      this.clamp(this.middle[0], this.columns, canvasWidth),
      this.clamp(this.middle[1], this.rows, canvasHeight),
    ];
    this.left = canvasWidth / 2 - this.middle[0] * this.scale;
    this.top = canvasHeight / 2 - this.middle[1] * this.scale;
  }

  /** Keep the middle of the view so that the floor fills the canvas, or is in its middle. */
  clamp(middle, cells, pixels) {
    const half = pixels / this.scale / 2 - this.margin;
    return 2 * half >= cells - 1e-9 ? cells / 2 : Math.min(Math.max(middle, half), cells - half);
  }

  x(column) {
    return this.left + column * this.scale;
  }

  y(row) {
    return this.top + row * this.scale;
  }

  /** Return a box of whole pixels around cells, so that edges are sharp. */
  box(column, row, columns = 1, rows = 1, inset = 0) {
    const [x, y] = [Math.round(this.x(column + inset)), Math.round(this.y(row + inset))];
    const [right, bottom] = [this.x(column + columns - inset), this.y(row + rows - inset)];
    return [x, y, Math.max(1, Math.round(right) - x), Math.max(1, Math.round(bottom) - y)];
  }

  /** Return the place in cells of a point in pixels. */
  cellAt(x, y) {
    return [(x - this.left) / this.scale, (y - this.top) / this.scale];
  }

  /** Return whether a place is in the canvas, with a margin in cells. */
  shows(x, y, margin) {
    const [px, py, space] = [this.x(x), this.y(y), margin * this.scale];
    const isAcross = px > -space && px < this.canvasWidth + space;
    return isAcross && py > -space && py < this.canvasHeight + space;
  }

  /** Zoom by a factor around a point in pixels. */
  zoomBy(factor, x, y) {
    const around = this.cellAt(x, y);
    const zoom = Math.min(Math.max(this.zoom * factor, 1), MAX_ZOOM);
    const ratio = this.zoom / zoom;
    this.zoom = zoom;
    this.middle = this.middle.map((part, axis) => around[axis] + (part - around[axis]) * ratio);
  }

  moveBy(x, y) {
    this.middle = [this.middle[0] - x / this.scale, this.middle[1] - y / this.scale];
  }

  /** The width of what is shown, divided by its height. */
  get aspect() {
    return (this.columns + 2 * this.margin) / (this.rows + 2 * this.margin);
  }

  /** A text that differs between views that draw the floor differently. */
  get key() {
    return [this.left, this.top, this.scale, this.canvasWidth, this.canvasHeight].join(" ");
  }
}

/**
 * Draws on a canvas in the colours of a theme, which are given by their names. Places and sizes are
 * in pixels, but those of `fill` and `line`, which are in cells.
 */
export class Brush {
  constructor(context, view, theme) {
    Object.assign(this, { context, view, theme });
    this.scale = view?.scale;
    this.minText = MIN_TEXT * theme.density;
  }

  color(name) {
    return this.theme[name] ?? name;
  }

  /** Fill the box of some cells: column, row, columns, rows and inset. */
  fill(color, ...box) {
    this.rect(color, ...this.view.box(...box));
  }

  rect(color, x, y, width, height) {
    this.context.fillStyle = this.color(color);
    this.context.fillRect(x, y, width, height);
  }

  /** Begin a path in a colour. */
  begin(color) {
    const style = this.color(color);
    Object.assign(this.context, { fillStyle: style, strokeStyle: style });
    this.context.beginPath();
  }

  /** Draw a line through places in cells. */
  line(color, width, places) {
    const { context, view } = this;
    Object.assign(context, { strokeStyle: this.color(color), lineWidth: width, lineJoin: "round" });
    context.beginPath();
    for (const [x, y] of places) context.lineTo(view.x(x), view.y(y));
    context.stroke();
  }

  /** Add a shape of tiles.json to the path, so many pixels a cell, turned by an angle. */
  trace(name, x, y, pixels, angle = 0) {
    const [right, down] = [pixels * Math.cos(angle), pixels * Math.sin(angle)];
    LOOK.shapes[name].forEach(([along, across], i) => {
      const corner = [x + along * right - across * down, y + along * down + across * right];
      if (i) this.context.lineTo(...corner);
      else this.context.moveTo(...corner);
    });
    this.context.closePath();
  }

  /** Add a circle to the path. */
  circle(x, y, radius) {
    this.context.moveTo(x + radius, y);
    this.context.arc(x, y, radius, 0, 2 * Math.PI);
  }

  /** Fill the path, and draw a line around it. */
  paint(color, lineColor, lineWidth) {
    const { context } = this;
    const strokeStyle = this.color(lineColor);
    Object.assign(context, { fillStyle: this.color(color), strokeStyle, lineWidth, lineJoin: "round" });
    context.fill();
    context.stroke();
  }

  /** Set the size of the text that follows, which is written around its middle. */
  centerText(size, weight = "bold") {
    const font = `${weight} ${Math.round(size)}px system-ui, sans-serif`;
    Object.assign(this.context, { font, textAlign: "center", textBaseline: "middle" });
  }

  widthOf(text) {
    return this.context.measureText(text).width;
  }

  write(color, text, x, y) {
    this.context.fillStyle = this.color(color);
    this.context.fillText(text, x, y);
  }

  /** Write text with an outline: the contrast of small text does not depend on what is behind it. */
  writeOutlined(color, lineColor, text, x, y) {
    const { context } = this;
    Object.assign(context, { strokeStyle: this.color(lineColor), lineWidth: this.minText / 4, lineJoin: "round" });
    context.strokeText(text, x, y);
    this.write(color, text, x, y);
  }

  /** Write a label over a place, within the width of the canvas. */
  label(background, color, text, x, bottom, size) {
    this.centerText(size);
    const width = this.widthOf(text) + size;
    const middle = Math.min(Math.max(x, width / 2), this.context.canvas.width - width / 2);
    this.rect(background, middle - width / 2, bottom - 1.4 * size, width, 1.4 * size);
    this.write(color, text, middle, bottom - 0.68 * size);
  }
}
