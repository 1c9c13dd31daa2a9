// Draws the fixed parts of a floor, and tints of its cells.

import LOOK from "../../render/tiles.json" with { type: "json" };
import { kept } from "./canvas.js";
import { element } from "./elements.js";
import { heldUpUntil, marksUntil, visitsUntil } from "./track.js";

const WALL = "#";
const UNSEEN = "?";
const STATIONS = "PDC";

const MAX_LINED_COLUMNS = 40;
const MIN_STATION = 6;
const MIN_TEXTURE = 9;

/** Draw the tiles of a floor. */
export function drawFloor(brush, track, tiles) {
  const { width, height } = track;
  brush.fill("floor", 0, 0, width, height);
  if (width <= MAX_LINED_COLUMNS) drawLines(brush, width, height);
  for (const [row, column] of track.slippery) brush.fill("ice", column, row);
  drawTexture(brush, "ice", track.slippery);
  drawRuns(brush, track, tiles, UNSEEN, "unseen");
  drawTexture(brush, "unseen", placesOf(track, tiles, UNSEEN));
  drawRuns(brush, track, tiles, WALL, "shelf");
  const walls = placesOf(track, tiles, WALL);
  drawTexture(brush, "shelf", walls);
  for (const [row, column] of walls) if (isBorder(track, row, column)) brush.fill("wall", column, row);
  if (track.outer) drawMargin(brush, track);
  for (const place of placesOf(track, tiles, STATIONS)) drawStation(brush, ...place);
}

/** Return the row, the column and the tile of each cell that has one of the wanted tiles. */
function placesOf(track, tiles, wanted) {
  const places = [];
  for (let cell = 0; cell < tiles.length; cell++) {
    if (wanted.includes(tiles[cell])) places.push([...track.rowAndColumn(cell), tiles[cell]]);
  }
  return places;
}

function isBorder(track, row, column) {
  return row === 0 || column === 0 || row === track.height - 1 || column === track.width - 1;
}

function drawLines(brush, columns, rows) {
  const [left, top, width, height] = brush.view.box(0, 0, columns, rows);
  for (let column = 1; column < columns; column++) {
    brush.rect("line", Math.round(brush.view.x(column)), top, 1, height);
  }
  for (let row = 1; row < rows; row++) brush.rect("line", left, Math.round(brush.view.y(row)), width, 1);
}

/** Fill each run of a tile in a row as one box. */
function drawRuns(brush, track, tiles, tile, color) {
  for (let row = 0; row < track.height; row++) {
    const line = tiles.slice(row * track.width, (row + 1) * track.width);
    for (let first = line.indexOf(tile); first >= 0; ) {
      let end = first;
      while (line[end] === tile) end++;
      brush.fill(color, first, row, end - first);
      first = line.indexOf(tile, end);
    }
  }
}

/** Draw the polygons of a texture in some cells, if they are large enough. */
function drawTexture(brush, name, cells) {
  const { context, view, scale } = brush;
  if (scale < MIN_TEXTURE) return;
  for (const [color, polygons] of Object.entries(LOOK.textures[name])) {
    brush.begin(color);
    for (const [row, column] of cells) {
      for (const corners of polygons) brush.outline(corners, view.x(column), view.y(row), scale);
    }
    context.fill();
  }
}

/** Clear the outer part of a border, so that it is thin, and write the numbers of columns and rows on it. */
function drawMargin(brush, { outer, width, height }) {
  for (const box of [
    [0, 0, width, outer],
    [0, height - outer, width, outer],
    [0, 0, outer, height],
    [width - outer, 0, outer, height],
  ]) brush.fill("paper", ...box);
  const [middle, thick] = [(1 + outer) / 2, (1 - outer) * brush.scale];
  const size = Math.max(0.75 * thick, brush.minText);
  if (size > thick) return;
  brush.centerText(size, "normal");
  const { view } = brush;
  // The border may not have been seen yet, so the numbers have an outline.
  const write = (number, x, y) => brush.writeOutlined("paper", "wall", String(number), x, y);
  for (let column = 1; column < width - 1; column++) write(column, view.x(column + 0.5), view.y(middle));
  for (let row = 1; row < height - 1; row++) write(row, view.x(middle), view.y(row + 0.5));
}

function drawStation(brush, row, column, tile) {
  const inset = Math.max(0, Math.min(LOOK.station.inset, (1 - MIN_STATION / brush.scale) / 2));
  let [x, y, width, height] = brush.view.box(column, row, 1, 1, inset);
  if (width < MIN_STATION) {
    [x, y] = [x - (MIN_STATION - width) / 2, y - (MIN_STATION - height) / 2];
    [width, height] = [MIN_STATION, MIN_STATION];
  }
  brush.rect(LOOK.words[tile], x, y, width, height);
  if (letterSize(brush)) return;
  brush.begin("dark");
  brush.trace(tile, x + width / 2, y + height / 2, width);
  brush.context.fill();
}

/** Return the size of the letters of stations, or 0 if they do not fit. */
function letterSize({ scale, minText }) {
  const size = Math.max(LOOK.station.letter * scale, minText);
  return 1.3 * size > scale ? 0 : size;
}

/** Write the letters of stations. Letters that robots and people would cover are left out. */
export function drawLetters(brush, track, moment) {
  const size = letterSize(brush);
  if (!size) return;
  const { view } = brush;
  const { letter, corner } = LOOK.station;
  const isCovered = size > letter * view.scale ? coveredCells(track, moment) : new Set();
  brush.centerText(size);
  brush.context.textAlign = "left";
  const index = track.tileAt[moment.frame];
  const stations = kept(track, "stations", index, () => placesOf(track, track.tiles[index], STATIONS));
  for (const [row, column, tile] of stations) {
    if (!view.shows(column, row, 1) || isCovered.has(row * track.width + column)) continue;
    const [x, y] = [view.x(column + corner), view.y(row + corner) + 0.45 * size];
    brush.writeOutlined("light", "dark", tile, x, y);
  }
}

function coveredCells(track, moment) {
  const cells = new Set();
  for (let body = 0; body < track.bodies; body++) {
    const pose = track.pose(body, moment);
    if (pose) cells.add(Math.floor(pose.y) * track.width + Math.floor(pose.x));
  }
  return cells;
}

/** Darken everything outside the view of a robot. */
export function drawSight(brush, track, body, moment) {
  const { context, view } = brush;
  const pose = track.pose(body, moment);
  if (track.viewRadius === null || !pose) return;
  const { outer, width, height, viewRadius } = track;
  const [column, row] = [Math.floor(pose.x) - viewRadius, Math.floor(pose.y) - viewRadius];
  const side = 2 * viewRadius + 1;
  const [left, top] = [Math.max(column, outer), Math.max(row, outer)];
  const right = Math.min(column + side, width - outer);
  const bottom = Math.min(row + side, height - outer);
  brush.begin("shadow");
  context.rect(...view.box(outer, outer, width - 2 * outer, height - 2 * outer));
  context.rect(...view.box(left, top, right - left, bottom - top));
  context.fill("evenodd");
}

/** Tint the cells that a robot has visited more than once, darker for more visits. */
export function drawVisits(brush, track, body, moment) {
  for (const [cell, count] of visitsUntil(track, body, moment.frame)) {
    if (count < 2) continue;
    const [row, column] = track.rowAndColumn(cell);
    brush.context.globalAlpha = Math.min(0.12 * (count - 1), 0.5);
    brush.fill("visited", column, row);
  }
  brush.context.globalAlpha = 1;
}

/** Draw the cells that a search has marked so far, in their present colours. */
export function drawMarks(brush, track, moment) {
  for (const [cell, index] of marksUntil(track, moment.time)) {
    const [row, column] = track.rowAndColumn(cell);
    brush.fill(track.marks.colors[index], column, row, 1, 1, LOOK.mark.inset);
  }
}

/** Draw the start and the goal of a search as letters on discs. */
export function drawEnds(brush, track) {
  track.marks.ends.forEach(([row, column], i) => {
    const { view } = brush;
    const [x, y] = [view.x(column + 0.5), view.y(row + 0.5)];
    const radius = Math.max(8, LOOK.end.radius * view.scale);
    brush.begin("light");
    brush.circle(x, y, radius);
    brush.paint("light", "dark", Math.max(1, radius / 8));
    brush.centerText((LOOK.end.letter / LOOK.end.radius) * radius);
    brush.write("dark", "SG"[i], x, y + 0.08 * radius);
  });
}

/** Return an image with one coloured pixel for each cell where robots were held up. */
export function heatOf(track, step, theme) {
  return kept(track, "heat", `${step} ${theme.key}`, () => {
    const counts = [...heldUpUntil(track, step)];
    const share = (theme.heat.length - 1) / highestOf(counts)[1];
    return imageOf(track, counts.map(([cell, count]) => [cell, theme.heat[Math.round(count * share)]]));
  });
}

/** Return the cell with the highest count, and the count. */
export function highestOf(counts) {
  return counts.reduce((best, each) => (each[1] > best[1] ? each : best), [-1, 0]);
}

/** Return an image of the floor with one pixel per cell. */
export function mapOf(track, index, theme) {
  return kept(track, "map", `${index} ${theme.key}`, () =>
    imageOf(track, Array.from(track.tiles[index], (tile, cell) => [cell, theme[tile === WALL ? "shelf" : "floor"]])));
}

/** Return an image with one pixel for each of some cells, in its colour. */
function imageOf({ width, height }, colors) {
  const image = element("canvas", { width, height });
  const context = image.getContext("2d");
  for (const [cell, color] of colors) {
    context.fillStyle = color;
    context.fillRect(cell % width, Math.floor(cell / width), 1, 1);
  }
  return image;
}
