// Canvases: the colours of the page, the position of the floor in a canvas, and a brush that draws on it.

import PALETTE from "../../render/palette.json" with { type: "json" };
import LOOK from "../../render/tiles.json" with { type: "json" };

/** The size of the smallest text, in CSS pixels. */
export const MIN_TEXT = 11;

/** The size, in CSS pixels, from which on bold text needs less contrast (WCAG 1.4.3). */
export const LARGE_TEXT = 19;

const MAX_CELL = 96;
const MAX_ZOOM = 64;

/** Return the result of `make` for a key. It is stored, and made again only when the key changes. */
export function kept(owner, name, key, make) {
  owner.kept ??= {};
  if (owner.kept[name]?.key !== key) owner.kept[name] = { key, made: make() };
  return owner.kept[name].made;
}

/** Return the theme of the page, light or dark. It is the same object until something changes. */
export function readTheme() {
  const scheme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  const key = `${scheme} ${devicePixelRatio}`;
  return kept(readTheme, "theme", key, () => {
    const orders = LOOK.orders.map((name) => PALETTE.both[name]);
    const heat = PALETTE.heat[scheme];
    return { ...PALETTE.both, ...PALETTE[scheme], orders, heat, density: devicePixelRatio, key };
  });
}

/** The position of the floor in a canvas. Places are in cells, and pixels are device pixels. */
export class View {
  /** Args: columns and rows of the floor, and the margin around it, in cells. */
  constructor(columns, rows, margin) {
    Object.assign(this, { columns, rows, margin });
    this.fit();
  }

  fit() {
    this.zoom = 1;
    this.middle = [this.columns / 2, this.rows / 2];
  }

  /** Fit the floor, enlarged by the zoom, into a canvas of a size in pixels. */
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

  /** Return the middle of the view, limited so that the floor fills the canvas or is centred in it. */
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

  /** Return the box of some cells in whole pixels, so that its edges are sharp. */
  box(column, row, columns = 1, rows = 1, inset = 0) {
    const [x, y] = [Math.round(this.x(column + inset)), Math.round(this.y(row + inset))];
    const [right, bottom] = [this.x(column + columns - inset), this.y(row + rows - inset)];
    return [x, y, Math.max(1, Math.round(right) - x), Math.max(1, Math.round(bottom) - y)];
  }

  /** Return the position in cells of a point in pixels. */
  cellAt(x, y) {
    return [(x - this.left) / this.scale, (y - this.top) / this.scale];
  }

  /** Return whether a place is within the canvas or at most a margin, in cells, outside. */
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

  /** The width of the visible area divided by its height. */
  get aspect() {
    return (this.columns + 2 * this.margin) / (this.rows + 2 * this.margin);
  }

  /** A text that is different for views that draw the floor differently. */
  get key() {
    return [this.left, this.top, this.scale, this.canvasWidth, this.canvasHeight].join(" ");
  }
}

/**
 * Draws on a canvas in the colours of a theme, which are given by name. Positions and sizes are in
 * pixels, except for the boxes of `fill` and the points of `line`, which are in cells.
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

  /** Draw a line through points in cells; its width is in pixels. */
  line(color, width, places) {
    const { context, view } = this;
    Object.assign(context, { strokeStyle: this.color(color), lineWidth: width, lineJoin: "round" });
    context.beginPath();
    for (const [x, y] of places) context.lineTo(view.x(x), view.y(y));
    context.stroke();
  }

  /** Add a shape of tiles.json to the path, with `pixels` per cell, turned by an angle. */
  trace(name, x, y, pixels, angle = 0) {
    this.outline(LOOK.shapes[name], x, y, pixels, angle);
  }

  /** Add a polygon around a point to the path. */
  outline(corners, x, y, pixels, angle = 0) {
    const [right, down] = [pixels * Math.cos(angle), pixels * Math.sin(angle)];
    corners.forEach(([along, across], i) => {
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

  /** Fill the path and draw a line around it. */
  paint(color, lineColor, lineWidth) {
    const { context } = this;
    const strokeStyle = this.color(lineColor);
    Object.assign(context, { fillStyle: this.color(color), strokeStyle, lineWidth, lineJoin: "round" });
    context.fill();
    context.stroke();
  }

  /** Set the size of text from now on, and centre it. */
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

  /** Write text with an outline, so that its contrast does not depend on the background. */
  writeOutlined(color, lineColor, text, x, y) {
    const { context } = this;
    Object.assign(context, { strokeStyle: this.color(lineColor), lineWidth: this.minText / 4, lineJoin: "round" });
    context.strokeText(text, x, y);
    this.write(color, text, x, y);
  }

  /** Write a label above a point, within the width of the canvas. */
  label(background, color, text, x, bottom, size) {
    this.centerText(size);
    const width = this.widthOf(text) + size;
    const middle = Math.min(Math.max(x, width / 2), this.context.canvas.width - width / 2);
    this.rect(background, middle - width / 2, bottom - 1.4 * size, width, 1.4 * size);
    this.write(color, text, middle, bottom - 0.68 * size);
  }
}
