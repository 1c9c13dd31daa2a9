// Where the floor is in a canvas: places are in cells, pixels are those of the device.

const MAX_CELL = 96;
const MAX_ZOOM = 64;

export class View {
  /** Args: columns and rows of the floor, and the cells around it that are shown too. */
  constructor(width, height, margin) {
    this.columns = width;
    this.rows = height;
    this.margin = margin;
    this.zoom = 1;
    this.middle = [width / 2, height / 2];
  }

  /** Fit the floor into a canvas of a size in pixels, times the zoom. */
  place(canvasWidth, canvasHeight, density) {
    this.canvasWidth = canvasWidth;
    this.canvasHeight = canvasHeight;
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
    const [column, row] = this.cellAt(x, y);
    const zoom = Math.min(Math.max(this.zoom * factor, 1), MAX_ZOOM);
    const ratio = this.zoom / zoom;
    this.zoom = zoom;
    this.middle = [
      column + (this.middle[0] - column) * ratio,
      row + (this.middle[1] - row) * ratio,
    ];
  }

  moveBy(x, y) {
    this.middle = [this.middle[0] - x / this.scale, this.middle[1] - y / this.scale];
  }

  fit() {
    this.zoom = 1;
    this.middle = [this.columns / 2, this.rows / 2];
  }

  /** Return the width of what is shown by its height. */
  get aspect() {
    return (this.columns + 2 * this.margin) / (this.rows + 2 * this.margin);
  }

  /** A text that differs between views that draw the floor differently. */
  get key() {
    return [this.left, this.top, this.scale, this.canvasWidth, this.canvasHeight].join(" ");
  }
}
