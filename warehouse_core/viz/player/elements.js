// Functions that make, copy, find and change elements of the page.

/** Return a new element with properties and children. */
export function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

/** Return a new SVG element with attributes and children. */
export function drawn(name, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Return a copy of the only element of a template. */
export function copy(id) {
  return document.getElementById(id).content.firstElementChild.cloneNode(true);
}

/** Return the part of an element with this name. */
export function partOf(whole, name) {
  return whole.querySelector(`[data-part="${name}"]`);
}

/** Set the text of an element only if it is different, because a screen reader reads every change. */
export function setText(changed, text) {
  if (changed.textContent !== text) changed.textContent = text;
}
