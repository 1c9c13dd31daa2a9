// Reads the block of bytes that columns.py packs.

const KINDS = { i1: Int8Array, i2: Int16Array, i4: Int32Array, f4: Float32Array };

/** Return the bytes of a compressed block, given as base64. */
export async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

/** Return the JSON value at the start of a block, with arrays in place of references. */
export function decode(block) {
  const length = new DataView(block).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(block, 4, length));
  const start = 4 + length;
  return JSON.parse(text, (_, value) => (value?.$ ? column(block, start, value.$) : value));
}

function column(block, start, [kind, offset, length, isDelta, unit]) {
  const stored = new KINDS[kind](block, start + offset, length);
  if (!isDelta && unit === 1) return stored;
  const values = unit === 1 ? new Int32Array(length) : new Float64Array(length);
  let sum = 0;
  for (let i = 0; i < length; i++) {
    sum = isDelta ? sum + stored[i] : stored[i];
    values[i] = sum * unit;
  }
  return values;
}
