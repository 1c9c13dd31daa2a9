// Numbers along an axis.

/** Return about `count` round numbers from low to high. */
export function ticks(low, high, count) {
  if (!(high > low)) return [low];
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    found.push(Number((i * step).toPrecision(12)));
  }
  return found;
}

/** Return the lowest and the highest of some lists of numbers, and 0; NaN is left out. */
export function extent(lists) {
  let [low, high] = [0, 0];
  for (const list of lists) {
    for (const value of list) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low === high ? [low, low + 1] : [low, high];
}

const FORMATS = new Map();

/** Return a number as text of at most so many digits after the point, with a real minus sign. */
export function shown(value, digits = 2) {
  if (Number.isNaN(value)) return "unknown";
  // A format takes longer to make than to use.
  if (!FORMATS.has(digits)) FORMATS.set(digits, new Intl.NumberFormat("en-US", { maximumFractionDigits: digits }));
  return FORMATS.get(digits).format(value).replace("-", "\u2212");
}

/** Return a time with one decimal, by the rule of `seconds_of` in wording.py. */
export function seconds(time) {
  return `${(Math.round(1000 * time) / 1000 + 1e-9).toFixed(1)} s`;
}
