// Starts the page: reads its data, and connects the buttons, the keys and the address to the player.

import { setText } from "./elements.js";
import { Player, SPEEDS } from "./player.js";
import { decode, unpack } from "./track.js";

const ZOOM = 1.5;

/** The share of the first floor that must be visible for the page to play by itself. */
const IN_SIGHT = 0.5;

async function start() {
  const root = document.getElementById("player");
  const data = decode(await unpack(document.getElementById("data").textContent));
  document.getElementById("too-old").remove();
  root.hidden = false;
  const player = new Player(data, root);
  globalThis.player = player;
  connect(player);
  new ResizeObserver(() => player.draw()).observe(root);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => player.draw());
  player.draw();
  playAtFirst(player, data.opensAt === null && !player.isReduced);
}

/** Play the page by itself, or stay at the start, until the reader presses a key or clicks. */
function playAtFirst(player, isToPlay) {
  for (const what of ["keydown", "click"]) {
    // The action of the key or the click has been done by now: space and the button have paused.
    document.addEventListener(what, () => player.isOpening && player.pause());
  }
  // A report or a notebook may have many players in frames. Each plays only while it is visible, so
  // the reader misses no start. A frame can observe how much of it the reader's window shows.
  const look = (entries) => player.open(entries.at(-1).intersectionRatio >= IN_SIGHT);
  if (isToPlay) new IntersectionObserver(look, { threshold: IN_SIGHT }).observe(player.panels[0].canvas);
}

function connect(player) {
  const find = (name) => player.find(name);
  const [slider, play, speed, place, event] = ["slider", "play", "speed", "place", "event"].map(find);
  const { time } = player.longest;
  slider.max = time.length - 1;
  slider.addEventListener("input", () => player.seek(time[slider.value]));
  speed.append(...SPEEDS.map((value) => new Option(`${value}\u00d7`, value)));
  speed.addEventListener("change", () => {
    player.speed = Number(speed.value);
    player.draw();
  });
  const actions = {
    play: () => player.toggle(),
    back: () => player.move(-1),
    forward: () => player.move(1),
    first: () => player.seek(0),
    last: () => player.seek(player.end),
    event: () => player.goToEvent(),
    larger: () => player.zoom(ZOOM),
    smaller: () => player.zoom(1 / ZOOM),
    fit: () => player.fit(),
    help: () => find("helping").showModal(),
    slower: () => player.faster(-1),
    faster: () => player.faster(1),
    arrows: () => player.toggleArrows(),
  };
  for (const button of player.root.querySelectorAll("button[data-do]")) {
    button.addEventListener("click", (event) => {
      actions[button.dataset.do]();
      if (event.detail) button.blur(); // after a click with a pointer, space plays again
    });
  }
  listenToKeys(player, actions);
  player.listeners.push(() => {
    slider.value = player.longest.at(player.time).frame;
    slider.setAttribute("aria-valuetext", player.place);
    speed.value = player.speed;
    play.classList.toggle("playing", player.isPlaying);
    play.ariaLabel = player.isPlaying ? "Pause" : "Play";
    setText(place, player.place);
    setText(event, player.event);
    if (player.isPlaying) return;
    const words = [player.event, ...player.panels.map((panel) => panel.place)];
    // A screen reader reads changes aloud, which would be too much while the page plays.
    setText(find("status"), words.filter(Boolean).join(". "));
  });
}

const KEYS = {
  " ": "play", ArrowLeft: "back", ArrowRight: "forward", Home: "first", End: "last", n: "event",
  v: "arrows", "?": "help", "+": "larger", "=": "larger", "-": "smaller", 0: "fit", "<": "slower",
  ">": "faster", ",": "slower", ".": "faster",
};

/** Directions in which the arrow keys, with the shift key, move the view. */
const DIRECTIONS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function listenToKeys(player, actions) {
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || player.find("helping").open) return;
    if (target.matches("input[type=number], select") && key !== "Escape") return;
    if (target.matches("button") && key === " ") return;
    if (event.shiftKey && key in DIRECTIONS) player.pan(...DIRECTIONS[key]);
    else if (key in KEYS) actions[KEYS[key]]();
    else return;
    event.preventDefault();
  });
}

start();
