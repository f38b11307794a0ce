// The points of the stripe on a picture: of this very frame, in pixels of the whole frame.
import { svg } from "./svg.js";

/** Draw the stripe on each picture below an element that says where its stripe is had. */
export function showStripes(element) {
  for (const picture of element.querySelectorAll("[data-stripe]")) show(picture);
}

async function show(picture) {
  const found = picture.parentElement.querySelector(".found");
  try {
    const answer = await fetch(picture.dataset.stripe);
    if (!answer.ok) throw new Error(`answered ${answer.status}`);
    const frame = await answer.json();
    const points = overlay(frame);
    picture.append(points);
    addToggle(picture.parentElement.querySelector(".stripe-toggle"), points);
    found.textContent = found.dataset.words.replace("{points}", frame.stripe.points);
  } catch {
    found.textContent = found.dataset.failed;
  }
}

/** The points lie on what they were found in: a person takes them away to see it. */
function addToggle(button, points) {
  button.hidden = false;
  button.addEventListener("click", () => {
    const off = points.classList.toggle("off");
    button.setAttribute("aria-pressed", String(!off));
  });
}

/** Return the points as dots: in no order to be joined by a line. */
function overlay({ width_px: width, height_px: height, stripe }) {
  const radius = width / 400;
  const dots = stripe.u_px
    .map((u, place) => `M${u - radius},${stripe.v_px[place]}a${radius},${radius} 0 1,0 ${2 * radius},0a${radius},${radius} 0 1,0 ${-2 * radius},0`)
    .join("");
  return svg(
    "svg",
    { class: "overlay", viewBox: `-0.5 -0.5 ${width} ${height}`, "aria-hidden": "true" },
    svg("path", { d: dots }),
  );
}
