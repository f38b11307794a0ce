// Deviations over their predicted sigma, beside the normal distribution that true sigmas give.
import { plot, shape } from "./elements.js";

const WIDTH = 400;
const HEIGHT = 200;
const FOOT = 34;
const SIDE = 12;

export function drawHistogram(place, histogram, say, second) {
  if (!histogram.points) {
    place.textContent = say("no_points");
    return;
  }
  const { counts, edges, points } = histogram;
  const step = edges[1] - edges[0];
  const density = counts.map((count) => count / points / step);
  const highest = Math.max(0.45, 1.1 * Math.max(...density));
  const [low, high] = [edges[0], edges.at(-1)];
  const x = (value) => SIDE + ((value - low) / (high - low)) * (WIDTH - 2 * SIDE);
  const y = (value) => HEIGHT - FOOT - (value / highest) * (HEIGHT - FOOT - 8);
  const bars = density.map((value, place_) => shape("rect", {
    x: x(edges[place_]), y: y(value), width: x(edges[place_ + 1]) - x(edges[place_]) - 0.5,
    height: y(0) - y(value), class: second ? "bar second" : "bar",
  }));
  const normal = Array.from({ length: 81 }, (_, at) => {
    const value = low + ((high - low) * at) / 80;
    return `${x(value)},${y(Math.exp(-0.5 * value ** 2) / Math.sqrt(2 * Math.PI))}`;
  });
  const marks = [-4, -2, 0, 2, 4].map((value) => shape(
    "text", { x: x(value), y: HEIGHT - FOOT + 15, "text-anchor": "middle" }, String(value).replace("-", "−"),
  ));
  const said = say("histogram_said", {
    points, rms: histogram.rms.toFixed(2), beyond: histogram.beyond,
  });
  const axis = shape("text", { x: WIDTH / 2, y: HEIGHT - 3, "text-anchor": "middle" }, say("sigma_axis"));
  const caption = document.createElement("p");
  caption.className = "hint";
  caption.textContent = said;
  place.replaceChildren(
    plot(WIDTH, HEIGHT, said, bars, shape("polyline", { points: normal.join(" "), class: "curve" }), marks, axis),
    caption,
  );
}
