// A grid with its figures in mm, for what is seen now.
import { line, text } from "./svg.js";

const STEPS_MM = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const LEAST_PX = 55;

/** Return the grid of a window and its figures; `words` name the axes. */
export function gridOf(view, words) {
  const step = STEPS_MM.find((mm) => mm * view.scale >= LEAST_PX) ?? STEPS_MM.at(-1);
  const [left, top] = view.at([0, 0]);
  const [right, low] = view.at([view.widthPx, view.heightPx]);
  const marks = [];
  for (const d of ticks(left, right, step)) {
    const [x] = view.place([d, 0]);
    marks.push(line([x, 0], [x, view.heightPx], "grid"));
    marks.push(text([x + 3, view.heightPx - 4], figure(d, step), "tick"));
  }
  for (const h of ticks(low, top, step)) {
    const [, y] = view.place([0, h]);
    marks.push(line([0, y], [view.widthPx, y], "grid"));
    // The corners belong to the names of the axes.
    const inCorner = y < 30 || y > view.heightPx - 16;
    if (!inCorner) marks.push(text([3, y - 3], figure(h, step), "tick"));
  }
  marks.push(text([view.widthPx - 4, view.heightPx - 18], words.d, "axis", "end"));
  marks.push(text([4, 14], words.h, "axis"));
  return marks;
}

function ticks(from, to, step) {
  const found = [];
  for (let count = Math.ceil(from / step); count * step <= to; count += 1) found.push(count * step);
  return found;
}

function figure(value, step) {
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  return value.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "\u2212");
}
