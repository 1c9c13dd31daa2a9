// Starts the page: connects editor, layout, buttons and Python, and saves the code in the browser.

import { Editor } from "./editor.js";
import * as drawing from "./floor.js";
import { Painter, resized } from "./painter.js";
import { Python } from "./python.js";
import { packed, unpacked } from "./share.js";

const KEPT = "warehouse-playground";

/** Milliseconds without an answer after which an agent is assumed never to return. */
const LIMIT = 10_000;

const settings = JSON.parse(document.getElementById("settings").textContent);
const part = (name) => document.querySelector(`[data-part="${name}"]`);
const button = (name) => document.querySelector(`[data-do="${name}"]`);

/** Return the state in the link, or else the state saved in the browser, or else the first exercise. */
async function opened() {
  const [exercise] = Object.keys(settings.exercises);
  const { starter: code, rows, drawn } = settings.exercises[exercise];
  const initial = { exercise, code, codes: {}, seed: 1, rows, drawn };
  const text = location.hash.startsWith("#p=") ? location.hash.slice(3) : "";
  try {
    if (text) return { ...initial, ...(await unpacked(text)) };
    return { ...initial, ...JSON.parse(localStorage.getItem(KEPT) ?? "{}") };
  } catch {
    return initial;
  }
}

class Playground {
  constructor(kept) {
    this.kept = kept;
    this.isBegun = false;
    this.editor = new Editor(part("code"), part("numbers"), (code) => this.keep({ code }));
    this.painter = new Painter(part("floor"), part("tiles"), drawing, (rows) => this.keep({ rows }));
    this.python = new Python(
      () => new Worker("worker.js", { type: "module" }), settings.wheel, LIMIT, (state) => this.say(state),
    );
    for (const [name, { title }] of Object.entries(settings.exercises)) part("exercise").append(new Option(title, name));
    part("exercise").value = kept.exercise;
    this.editor.text = kept.code;
    this.showPlace();
    part("seed").value = kept.seed;
    part("layout").append(...Object.keys(settings.layouts).map((name) => new Option(name)), new Option("painted"));
    this.chooseLayout();
    this.connect();
  }

  connect() {
    const doing = { run: () => this.ask("run"), step: () => this.ask("step"), grade: () => this.grade(), stop: () => this.python.stop(), share: () => this.share(), restart: () => this.restart() };
    for (const [name, act] of Object.entries(doing)) button(name).addEventListener("click", act);
    addEventListener("keydown", (event) => event.ctrlKey && event.key === "Enter" && !button("run").disabled && this.ask("run"));
    part("seed").addEventListener("change", () => this.keep({ seed: Math.trunc(Math.min(Math.max(Number(part("seed").value), 0), 999_999)) }));
    part("exercise").addEventListener("change", () => this.openExercise(part("exercise").value));
    part("drawn").addEventListener("change", () => this.keep({ drawn: part("drawn").checked }));
    part("layout").addEventListener("change", () => this.openLayout(part("layout").value));
    for (const name of ["height", "width"]) part(name).addEventListener("change", () => this.resize());
    addEventListener("hashchange", () => location.hash.startsWith("#p=") && location.reload());
  }

  /** Save a change in the browser. The current episode then no longer matches the page. */
  keep(change) {
    Object.assign(this.kept, change);
    this.isBegun = false;
    localStorage.setItem(KEPT, JSON.stringify(this.kept));
    if (change.rows) this.chooseLayout();
  }

  say(state) {
    const isFree = this.python?.isReady && !this.python.asked;
    for (const name of ["run", "step", "grade"]) button(name).disabled = !isFree;
    button("stop").disabled = !this.python?.asked;
    part("state").textContent = state || (isFree ? "Ready" : "Working …");
  }

  showPlace() {
    const { rows, drawn } = this.kept;
    this.painter.show(rows);
    part("drawn").checked = drawn;
    [part("height").value, part("width").value] = [rows.length, rows[0].length];
  }

  /** Select the name of the layout in the list, or "painted". */
  chooseLayout() {
    const text = this.kept.rows.join("\n");
    const names = Object.keys(settings.layouts);
    part("layout").value = names.find((name) => settings.layouts[name].join("\n") === text) ?? "painted";
  }

  /** Save the code, and open another exercise: with its saved code or starting file, and its layout. */
  openExercise(name) {
    const codes = { ...this.kept.codes, [this.kept.exercise]: this.kept.code };
    const { starter, rows = this.kept.rows, drawn = this.kept.drawn } = settings.exercises[name];
    this.keep({ exercise: name, codes, rows, drawn });
    this.showPlace();
    this.editor.text = codes[name] ?? starter;
    part("grades").hidden = true;
  }

  openLayout(name) {
    if (name in settings.layouts) this.keep({ rows: settings.layouts[name], drawn: name === "default" });
    this.showPlace();
  }

  resize() {
    const [height, width] = ["height", "width"].map((name) => Math.min(Math.max(Math.trunc(part(name).value) || 3, part(name).min), part(name).max));
    this.keep({ rows: resized(this.kept.rows, height, width) });
    this.showPlace();
  }

  /** Take one step or all steps, from the start if anything has changed since the last step. */
  async ask(what) {
    const { exercise, code, seed, rows, drawn } = this.kept;
    const continues = what === "step" && this.isBegun;
    const start = continues ? null : { exercise, code, rows, seed, stations: drawn ? "drawn" : "kept" };
    const answer = await this.answer({ do: what, start });
    this.isBegun = Boolean(answer) && !answer.ended && !answer.error;
  }

  async grade() {
    const answer = await this.answer({ do: "grade", code: this.kept.code, exercise: this.kept.exercise });
    if (!answer?.grades) return;
    const table = document.createElement("table");
    table.createCaption().textContent = `${answer.points} of ${answer.max} points`;
    for (const { name, points, max, seen } of answer.grades) {
      const row = table.insertRow();
      const cells = [`${name}: ${seen}`, `${points} of ${max}`];
      for (const text of cells) row.insertCell().textContent = text;
      row.lastChild.className = "number";
    }
    part("grades").replaceChildren(table);
    part("grades").hidden = false;
  }

  /** Ask Python, and show its answer. Return the answer, or null after an error. */
  async answer(question) {
    const asked = this.python.ask(question);
    this.say("");
    try {
      const answer = await asked;
      this.show(answer);
      this.say("");
      return answer;
    } catch (error) {
      this.isBegun = false;
      this.show({ error: error.message, line: null });
      return null;
    }
  }

  show({ error = "", line = null, printed = "", page, summary }) {
    part("error").textContent = error;
    part("error").hidden = !error;
    this.editor.mark(line);
    part("printed").textContent = printed;
    part("printed").hidden = !printed;
    if (page) part("player").srcdoc = page;
    if (summary) part("summary").textContent = summary;
  }

  async share() {
    const { exercise, code, seed, rows, drawn } = this.kept;
    const link = new URL(`#p=${await packed({ exercise, code, seed, rows, drawn })}`, location.href);
    history.replaceState(null, "", link);
    try {
      await navigator.clipboard.writeText(link.href);
      this.say("The link was copied. It is also the address of this page.");
    } catch {
      this.say("The link is now the address of this page.");
    }
  }

  restart() {
    if (!confirm("Discard your code, layout and seed, and start over?")) return;
    localStorage.removeItem(KEPT);
    location.replace(location.pathname);
  }
}

globalThis.playground = new Playground(await opened());
