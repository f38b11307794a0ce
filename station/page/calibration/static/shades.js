// A map over the picture: a value a cell, as shades with a scale.  Dark and light pages share it.
import { element } from "./elements.js";
import { quantity } from "./words.js";

// Viridis, which stays in order for those who do not tell red from green.
const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
const SCALE_STEPS = 64;

export function drawMap(place, map, say, label, ...more) {
  const known = map.values_mm.filter((value) => value !== null);
  if (!known.length) {
    place.replaceChildren(element("p", {}, say("no_sheet")), ...more);
    return;
  }
  const [low, high] = [quantile(known, 0), quantile(known, 0.98)];
  const rows = Math.ceil(map.values_mm.length / map.columns);
  const canvas = element("canvas", { width: map.columns, height: rows, role: "img", "aria-label": label });
  paint(canvas, map.values_mm.map((value) => (value === null ? null : shade(value, low, high))));
  canvas.style.imageRendering = "pixelated";
  canvas.style.aspectRatio = `${map.columns} / ${rows}`;
  const scale = element("canvas", { width: SCALE_STEPS, height: 1, "aria-hidden": "true" });
  paint(scale, Array.from({ length: SCALE_STEPS }, (_, at) => colour(at / (SCALE_STEPS - 1))));
  place.replaceChildren(
    element("div", { class: "map" }, canvas),
    element("div", { class: "scale" },
      element("span", {}, `${say("map_low")} ${quantity(low, "mm", 4)}`), scale,
      element("span", {}, `${quantity(high, "mm", 4)} ${say("map_high")}`)),
    element("p", { class: "hint" }, label),
    ...more,
  );
}

/** Return the value below which a part of all lies. */
export function quantile(values, part) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.round(part * (sorted.length - 1))];
}

function shade(value, low, high) {
  return colour(high > low ? Math.min((value - low) / (high - low), 1) : 0);
}

function colour(part) {
  const at = Math.min(Math.max(part, 0), 1) * (STOPS.length - 1);
  const [first, second] = [STOPS[Math.floor(at)], STOPS[Math.ceil(at)]];
  return first.map((value, channel) => Math.round(value + (second[channel] - value) * (at % 1)));
}

function paint(canvas, colours) {
  const context = canvas.getContext("2d");
  const pixels = context.createImageData(canvas.width, canvas.height);
  colours.forEach((rgb, at) => {
    if (rgb) pixels.data.set([...rgb, 255], 4 * at);
  });
  context.putImageData(pixels, 0, 0);
}
