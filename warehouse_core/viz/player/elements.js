// Elements of the page: made, copied, found and written to.

/** Return a new element with some properties and children. */
export function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

/** Return a new element of a drawing with some attributes and children. */
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

/** Return the part of an element that has a name. */
export function partOf(whole, name) {
  return whole.querySelector(`[data-part="${name}"]`);
}

/** Set the text of an element, if it is another one: a screen reader reads changes. */
export function setText(changed, text) {
  if (changed.textContent !== text) changed.textContent = text;
}
