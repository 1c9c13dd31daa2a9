// What drawings on canvases share: text, and filled shapes with an outline.

/** Set the size of text in pixels, and let it be written around its middle. */
export function centerText(context, size, weight = "bold") {
  context.font = `${weight} ${Math.round(size)}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
}

/** Fill the path of a context, and draw a line around it. */
export function fillOutlined(context, color, lineColor, lineWidth) {
  context.fillStyle = color;
  context.strokeStyle = lineColor;
  context.lineWidth = lineWidth;
  context.fill();
  context.stroke();
}
