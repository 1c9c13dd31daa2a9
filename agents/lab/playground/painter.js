// A layout that is painted with the mouse or by keys.

/** Tiles by their letters. */
export const TILES = { "#": "wall", ".": "empty", P: "pickup", D: "dropoff", C: "charger" };

const MOVES = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/** Return rows of another size: cut, or with walls added outside. */
export function resized(rows, height, width) {
  return Array.from({ length: height }, (_, row) => (rows[row] ?? "").slice(0, width).padEnd(width, "#"));
}

export class Painter {
  /** @param {(rows: string[]) => void} changed is called with the rows once they are painted. */
  constructor(floor, choices, changed) {
    Object.assign(this, { floor, choices, changed, rows: [] });
    for (const [tile, name] of Object.entries(TILES)) {
      const label = document.createElement("label");
      const choice = Object.assign(document.createElement("input"), { type: "radio", name: "tile", value: tile, checked: tile === "#" });
      label.append(choice, ` ${name}`);
      choices.append(label);
    }
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
    this.floor.replaceChildren(...rows.map((tiles, row) => {
      const line = document.createElement("div");
      line.setAttribute("role", "row");
      line.append(...[...tiles].map((tile, column) => this.cell(tile, row, column)));
      return line;
    }));
  }

  cell(tile, row, column) {
    const cell = document.createElement("button");
    cell.type = "button";
    cell.setAttribute("role", "gridcell");
    cell.tabIndex = row || column ? -1 : 0;
    Object.assign(cell.dataset, { row, column });
    this.draw(cell, tile);
    return cell;
  }

  draw(cell, tile) {
    const { row, column } = cell.dataset;
    cell.dataset.tile = tile;
    cell.textContent = tile === "." ? "" : tile;
    cell.setAttribute("aria-label", `row ${row}, column ${column}: ${TILES[tile]}`);
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
    this.draw(cell, tile);
    this.changed(this.rows);
  }

  press(event) {
    const cell = event.target.closest("[data-tile]");
    if (!cell) return;
    const tile = event.key.toUpperCase();
    if (tile in TILES) this.paint(cell, tile);
    if (!(event.key in MOVES)) return;
    event.preventDefault();
    const [down, right] = MOVES[event.key];
    const [row, column] = [Number(cell.dataset.row) + down, Number(cell.dataset.column) + right];
    this.floor.querySelector(`[data-row="${row}"][data-column="${column}"]`)?.focus();
  }
}
