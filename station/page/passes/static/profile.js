// Measured profiles over their reference, with gauges, band and the sensors that saw each part.
import { addGestures, zoomButtons } from "./gestures.js";
import { marksOf } from "./gauges.js";
import { gridOf } from "./scales.js";
import { svg, text } from "./svg.js";
import { Window } from "./window.js";

const UM_PER_MM = 1000;
const LEAST_HEIGHT_PX = 260;
const SEVERAL = "several";

/**
 * Draw profiles in an element; return `destroy()` and the promise `drawn`, kept once they are seen.
 *
 * `drawings` are what /wheels/ID/drawing answers: the first with its gauges, others as thinner lines
 * over it, as of the same wheel measured by another calibration.  `words` are the texts
 * below `passes.profile`.
 */
export function profileChart(element, drawings, words) {
  const begun = performance.now();
  const [first] = drawings;
  const field = document.createElement("div");
  field.className = "profile-field";
  field.setAttribute("role", "group");
  field.setAttribute("aria-label", `${words.title}. ${words.hint}`);
  const picture = svg("svg", { class: "profile", role: "img", "aria-label": said(first, words) });
  const [grid, shapes, marks] = ["grid-layer", "shapes", "marks"].map((kind) => svg("g", { class: kind }));
  shapes.append(...drawings.flatMap((drawing, place) => shapesOf(drawing, place)));
  picture.append(grid, shapes, marks);
  field.append(picture);
  const names = namesOf(first);

  const view = new Window({ d: first.window_mm.d, h: first.window_mm.h }, draw);
  function draw() {
    const [x, y] = view.place([0, 0]);
    shapes.setAttribute("transform", `translate(${x} ${y}) scale(${view.scale / UM_PER_MM})`);
    grid.replaceChildren(...gridOf(view, words));
    marks.replaceChildren(...marksOf(first, view, words), ...names.map((name) => name(view)));
  }

  element.replaceChildren(zoomButtons(view, words), field, legendOf(drawings, words), sentence(first, words));
  addGestures(field, view);
  const fit = () => {
    const { d, h } = first.window_mm;
    const width = field.clientWidth;
    if (width === 0) return; // hidden, or no longer on the page: there is no scale
    const height = Math.max(LEAST_HEIGHT_PX, (width * (h[1] - h[0])) / (d[1] - d[0]));
    picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
    picture.setAttribute("height", height);
    view.resize(width, height);
  };
  const sized = new ResizeObserver(fit);
  sized.observe(field);
  fit();
  // Drawn is what a person sees: behind the next paint.
  const drawn = new Promise((resolve) => {
    requestAnimationFrame(() => setTimeout(() => resolve(performance.measure("profile-drawn", { start: begun }))));
  });
  return { destroy: () => sized.disconnect(), drawn };
}

function shapesOf(drawing, place) {
  const more = place === 0 ? "" : ` more-${place}`;
  const paths = drawing.strands.map(({ seen_by: seen, path: d }) => (
    svg("path", { class: `measured by-${seenBy(seen)}${more}`, d, "data-seen": seenBy(seen) })
  ));
  if (place > 0) return paths;
  const outline = drawing.reference.path;
  return [
    ...(drawing.lost ? [svg("path", { class: "lost", d: drawing.lost })] : []),
    ...(outline ? [svg("path", { class: "reference", d: outline })] : []),
    svg("path", { class: "band", d: drawing.band }),
    ...paths,
  ];
}

/** Return which sensor of a rig saw a part: its place among them, or several; 0 without a rig. */
function seenBy(seen) {
  return seen.length > 1 ? SEVERAL : seen[0] ?? 0;
}

/** Return what writes each sensor's name beside the longest part that it alone saw. */
function namesOf(drawing) {
  return drawing.sensors.flatMap((name, place) => {
    const at = drawing.names_at[place];
    if (!at) return [];
    return [(view) => {
      const [px, py] = view.place(at);
      return text([px + 8, py + 22], name, `sensor by-${place}`);
    }];
  });
}

function legendOf(drawings, words) {
  const [first] = drawings;
  const list = document.createElement("ul");
  list.className = "legend";
  const lines = first.sensors.length
    ? [...first.sensors.map((name, place) => [`measured by-${place}`, name]), [`measured by-${SEVERAL}`, words.several]]
    : [["measured by-0", words.measured]];
  const entries = [
    ...lines,
    ...drawings.slice(1).map((drawing, place) => [`measured more-${place + 1}`, drawing.label ?? ""]),
    ["band", words.band],
    ...(first.reference.path ? [["reference", first.reference.name], ["lost", words.lost]] : []),
  ];
  for (const [kind, name] of entries) {
    const entry = document.createElement("li");
    const shape = kind === "band" || kind === "lost"
      ? svg("rect", { class: kind, x: 1, y: 3, width: 24, height: 8 })
      : svg("path", { class: kind, d: "M1,7h24" });
    const key = svg("svg", { class: "profile key", viewBox: "0 0 26 14", width: 26, height: 14, "aria-hidden": "true" }, shape);
    entry.append(key, ` ${name}`);
    list.append(entry);
  }
  return list;
}

function sentence(drawing, words) {
  const line = document.createElement("p");
  line.className = "hint";
  line.textContent = drawing.reference.path
    ? words.hint
    : `${words.reference_gone.replace("{name}", drawing.reference.name)} ${words.hint}`;
  return line;
}

function said(drawing, words) {
  return words.said
    .replace("{points}", drawing.points)
    .replace("{reference}", drawing.reference.name)
    .replace("{gauges}", drawing.gauges.map((each) => each.words.trim()).join(", "));
}
