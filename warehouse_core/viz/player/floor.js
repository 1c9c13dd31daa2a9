// Draws what stands still: floor, walls, shelves, stations, and what is not seen yet.

import { centerText, MIN_TEXT, writeOutlined } from "./canvas.js";

const WALL = "#";
const UNSEEN = "?";
const STATIONS = { P: "pickup", D: "dropoff", C: "charger" };

/** What stands for the letters of stations that are too small for them, as in the legend. */
const SHAPES = {
  P: [[0.5, 0.15], [0.85, 0.85], [0.15, 0.85]],
  D: [[0.15, 0.15], [0.85, 0.15], [0.5, 0.85]],
  C: [[0.5, 0.1], [0.9, 0.5], [0.5, 0.9], [0.1, 0.5]],
};

const MAX_LINED_COLUMNS = 40;
const MIN_STATION = 6;
const MIN_TEXTURE = 9;

/** Draw the tiles of a floor. Colours are those of the theme. */
export function drawFloor(context, track, tiles, view, theme) {
  context.fillStyle = theme.floor;
  context.fillRect(...view.box(0, 0, track.width, track.height));
  if (track.width <= MAX_LINED_COLUMNS) drawLines(context, track, view, theme);
  drawSlippery(context, track, view, theme);
  drawRuns(context, track, tiles, view, UNSEEN, theme.unseen);
  drawHatching(context, track, tiles, view, theme);
  drawRuns(context, track, tiles, view, WALL, theme.shelf);
  if (view.scale >= MIN_TEXTURE) drawShelves(context, track, tiles, view, theme);
  drawBorder(context, track, tiles, view, theme);
  drawNumbers(context, track, view, theme);
  for (const place of placesOf(track, tiles, Object.keys(STATIONS))) drawStation(context, place, view, theme);
}

/** Return the row, the column and the tile of each wall. */
export function wallsOf(track, tiles) {
  return [...placesOf(track, tiles, WALL)];
}

/** Yield the row, the column and the tile of each cell that has one of some tiles. */
function* placesOf(track, tiles, wanted) {
  for (let cell = 0; cell < tiles.length; cell++) {
    if (wanted.includes(tiles[cell])) yield [...track.rowAndColumn(cell), tiles[cell]];
  }
}

function drawLines(context, track, view, theme) {
  context.fillStyle = theme.line;
  const [left, top, width, height] = view.box(0, 0, track.width, track.height);
  for (let column = 1; column < track.width; column++) {
    context.fillRect(Math.round(view.x(column)), top, 1, height);
  }
  for (let row = 1; row < track.height; row++) {
    context.fillRect(left, Math.round(view.y(row)), width, 1);
  }
}

/** Fill each run of a tile in a row as one box. */
function drawRuns(context, track, tiles, view, tile, color) {
  context.fillStyle = color;
  for (let row = 0; row < track.height; row++) {
    const line = tiles.slice(row * track.width, (row + 1) * track.width);
    for (let first = line.indexOf(tile); first >= 0; ) {
      let end = first;
      while (line[end] === tile) end++;
      context.fillRect(...view.box(first, row, end - first, 1));
      first = line.indexOf(tile, end);
    }
  }
}

export function isBorder(track, row, column) {
  return row === 0 || column === 0 || row === track.height - 1 || column === track.width - 1;
}

/** Draw two boards across each wall that is not part of the border. */
function drawShelves(context, track, tiles, view, theme) {
  context.fillStyle = theme.board;
  const thick = Math.max(1, Math.round(view.scale / 12));
  for (const [row, column] of wallsOf(track, tiles)) {
    if (isBorder(track, row, column)) continue;
    const [x, , width] = view.box(column, row, 1, 1, 0.12);
    for (const share of [0.3, 0.62]) {
      context.fillRect(x, Math.round(view.y(row + share)), width, thick);
    }
  }
}

/** The width of the part of a border that is not shown, in cells. */
const OUTER = 0.7;

/** Return how much of the outermost cells is not shown: a border of walls is thin. */
export function outerOf(track) {
  track.outer ??= track.tiles.every((tiles) => isBordered(track, tiles)) ? OUTER : 0;
  return track.outer;
}

/** Draw the walls of the border, and clear its outer part, so that they are thin. */
function drawBorder(context, track, tiles, view, theme) {
  context.fillStyle = theme.wall;
  for (const [row, column] of wallsOf(track, tiles)) {
    if (isBorder(track, row, column)) context.fillRect(...view.box(column, row));
  }
  context.fillStyle = theme.paper;
  const { width, height } = track;
  const outer = outerOf(track);
  if (!outer) return;
  for (const [column, row, columns, rows] of [
    [0, 0, width, outer],
    [0, height - outer, width, outer],
    [0, 0, outer, height],
    [width - outer, 0, outer, height],
  ]) context.fillRect(...view.box(column, row, columns, rows));
}

/** Write the numbers of columns and rows on a thin border that has room for them. */
function drawNumbers(context, track, view, theme) {
  const middle = (1 + outerOf(track)) / 2;
  const thick = (1 - outerOf(track)) * view.scale;
  const size = Math.max(0.75 * thick, MIN_TEXT * theme.density);
  if (!outerOf(track) || size > thick) return;
  centerText(context, size, "normal");
  // The border may be one that is not seen yet.
  const write = (number, x, y) =>
    writeOutlined(context, String(number), x, y, [theme.paper, theme.wall], theme.density);
  for (let column = 1; column < track.width - 1; column++) {
    write(column, view.x(column + 0.5), view.y(middle));
  }
  for (let row = 1; row < track.height - 1; row++) {
    write(row, view.x(middle), view.y(row + 0.5));
  }
}

function isBordered(track, tiles) {
  for (let cell = 0; cell < tiles.length; cell++) {
    const isOuter = isBorder(track, ...track.rowAndColumn(cell));
    if (isOuter && tiles[cell] !== WALL && tiles[cell] !== UNSEEN) return false;
  }
  return true;
}

function drawStation(context, [row, column, tile], view, theme) {
  const inset = Math.max(0, Math.min(0.06, (1 - MIN_STATION / view.scale) / 2));
  let [x, y, width, height] = view.box(column, row, 1, 1, inset);
  if (width < MIN_STATION) {
    [x, y] = [x - (MIN_STATION - width) / 2, y - (MIN_STATION - height) / 2];
    [width, height] = [MIN_STATION, MIN_STATION];
  }
  context.fillStyle = theme[STATIONS[tile]];
  context.fillRect(x, y, width, height);
  context.fillStyle = theme.dark;
  if (!letterSize(view, theme)) fillShape(context, SHAPES[tile], x, y, width, height);
}

/** The size of a letter that a robot leaves free, as a share of a cell, and where it is. */
const [LETTER, CORNER] = [0.22, 0.11];

/** Return the size of the letters of stations, or 0 if there is no room for them. */
function letterSize(view, theme) {
  const size = Math.max(LETTER * view.scale, MIN_TEXT * theme.density);
  return 1.3 * size > view.scale ? 0 : size;
}

/** Write the letters of stations where there is room: larger ones not under robots and people. */
export function drawLetters(context, track, moment, view, theme) {
  const size = letterSize(view, theme);
  if (!size) return;
  const isCovered = size > LETTER * view.scale ? coveredCells(track, moment) : new Set();
  centerText(context, size);
  context.textAlign = "left";
  for (const [row, column, tile] of stationsOf(track, track.tileAt[moment.frame])) {
    if (!view.shows(column, row, 1) || isCovered.has(row * track.width + column)) continue;
    const [x, y] = [view.x(column + CORNER), view.y(row + CORNER) + 0.45 * size];
    writeOutlined(context, tile, x, y, [theme.light, theme.dark], theme.density);
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

/** Return the row, the column and the tile of each station. */
function stationsOf(track, index) {
  track.stations ??= [];
  track.stations[index] ??= [...placesOf(track, track.tiles[index], Object.keys(STATIONS))];
  return track.stations[index];
}

/** Fill a shape, whose corners are shares of a box. */
function fillShape(context, corners, x, y, width, height) {
  context.beginPath();
  for (const [right, down] of corners) context.lineTo(x + right * width, y + down * height);
  context.fill();
}

/** Draw waves on slippery cells. */
function drawSlippery(context, track, view, theme) {
  for (const [row, column] of track.slippery) {
    context.fillStyle = theme.ice;
    context.fillRect(...view.box(column, row));
    context.strokeStyle = theme.wave;
    context.lineWidth = Math.max(1, view.scale / 22);
    for (const share of [0.25, 0.5, 0.75]) {
      const [x, y, size] = [view.x(column + 0.12), view.y(row + share), 0.19 * view.scale];
      context.beginPath();
      context.moveTo(x, y);
      for (let wave = 0; wave < 4; wave++) {
        const [start, bend] = [x + wave * size, (wave % 2 ? 0.3 : -0.3) * size];
        context.quadraticCurveTo(start + size / 2, y + 2 * bend, start + size, y);
      }
      context.stroke();
    }
  }
}

/** Draw stripes on cells that are not seen yet, along their diagonals. */
function drawHatching(context, track, tiles, view, theme) {
  if (!tiles.includes(UNSEEN)) return;
  context.strokeStyle = theme.stripe;
  context.lineWidth = Math.max(1, view.scale / 14);
  context.beginPath();
  for (const [row, column] of placesOf(track, tiles, UNSEEN)) {
    const [x, y, width, height] = view.box(column, row);
    context.moveTo(x, y + height);
    context.lineTo(x + width, y);
  }
  context.stroke();
}
