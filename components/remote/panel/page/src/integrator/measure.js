// Measurements of a waveform.

/** Returns extremes, mean, effective value, frequency and duty cycle of the samples between two times. */
export function measure(times, values, from, to) {
  let [n, min, max, sum, squares] = [0, Infinity, -Infinity, 0, 0];
  for (let i = 0; i < values.length; i++) {
    const v = values[i];
    if (times[i] < from || to < times[i] || !Number.isFinite(v)) continue;
    n += 1;
    min = Math.min(min, v);
    max = Math.max(max, v);
    sum += v;
    squares += v * v;
  }
  if (n === 0) return { min: NaN, max: NaN, mean: NaN, rms: NaN, frequency: NaN, duty: NaN };
  return { min, max, mean: sum / n, rms: Math.sqrt(squares / n), ...cycles(times, values, from, to, (min + max) / 2) };
}

/** Whole cycles between rising crossings of the middle. */
function cycles(times, values, from, to, middle) {
  const rises = [];
  for (let i = 1; i < values.length; i++) {
    if (times[i - 1] < from || to < times[i]) continue;
    if (values[i - 1] <= middle && middle < values[i]) rises.push(i);
  }
  if (rises.length < 2) return { frequency: NaN, duty: NaN };
  const [first, last] = [rises[0], rises.at(-1)];
  let high = 0;
  for (let i = first; i < last; i++) if (middle < values[i]) high += 1;
  return { frequency: (rises.length - 1) / (times[last] - times[first]), duty: high / (last - first) };
}

/** Returns the place of the time that is nearest. */
export function nearest(times, x) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= x) low = middle;
    else high = middle;
  }
  return Math.abs(times[low] - x) <= Math.abs(times[high] - x) ? low : high;
}
