// Numbers along axes, and numbers as text.

/** Return about `count` round numbers between `low` and `high`. */
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

/** Return the lowest and the highest of 0 and the numbers in some lists. NaN is ignored. */
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

/** Return a number as text with at most `digits` decimals, and a typographic minus sign. */
export function shown(value, digits = 2) {
  if (Number.isNaN(value)) return "unknown";
  // Creating a format takes longer than using it.
  if (!FORMATS.has(digits)) FORMATS.set(digits, new Intl.NumberFormat("en-US", { maximumFractionDigits: digits }));
  return FORMATS.get(digits).format(value).replace("-", "\u2212");
}

/** Return a number of steps in words, such as "1 step". */
export function stepsOf(count) {
  return `${shown(count)} ${count === 1 ? "step" : "steps"}`;
}

/** Return a number of steps after a deadline in words, without a sign. */
export function inTime(steps) {
  return steps ? `${shown(Math.abs(steps))} ${steps > 0 ? "late" : "early"}` : "on time";
}

/** Return a time with one decimal, rounded like `seconds_of` in wording.py. */
export function seconds(time) {
  return `${(Math.round(1000 * time) / 1000 + 1e-9).toFixed(1)} s`;
}
