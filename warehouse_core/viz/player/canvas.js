// What drawings on canvases share: text, and filled shapes with an outline.

/** The size of the smallest text, in pixels of the style sheet. */
export const MIN_TEXT = 11;

/** The size from which on bold text is legible with less contrast (WCAG 1.4.3). */
export const LARGE_TEXT = 19;

/** Set the size of text in pixels, and let it be written around its middle. */
export function centerText(context, size, weight = "bold") {
  context.font = `${weight} ${Math.round(size)}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
}

/** Write text with an outline: the contrast of small text does not depend on what is behind it. */
export function writeOutlined(context, text, x, y, [color, lineColor], density) {
  const lineWidth = (MIN_TEXT / 4) * density;
  Object.assign(context, { fillStyle: color, strokeStyle: lineColor, lineWidth, lineJoin: "round" });
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
}

/** Write a label over a place, within the width of a canvas. */
export function drawLabel(context, label, x, bottom, size, [background, color]) {
  centerText(context, size);
  const width = context.measureText(label).width + size;
  const middle = Math.min(Math.max(x, width / 2), context.canvas.width - width / 2);
  context.fillStyle = background;
  context.fillRect(middle - width / 2, bottom - 1.4 * size, width, 1.4 * size);
  context.fillStyle = color;
  context.fillText(label, middle, bottom - 0.68 * size);
}

/** Fill the path of a context, and draw a line around it. */
export function fillOutlined(context, color, lineColor, lineWidth) {
  context.fillStyle = color;
  context.strokeStyle = lineColor;
  context.lineWidth = lineWidth;
  context.fill();
  context.stroke();
}
