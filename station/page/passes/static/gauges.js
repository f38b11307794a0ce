// What is laid on the profile: datums, gauges with their readings, names of sensors.
import { line, svg, text } from "./svg.js";

const HEAD_PX = 6;

/** Return the marks of a drawing in a window. */
export function marksOf(drawing, view, words) {
  return [...datums(drawing, view, words), ...drawing.gauges.flatMap((each) => gauge(each, view))];
}

function datums(drawing, view, words) {
  const upright = (d, words_) => {
    const [x] = view.place([d, 0]);
    return [
      line([x, 0], [x, view.heightPx], "datum"),
      text([x + 4, view.heightPx - 34], words_, "mark"),
    ];
  };
  const tip = view.place(drawing.tip_mm);
  return [
    ...upright(0, words.flange_back),
    ...upright(drawing.tape_d_mm, words.tape.replace("{d}", drawing.tape_d_mm)),
    svg("circle", { class: "tip", cx: tip[0], cy: tip[1], r: 3 }),
    text([tip[0], tip[1] - 8], words.tip, "mark", "middle"),
  ];
}

function gauge(each, view) {
  const ends = each.ends.map((end) => view.place(end));
  const [x, y] = view.place(each.words_at);
  return [
    ...each.levels.map(([start, end]) => line(view.place(start), view.place(end), "level")),
    line(...ends, "gauge"),
    ...heads(...ends),
    ...each.touches.map((place) => {
      const [cx, cy] = view.place(place);
      return svg("circle", { class: "touch", cx, cy, r: 3.5 });
    }),
    text([x, y + each.down_px], each.words, "figure", each.anchor),
  ];
}

function heads([x1, y1], [x2, y2]) {
  const length = Math.hypot(x2 - x1, y2 - y1);
  if (length < 2 * HEAD_PX) return [];
  const [right, down] = [((x2 - x1) / length) * HEAD_PX, ((y2 - y1) / length) * HEAD_PX];
  const head = (x, y, way) => svg("path", {
    class: "head",
    d: `M${x},${y}L${x + way * right - down / 2},${y + way * down + right / 2}`
      + `L${x + way * right + down / 2},${y + way * down - right / 2}z`,
  });
  return [head(x1, y1, 1), head(x2, y2, -1)];
}
