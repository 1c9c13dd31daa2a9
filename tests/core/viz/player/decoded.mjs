// Prints what track.js makes of the packed block on standard input, as JSON; NaN is a word there.

import { readFileSync } from "node:fs";

import { decode, unpack } from "../../../../warehouse_core/viz/player/track.js";

const block = await unpack(readFileSync(0, "latin1"));
const plain = (_, value) => {
  if (ArrayBuffer.isView(value)) return [...value];
  return Number.isNaN(value) ? "NaN" : value;
};
process.stdout.write(JSON.stringify(decode(block), plain));
