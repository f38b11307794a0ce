// Deviations over the picture, magnified: a pattern in them is what the model does not know of.
import { element, plot, shape } from "./elements.js";
import { quantity } from "./words.js";

const WIDTH = 400;
const LONGEST = 22;
const STEPS = [1, 2, 5];

export function drawNeedles(place, field, sizePx, say) {
  if (!field.at_px.length) {
    place.textContent = say("no_points");
    return;
  }
  const scale = WIDTH / sizePx[0];
  const height = sizePx[1] * scale;
  const factor = magnification(field.by_px, LONGEST / scale);
  const path = field.at_px.map(([u, v], at) => {
    const [du, dv] = field.by_px[at];
    return `M${(u * scale).toFixed(1)} ${(v * scale).toFixed(1)}l${(du * factor * scale).toFixed(1)} ${(dv * factor * scale).toFixed(1)}`;
  });
  const feet = field.at_px.map(([u, v]) => shape("circle", { cx: u * scale, cy: v * scale, r: 1, class: "foot" }));
  const said = [say("field_said", { factor, rms: quantity(field.rms_px, "px", 3) })];
  if (field.every > 1) said.push(say("field_every", { every: field.every }));
  place.replaceChildren(
    plot(WIDTH, height, said.join(" "),
      shape("rect", { x: 0.5, y: 0.5, width: WIDTH - 1, height: height - 1, class: "frame" }),
      feet, shape("path", { d: path.join(""), class: "needle" })),
    element("p", { class: "hint" }, said.join(" ")),
  );
}

/** Return the round number under which 19 of 20 deviations stay below a length. */
export function magnification(deviations, longest) {
  const lengths = deviations.map(([du, dv]) => Math.hypot(du, dv)).sort((a, b) => a - b);
  const usual = lengths[Math.floor(0.95 * (lengths.length - 1))];
  if (!(usual > 0)) return 1;
  const decade = 10 ** Math.floor(Math.log10(longest / usual));
  return Math.max(...STEPS.map((step) => step * decade).filter((each) => each * usual <= longest));
}
