// The last picture of a session with the dots and the stripe that were found on it.
import { element, plot, shape } from "./elements.js";

const WIDTH = 480;

export function lastPicture(guidance, say, open) {
  const title = element("h3", {}, say("picture"));
  const last = guidance.poses.at(-1);
  if (!last || !guidance.size_px) return element("section", { class: "card" }, title, element("p", { class: "empty" }, say("no_pictures")));
  const [width, height] = guidance.size_px;
  const unit = width / WIDTH;
  const picture = shape("image", { x: -0.5, y: -0.5, width, height, preserveAspectRatio: "none" });
  const drawn = plot(WIDTH, (WIDTH * height) / width, say("picture"),
    shape("rect", { x: -0.5, y: -0.5, width, height, class: "ground" }), picture,
    last.stripe_px.map(([cx, cy]) => shape("circle", { cx, cy, r: 1.2 * unit, class: "stripe" })),
    last.dots_px.map(([cx, cy]) => shape("circle", { cx, cy, r: 5 * unit, class: "dot", "stroke-width": 1.5 * unit })));
  drawn.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
  load(picture, open ? newest(guidance) : recorded(guidance));
  return element("section", { class: "card" }, title, drawn);
}

function newest({ sensor }) {
  return `/v1/sensors/${encodeURIComponent(sensor)}/picture?source=latest&max_width=${2 * WIDTH}`;
}

/** Return the address of the last pose's last frame, once the recording is closed. */
function recorded({ recording, poses, frames_a_pose: frames }) {
  return `/v1/recordings/${encodeURIComponent(recording)}/frames/${poses.length * frames}/picture?max_width=${2 * WIDTH}`;
}

async function load(picture, address) {
  const answer = await fetch(address);
  if (!answer.ok) return; // the points stand alone on a dark ground
  const here = URL.createObjectURL(await answer.blob());
  picture.addEventListener("load", () => URL.revokeObjectURL(here), { once: true });
  picture.setAttribute("href", here);
}
