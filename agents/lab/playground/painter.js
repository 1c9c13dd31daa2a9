// Layout that is painted with the mouse or the keyboard.

const MOVES = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/** Return rows of another size: cut off, or with walls added. */
export function resized(rows, height, width) {
  return Array.from({ length: height }, (_, row) => (rows[row] ?? "").slice(0, width).padEnd(width, "#"));
}

export class Painter {
  /**
   * @param {object} drawing module that draws the floors of the player.
   * @param {(rows: string[]) => void} changed function that is called with the rows after each change.
   */
  constructor(floor, choices, drawing, changed) {
    const { wall, P, D, C } = drawing.LOOK.words;
    Object.assign(this, { floor, choices, drawing, changed, rows: [], names: { "#": wall, ".": "empty", P, D, C } });
    for (const [tile, name] of Object.entries(this.names)) {
      const label = document.createElement("label");
      const choice = Object.assign(document.createElement("input"), { type: "radio", name: "tile", value: tile, checked: tile === "#" });
      label.append(choice, ` ${name}`);
      choices.append(label);
    }
    this.canvas = document.createElement("canvas");
    new ResizeObserver(() => this.draw()).observe(floor);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    floor.addEventListener("pointerdown", (event) => this.paintAt(event));
    floor.addEventListener("pointermove", (event) => event.buttons && this.paintAt(event));
    floor.addEventListener("keydown", (event) => this.press(event));
  }

  get tile() {
    return this.choices.querySelector("input:checked").value;
  }

  show(rows) {
    this.rows = rows;
    this.floor.style.setProperty("--columns", rows[0].length);
    const lines = rows.map((tiles, row) => {
      const line = document.createElement("div");
      line.setAttribute("role", "row");
      line.append(...[...tiles].map((tile, column) => this.cell(tile, row, column)));
      return line;
    });
    this.floor.replaceChildren(this.canvas, ...lines);
    this.draw();
  }

  cell(tile, row, column) {
    const cell = document.createElement("button");
    cell.type = "button";
    cell.setAttribute("role", "gridcell");
    cell.tabIndex = row || column ? -1 : 0;
    Object.assign(cell.dataset, { row, column });
    this.name(cell, tile);
    return cell;
  }

  name(cell, tile) {
    const { row, column } = cell.dataset;
    cell.dataset.tile = tile;
    cell.ariaLabel = `row ${row}, column ${column}: ${this.names[tile]}`;
  }

  /** Draw the floor as the player does, behind its cells. */
  draw() {
    const { canvas, rows, drawing } = this;
    const { Brush, View, drawFloor, drawLetters, readTheme } = drawing;
    const [theme, height, width, tiles] = [readTheme(), rows.length, rows[0]?.length, rows.join("")];
    const size = [canvas.clientWidth, canvas.clientHeight].map((pixels) => Math.round(pixels * theme.density));
    if (size.includes(0)) return;
    [canvas.width, canvas.height] = size;
    const view = new View(width, height, 0);
    view.place(...size, theme.density);
    const brush = new Brush(canvas.getContext("2d"), view, theme);
    const rowAndColumn = (cell) => [Math.floor(cell / width), cell % width];
    const track = { width, height, rowAndColumn, outer: 0, slippery: [], bodies: 0, tiles: [tiles], tileAt: [0] };
    drawFloor(brush, track, tiles);
    drawLetters(brush, track, { frame: 0 });
  }

  paintAt(event) {
    const cell = document.elementFromPoint(event.clientX, event.clientY)?.closest("[data-tile]");
    if (cell && this.floor.contains(cell)) this.paint(cell, this.tile);
  }

  paint(cell, tile) {
    if (cell.dataset.tile === tile) return;
    const [row, column] = [Number(cell.dataset.row), Number(cell.dataset.column)];
    const old = this.rows[row];
    this.rows = this.rows.with(row, old.slice(0, column) + tile + old.slice(column + 1));
    this.name(cell, tile);
    this.draw();
    this.changed(this.rows);
  }

  press(event) {
    const cell = event.target.closest("[data-tile]");
    if (!cell) return;
    const tile = event.key.toUpperCase();
    if (tile in this.names) this.paint(cell, tile);
    if (!(event.key in MOVES)) return;
    event.preventDefault();
    const [down, right] = MOVES[event.key];
    const [row, column] = [Number(cell.dataset.row) + down, Number(cell.dataset.column) + right];
    this.floor.querySelector(`[data-row="${row}"][data-column="${column}"]`)?.focus();
  }
}
