// Editor for Python in a text area, with line numbers and automatic indentation.

const INDENT = "    ";

/** Return the text and selection after Tab, Shift+Tab or Enter, or null if the browser handles the key. */
export function typed(text, start, end, key, isShifted) {
  const first = text.lastIndexOf("\n", start - 1) + 1;
  if (key === "Enter") {
    const line = text.slice(first, start);
    const indent = line.match(/^ */)[0] + (line.trimEnd().endsWith(":") ? INDENT : "");
    const place = start + 1 + indent.length;
    return { text: `${text.slice(0, start)}\n${indent}${text.slice(end)}`, start: place, end: place };
  }
  if (key !== "Tab") return null;
  if (start === end && !isShifted) {
    const spaces = " ".repeat(INDENT.length - ((start - first) % INDENT.length));
    const place = start + spaces.length;
    return { text: text.slice(0, start) + spaces + text.slice(end), start: place, end: place };
  }
  const before = text.slice(first, end);
  const after = before.replace(/^/gm, isShifted ? "" : INDENT).replace(isShifted ? /^ {1,4}/gm : /$^/, "");
  const moved = after.split("\n")[0].length - before.split("\n")[0].length;
  return { text: text.slice(0, first) + after + text.slice(end), start: Math.max(start + moved, first), end: end + after.length - before.length };
}

export class Editor {
  /** @param {(text: string) => void} changed function that is called with each new text. */
  constructor(area, numbers, changed) {
    Object.assign(this, { area, numbers, changed, wrong: null, leaves: false });
    area.addEventListener("input", () => this.change());
    area.addEventListener("scroll", () => { numbers.scrollTop = area.scrollTop; });
    area.addEventListener("keydown", (event) => this.press(event));
  }

  get text() {
    return this.area.value;
  }

  set text(text) {
    this.area.value = text;
    this.change();
  }

  /** Mark a line as wrong, or no line for null. */
  mark(line) {
    this.wrong = line;
    const marks = Array.from({ length: this.text.split("\n").length }, (_, index) => {
      const mark = document.createElement("span");
      mark.textContent = `${index + 1}\n`;
      mark.className = index + 1 === line ? "wrong" : "";
      return mark;
    });
    this.numbers.replaceChildren(...marks);
    this.numbers.scrollTop = this.area.scrollTop;
  }

  change() {
    this.mark(null);
    this.changed(this.text);
  }

  press(event) {
    const leaves = this.leaves;
    this.leaves = event.key === "Escape";
    if (event.ctrlKey || event.metaKey || event.altKey || (leaves && event.key === "Tab")) return;
    const { selectionStart, selectionEnd } = this.area;
    const found = typed(this.text, selectionStart, selectionEnd, event.key, event.shiftKey);
    if (!found) return;
    event.preventDefault();
    this.text = found.text;
    this.area.setSelectionRange(found.start, found.end);
  }
}
