// Looks at a page as a reader does. It runs before the page's own scripts and adds a function:
// `look(wide)` returns the faults of the visible page, one line each, and how many texts it has read.
// Labelled boxes may scroll sideways, but tables may not on a wide screen. With `null` all may.

(() => {
  const MIN_SIZE = 11; // CSS pixels
  const [MIN_CONTRAST, MIN_LARGE_CONTRAST] = [4.5, 3];
  const [LARGE, LARGE_BOLD] = [24, 18.66]; // CSS pixels, of WCAG's 18 and 14 points
  const SLACK = 1.5; // CSS pixels that a box may reach into another
  const GLYPH_UNITS = 100; // of Matplotlib, whose letters are paths of this height
  const CAPITAL = 0.73; // height of capital letters as a share of the size
  const MAX_WORDS = 40;

  // Canvases: the texts of each are recorded, and the other canvases that are drawn on it.

  const recorded = new WeakMap();
  const { getContext } = HTMLCanvasElement.prototype;
  const { fillText, clearRect, drawImage } = CanvasRenderingContext2D.prototype;

  function recordOf(canvas) {
    if (!recorded.has(canvas)) recorded.set(canvas, { texts: [], drawn: new Set() });
    return recorded.get(canvas);
  }

  const isWhole = ({ canvas }, x, y, width, height) =>
    x <= 0 && y <= 0 && x + width >= canvas.width && y + height >= canvas.height;

  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, { ...options, willReadFrequently: true });
  };

  Object.assign(CanvasRenderingContext2D.prototype, {
    fillText(words, x, y, ...others) {
      recordOf(this.canvas).texts.push({ ...placeOf(this, words, x, y), ...colorsOf(this, words, x, y) });
      return fillText.call(this, words, x, y, ...others);
    },
    clearRect(...box) {
      if (isWhole(this, ...box)) recorded.delete(this.canvas);
      return clearRect.apply(this, box);
    },
    drawImage(image, x, y, ...others) {
      const isOpaque = image.getContext?.("2d")?.getContextAttributes().alpha === false;
      if (isOpaque && isWhole(this, x, y, image.width, image.height)) recorded.delete(this.canvas);
      recordOf(this.canvas).drawn.add(image);
      return drawImage.call(this, image, x, y, ...others);
    },
  });

  for (const side of ["width", "height"]) {
    const own = Object.getOwnPropertyDescriptor(HTMLCanvasElement.prototype, side);
    Object.defineProperty(HTMLCanvasElement.prototype, side, {
      ...own,
      set(value) {
        recorded.delete(this);
        own.set.call(this, value);
      },
    });
  }

  /** Return the texts of a canvas and of the canvases that are drawn on it. */
  function writtenOn(canvas) {
    const { texts, drawn } = recorded.get(canvas) ?? { texts: [], drawn: [] };
    return [...texts.map((text) => ({ ...text, on: canvas })), ...[...drawn].flatMap(writtenOn)];
  }

  function placeOf(context, words, x, y) {
    const { a, d, e, f } = context.getTransform();
    const size = Number.parseFloat(context.font.match(/([\d.]+)px/)[1]) * Math.abs(d);
    const around = context.measureText(words);
    const [left, right] = [x - around.actualBoundingBoxLeft, x + around.actualBoundingBoxRight];
    const [top, bottom] = [y - around.actualBoundingBoxAscent, y + around.actualBoundingBoxDescent];
    const box = { left: a * left + e, right: a * right + e, top: d * top + f, bottom: d * bottom + f };
    return { words, box, size, isBold: /bold|[6-9]00/.test(context.font) };
  }

  /** Return the colour of a text, and the colour of most of its box before it is written. */
  function colorsOf(context, words, x, y) {
    const { box } = placeOf(context, words, x, y);
    const [left, top] = [Math.floor(box.left), Math.floor(box.top)];
    const [width, height] = [Math.ceil(box.right) - left, Math.ceil(box.bottom) - top];
    if (!(width > 0 && height > 0)) return {};
    const { data } = context.getImageData(left, top, width, height);
    const counts = new Map();
    for (let i = 0; i < data.length; i += 4) {
      const key = [0, 1, 2, 3].map((part) => data[i + part] >> 2).join();
      const [count] = counts.get(key) ?? [0];
      counts.set(key, [count + 1, i]);
    }
    const [, most] = [...counts.values()].reduce((one, other) => (other[0] > one[0] ? other : one));
    const behind = [data[most], data[most + 1], data[most + 2], data[most + 3] / 255];
    return { color: parse(context.fillStyle), alpha: context.globalAlpha, behind };
  }

  // Colours, as red, green and blue of 0 to 255, and opacity of 0 to 1.

  const probe = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });

  const parsed = new Map();

  function parse(color) {
    if (!parsed.has(color)) parsed.set(color, painted(color));
    return parsed.get(color);
  }

  function painted(color) {
    probe.clearRect(0, 0, 1, 1);
    probe.fillStyle = color;
    probe.fillRect(0, 0, 1, 1);
    const [red, green, blue, alpha] = probe.getImageData(0, 0, 1, 1).data;
    return [red, green, blue, alpha / 255];
  }

  function over([...above], below) {
    const mixed = [0, 1, 2].map((part) => above[part] * above[3] + below[part] * (1 - above[3]));
    return [...mixed, 1];
  }

  function luminance(color) {
    const linear = color.slice(0, 3).map((part) => {
      const share = part / 255;
      return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  }

  function contrast(one, other) {
    const [dark, light] = [luminance(one), luminance(other)].sort((a, b) => a - b);
    return (light + 0.05) / (dark + 0.05);
  }

  function paperOf(element) {
    const layers = [];
    for (let each = element; each; each = each.parentElement) {
      layers.push(parse(getComputedStyle(each).backgroundColor));
    }
    const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
    const scheme = getComputedStyle(document.documentElement).colorScheme;
    const canvas = isDark && scheme.includes("dark") ? [18, 18, 18, 1] : [255, 255, 255, 1];
    return layers.reduceRight((below, layer) => over(layer, below), canvas);
  }

  // Text of the page, of its canvases, and of pictures as SVG.

  function isSeen(element) {
    const { width, height } = element.getBoundingClientRect();
    const options = { opacityProperty: true, visibilityProperty: true, contentVisibilityAuto: true };
    return element.checkVisibility(options) && (width > 1 || height > 1);
  }

  const NOT_READ = "script, style, noscript, template, option, title, desc, metadata, svg *";

  function* textsOfPage() {
    const walker = document.createTreeWalker(document.body ?? document, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const { data, parentElement: element } = walker.currentNode;
      if (!data.trim() || element.matches(NOT_READ) || !isSeen(element)) continue;
      if (element.closest("[aria-hidden=true]") && !element.closest("main, article")) continue;
      const range = new Range();
      range.selectNodeContents(walker.currentNode);
      const style = getComputedStyle(element);
      const size = Number.parseFloat(style.fontSize);
      const isBold = style.fontWeight >= 600;
      const behind = paperOf(element);
      const color = over(parse(style.color), behind);
      for (const rect of range.getClientRects()) {
        if (rect.width < 1 || rect.height < 1) continue;
        yield { words: data.trim(), element, box: inner(rect, size), size, isBold, color, behind };
      }
    }
  }

  /** Return the part of a line's box that letters fill. */
  function inner({ left, right, top, bottom }, size) {
    const middle = (top + bottom) / 2;
    return { left, right, top: middle - 0.4 * size, bottom: middle + 0.4 * size };
  }

  function* textsOfCanvases() {
    for (const canvas of document.querySelectorAll("canvas")) {
      if (!isSeen(canvas)) continue;
      const density = canvas.width / canvas.clientWidth;
      const page = paperOf(canvas);
      const whole = { left: 0, top: 0, right: canvas.clientWidth, bottom: canvas.clientHeight };
      for (const { words, box, size, isBold, color, alpha, behind, on } of writtenOn(canvas)) {
        if (!color || isAway(box, canvas)) continue;
        const below = over(behind, page);
        yield {
          words, box: scaled(box, 1 / density), size: size / density, isBold, whole, canvas: on,
          color: over([...color.slice(0, 3), color[3] * alpha], below), behind: below,
        };
      }
    }
  }

  function scaled(box, factor) {
    return Object.fromEntries(Object.entries(box).map(([side, place]) => [side, place * factor]));
  }

  /** Return whether a box is wholly outside a canvas, as when it is zoomed. */
  function isAway({ left, right, top, bottom }, { width, height }) {
    return right <= 0 || bottom <= 0 || left >= width || top >= height;
  }

  function* textsOfPicture(picture) {
    const whole = picture.getBoundingClientRect();
    const drawn = [...picture.querySelectorAll("path, rect, circle, ellipse, polygon, use")];
    const letters = "text, g[id^=text_]";
    const shapes = drawn.filter((each) => !each.closest(`defs, clipPath, marker, ${letters}`));
    for (const text of picture.querySelectorAll(letters)) {
      const box = text.getBoundingClientRect();
      if (!isSeen(text) || !box.width || text.closest("defs")) continue;
      const isDrawn = text.matches("g");
      // Text with an outline has two paths; the first is the outline.
      const glyphs = isDrawn ? (text.querySelector("g") ?? text.lastElementChild) : text;
      const style = getComputedStyle(glyphs);
      const { c, d } = glyphs.getScreenCTM();
      const units = isDrawn ? GLYPH_UNITS : Number.parseFloat(style.fontSize);
      const size = glyphs.matches("path") ? box.height / CAPITAL : Math.hypot(c, d) * units;
      const comment = [...text.childNodes].find((each) => each.nodeType === Node.COMMENT_NODE);
      const isOutlined = style.paintOrder.startsWith("stroke") && style.stroke !== "none";
      const paper = paperOf(picture.getRootNode().host ?? picture);
      const below = isOutlined ? parse(style.stroke) : behindOf(text, box, shapes, paper);
      const color = over(withOpacity(parse(style.fill), glyphs), below);
      yield {
        words: (isDrawn ? comment?.data : text.textContent)?.trim() ?? "", size, color, behind: below, whole,
        box: isDrawn ? box : inner(box, size), picture, isBold: style.fontWeight >= 600,
      };
    }
  }

  function withOpacity([red, green, blue, alpha], element) {
    const { fillOpacity } = getComputedStyle(element);
    let whole = alpha * fillOpacity;
    for (let each = element; each; each = each.parentElement) whole *= getComputedStyle(each).opacity;
    return [red, green, blue, whole];
  }

  /** Return the colour behind the middle of a text, from the shapes before it. */
  function behindOf(text, box, shapes, paper) {
    const at = new DOMPoint((box.left + box.right) / 2, (box.top + box.bottom) / 2);
    const before = shapes.filter((shape) =>
      shape.compareDocumentPosition(text) & Node.DOCUMENT_POSITION_FOLLOWING);
    const below = before.flatMap((shape) =>
      fillsOf(shape).filter(([outline]) => contains(shape, outline, at)).map(([, painted]) => painted));
    return below.reduce((color, shape) => {
      const { fill } = getComputedStyle(shape);
      const isFilled = fill !== "none" && !fill.startsWith("url");
      return isFilled ? over(withOpacity(parse(fill), shape), color) : color;
    }, paper);
  }

  /** Return the outlines of a shape and the elements that have their colours; a copied group has several. */
  function fillsOf(shape) {
    if (!shape.matches("use")) return [[shape, shape]];
    const used = shape.getRootNode().querySelector(shape.href.baseVal);
    return used.matches("g") ? [...used.children].map((part) => [part, part]) : [[used, shape]];
  }

  function contains(shape, outline, at) {
    if (!isSeen(shape)) return false;
    const moved = shape.matches("use") ? [shape.x.baseVal.value, shape.y.baseVal.value] : [0, 0];
    const transform = shape.getScreenCTM().translate(...moved);
    return outline.isPointInFill(at.matrixTransform(transform.inverse())) && !isClipped(shape, at);
  }

  function isClipped(shape, at) {
    for (let each = shape; each; each = each.parentElement) {
      const [, id] = getComputedStyle(each).clipPath.match(/^url\("#(.+)"\)$/) ?? [];
      if (!id) continue;
      const inside = at.matrixTransform(each.getScreenCTM().inverse());
      const parts = [...shape.getRootNode().getElementById(id).children];
      if (!parts.some((part) => part.isPointInFill(inside))) return true;
    }
    return false;
  }

  /** Return the pictures of the page as SVG: a page of its own, inline, or loaded by an image. */
  function picturesOfPage() {
    const inline = document.documentElement.matches("svg")
      ? [document.documentElement]
      : [...document.querySelectorAll("svg")].filter((each) => isSeen(each) && !each.parentElement.closest("svg"));
    const loaded = [...document.images].filter(isSeen).flatMap((image) => {
      const [start, data] = (image.currentSrc || image.src).split("base64,");
      return start.includes("svg+xml") ? [copied(image, data)] : [];
    });
    return [...inline, ...loaded.filter(Boolean)];
  }

  /** Put the SVG of an image over it, so that its text has places on the page. */
  function copied(image, data) {
    const { left, top, width, height } = image.getBoundingClientRect();
    const host = document.createElement("div");
    host.dataset.copy = "";
    Object.assign(host.style, {
      position: "absolute", left: `${left + scrollX}px`, top: `${top + scrollY}px`, opacity: 0.999,
    });
    const text = new TextDecoder().decode(Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)));
    const picture = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    picture.setAttribute("width", width);
    picture.setAttribute("height", height);
    host.attachShadow({ mode: "open" }).append(document.adoptNode(picture));
    image.parentElement.append(host);
    return picture;
  }

  // Faults.

  function* faultsOfText({ words, box, size, isBold, color, behind, whole, element }) {
    const name = JSON.stringify(words.slice(0, MAX_WORDS));
    if (size < MIN_SIZE - 0.05) yield `small: ${name} is ${size.toFixed(1)} px high`;
    const least = size >= (isBold ? LARGE_BOLD : LARGE) ? MIN_LARGE_CONTRAST : MIN_CONTRAST;
    const found = contrast(color, behind);
    if (found < least - 0.005) {
      const [one, other] = [color, behind].map((each) => each.slice(0, 3).map(Math.round).join(" "));
      yield `pale: ${name} has a contrast of ${found.toFixed(2)}, ${one} on ${other}`;
    }
    const over = whole ? reach(box, whole) : element ? cutBy(element, box) : 0;
    if (over > SLACK) yield `cut: ${name} by ${over.toFixed(0)} px`;
  }

  /** Return how far a box reaches out of another. */
  function reach(box, whole) {
    return Math.max(
      whole.left - box.left, box.right - whole.right, whole.top - box.top, box.bottom - whole.bottom,
    );
  }

  /** Return how far text reaches out of the boxes that cut it off; boxes that scroll do not. */
  function cutBy(element, box) {
    // Nobody can scroll there. A box that is wholly there, such as a drawer, is not shown yet.
    let most = box.right > -scrollX ? -scrollX - box.left : 0;
    const isPrinted = matchMedia("print").matches;
    if (isPrinted) most = Math.max(most, box.right - innerWidth);
    for (let each = element; each && each !== document.body; each = each.parentElement) {
      const { overflowX, overflowY } = getComputedStyle(each);
      const { left, top } = each.getBoundingClientRect();
      const [inX, inY] = [left + each.clientLeft, top + each.clientTop];
      if (scrolls(overflowX) || scrolls(overflowY)) break;
      const hides = (overflow) => overflow === "hidden" || overflow === "clip";
      if (hides(overflowX)) most = Math.max(most, inX - box.left, box.right - inX - each.clientWidth);
      if (hides(overflowY)) most = Math.max(most, inY - box.top, box.bottom - inY - each.clientHeight);
    }
    return most;
  }

  function scrolls(overflow) {
    return overflow === "auto" || overflow === "scroll";
  }

  function* overlaps(texts) {
    const sorted = [...texts].sort((one, other) => one.box.left - other.box.left);
    for (const [i, one] of sorted.entries()) {
      for (let j = i + 1; j < sorted.length && sorted[j].box.left < one.box.right - SLACK; j++) {
        const other = sorted[j];
        const wide = Math.min(one.box.right, other.box.right) - other.box.left;
        const high = Math.min(one.box.bottom, other.box.bottom) - Math.max(one.box.top, other.box.top);
        if (wide <= SLACK || high <= SLACK || layerOf(one) !== layerOf(other)) continue;
        const names = [one, other].map(({ words }) => JSON.stringify(words.slice(0, MAX_WORDS)));
        yield `overlap: ${names.join(" and ")}`;
      }
    }
  }

  /** Return the layer of a text; only texts of one layer can overlap, as floating boxes cover others. */
  const layers = new Map();

  function layerOf(text) {
    if (!text.element) return text.canvas ?? text.picture ?? null;
    if (!layers.has(text.element)) layers.set(text.element, floatingOf(text.element));
    return layers.get(text.element);
  }

  function floatingOf(element) {
    for (let each = element; each; each = each.parentElement) {
      const { position } = getComputedStyle(each);
      if (position === "fixed" || position === "sticky" || each.matches("dialog")) return each;
      if (scrolls(getComputedStyle(each).overflowX) && each !== document.body) return each;
    }
    return null;
  }

  /** Yield boxes that scroll sideways without a label; on a wide page no table may scroll. */
  function* sideways(wide) {
    const { scrollWidth, clientWidth } = document.documentElement;
    if (scrollWidth > clientWidth + 1) yield `sideways: the page is ${scrollWidth - clientWidth} px too wide`;
    for (const each of document.body?.querySelectorAll("*") ?? []) {
      const over = each.scrollWidth - each.clientWidth;
      if (over <= 1 || !scrolls(getComputedStyle(each).overflowX) || !isSeen(each)) continue;
      const hasName = each.ariaLabel || each.getAttribute("aria-labelledby");
      const isLabelled = each.role && hasName && each.tabIndex >= 0;
      const name = each.ariaLabel || each.outerHTML.slice(0, MAX_WORDS);
      if (!isLabelled || (wide && each.querySelector("table"))) yield `sideways: ${name} scrolls by ${over} px`;
    }
  }

  /** Yield fields and buttons that are too small for their words. */
  function* fields() {
    for (const each of document.querySelectorAll("button, input, select")) {
      if (isSeen(each) && each.scrollWidth > each.clientWidth + 1) {
        yield `cut: ${each.outerHTML.slice(0, MAX_WORDS)} is too narrow for its words`;
      }
    }
  }

  globalThis.look = (wide) => {
    const sides = wide === null ? [] : [...sideways(wide)];
    const pictures = picturesOfPage();
    const drawn = pictures.flatMap((picture) => [...textsOfPicture(picture)]);
    const page = document.body ? [...textsOfPage()] : [];
    const canvases = [...textsOfCanvases()];
    const texts = [...page, ...drawn, ...canvases];
    layers.clear();
    const groups = Map.groupBy(texts, layerOf);
    const faults = [
      ...texts.flatMap((text) => [...faultsOfText(text)]),
      ...[...groups.values()].flatMap((layer) => [...overlaps(layer)]),
      ...sides,
      ...fields(),
    ];
    for (const each of document.querySelectorAll("[data-copy]")) each.remove();
    return { faults: [...new Set(faults)], texts: texts.length };
  };
})();
