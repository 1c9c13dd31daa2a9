import assert from "node:assert/strict";
import { test } from "node:test";

import { typed } from "../../../../agents/lab/playground/editor.js";
import { resized } from "../../../../agents/lab/playground/painter.js";
import { packed, unpacked } from "../../../../agents/lab/playground/share.js";

/** What becomes of a text in which | stands for the ends of the selection. */
function after(marked, key, isShifted = false) {
  const [before, inside, rest] = marked.split("|").length === 3 ? marked.split("|") : [marked.split("|")[0], "", marked.split("|")[1]];
  const start = before.length;
  const found = typed(before + inside + rest, start, start + inside.length, key, isShifted);
  if (!found) return null;
  const { text, start: from, end: to } = found;
  const middle = from === to ? "|" : `|${text.slice(from, to)}|`;
  return text.slice(0, from) + middle + text.slice(to);
}

test("Enter keeps the indentation, and deepens it after a colon", () => {
  assert.equal(after("  a|", "Enter"), "  a\n  |");
  assert.equal(after("if x:|b", "Enter"), "if x:\n    |b");
  assert.equal(after("a|bc|d", "Enter"), "a\n|d");
});

test("Tab fills up to a multiple of four, and moves all lines of a selection", () => {
  assert.equal(after("ab|", "Tab"), "ab  |");
  assert.equal(after("x\nabcd|", "Tab"), "x\nabcd    |");
  assert.equal(after("a|b\nc|d", "Tab"), "    a|b\n    c|d");
  assert.equal(after("    a|b\n  c|d", "Tab", true), "a|b\nc|d");
  assert.equal(after("  |ab", "Tab", true), "|ab");
});

test("other keys do what they usually do", () => {
  assert.equal(after("ab|", "x"), null);
});

test("a layout of another size is cut, or gets walls outside", () => {
  assert.deepEqual(resized(["ab", "cd"], 3, 1), ["a", "c", "#"]);
  assert.deepEqual(resized(["ab"], 1, 4), ["ab##"]);
});

test("a link has all that was packed, and no characters with a meaning in addresses", async () => {
  const value = { code: `${"x = '→'\n".repeat(50)}?&#+/=`, seed: 3 };
  const text = await packed(value);
  assert.match(text, /^[\w-]+$/);
  assert.deepEqual(await unpacked(text), value);
  await assert.rejects(unpacked("AAAA"));
});
