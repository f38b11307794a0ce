// Where the sensor measures, and where dots have been seen; and which way the target was tilted.
import { plot, shape } from "./elements.js";

const WIDTH = 320;
const RIM_DEG = 45;
const MIDDLE = 120;
const RADIUS = 104;

/** Return the picture by cells: seen, still missing, or not needed. */
export function fieldPlot(guidance, label) {
  const [width, height] = guidance.size_px ?? [4, 3];
  const tall = (WIDTH * height) / width;
  const rows = guidance.dots_on_cells.length;
  const columns = guidance.dots_on_cells[0].length;
  const cells = guidance.dots_on_cells.flatMap((row, down) => row.map((dots, across) => {
    const wanted = guidance.wanted_cells[down][across];
    const kind = dots && wanted ? "cell seen" : wanted ? "cell missing" : "cell";
    const [x, y] = [(across * WIDTH) / columns, (down * tall) / rows];
    const box = shape("rect", { x: x + 1, y: y + 1, width: WIDTH / columns - 2, height: tall / rows - 2, class: kind });
    const text = shape("text", { x: x + WIDTH / columns / 2, y: y + tall / rows / 2 + 4, "text-anchor": "middle" }, dots ? String(dots) : wanted ? "?" : "");
    return [box, text];
  }));
  const next = guidance.next
    ? shape("circle", { cx: guidance.next.across * WIDTH, cy: guidance.next.down * tall, r: 13, class: "wanted" }) : null;
  return plot(WIDTH, tall, label, cells, next);
}

/** Return the tilts so far as a map: the direction is that of the edge that was near. */
export function tiltPlot(guidance, label) {
  const rings = [15, 30, RIM_DEG].map((degrees) => shape("circle", { cx: MIDDLE, cy: MIDDLE, r: at(degrees), class: "ring" }));
  const marks = [15, 30, RIM_DEG].map((degrees) => shape("text", { x: MIDDLE + 3, y: MIDDLE - at(degrees) + 12 }, `${degrees}°`));
  const poses = guidance.poses.filter((pose) => pose.tilt_deg !== null).map((pose) => shape(
    "circle", { ...place(pose), r: 5, class: "pose" }, shape("title", {}, String(pose.number)),
  ));
  const next = guidance.next ? shape("circle", { ...place(guidance.next), r: 8, class: "wanted" }) : null;
  return plot(2 * MIDDLE, 2 * MIDDLE, label, rings, marks, poses, next);
}

function at(degrees) {
  return (RADIUS * Math.min(degrees, RIM_DEG)) / RIM_DEG;
}

function place({ tilt_deg: tilt, near_edge_deg: near }) {
  const angle = (near * Math.PI) / 180;
  return { cx: MIDDLE + at(tilt) * Math.cos(angle), cy: MIDDLE + at(tilt) * Math.sin(angle) };
}
