// Both profiles of a wheel in one chart, and their difference with its bound.
import { lineChart } from "../charts/line.js";
import { quantity } from "../charts/numbers.js";
import { answered, Refused } from "./frames.js";
import { fill } from "./texts.js";

const texts = JSON.parse(document.getElementById("compared-texts").textContent);

// The outcome may be put in place anew: listened to from above.
document.getElementById("main").addEventListener("click", (event) => {
  const button = event.target.closest("[data-show-profiles]");
  if (button) show(button.parentElement);
});

async function show(place) {
  try {
    const told = await (await answered(place.dataset.profiles)).json();
    if (told.d_mm) draw(place, told);
    else place.textContent = texts.no_profile;
  } catch (error) {
    place.textContent = error instanceof Refused ? error.message : texts.unreachable;
  }
}

function draw(place, told) {
  const { frame } = place.dataset;
  const [both, difference] = [0, 1].map(() => document.createElement("div"));
  place.replaceChildren(
    titled(fill(texts.profiles_title, { frame })), both, titled(texts.difference_title), differing(told), difference,
  );
  const units = { x: "mm", y: "mm" };
  lineChart(both, {
    x: told.d_mm,
    series: [
      { label: texts.before, values: told.before_mm, colour: "--left" },
      { label: texts.after, values: told.after_mm, colour: "--right" },
    ],
    labels: { title: fill(texts.profiles_title, { frame }), x: texts.d, y: texts.h },
    units,
    digits: { x: 2, y: 3 },
  });
  lineChart(difference, {
    x: told.d_mm,
    series: [
      { label: texts.difference, values: told.difference_um, colour: "--accent" },
    ],
    labels: { title: texts.difference_title, x: texts.d, y: texts.difference },
    units: { ...units, y: "µm" },
    digits: { x: 2, y: 1 },
  });
}

/** Return in words how far the profiles differ; nothing where only one was seen. */
function differing({ difference_um: differences, u95_um: bounds }) {
  const known = differences.filter((each) => each !== null).map(Math.abs);
  const sorted = bounds.filter((each) => each !== null).sort((a, b) => a - b);
  const said = document.createElement("p");
  if (known.length) {
    said.textContent = fill(texts.profiles_differ, {
      most: quantity(Math.max(...known), "µm", 1),
      bound: quantity(sorted[Math.floor(sorted.length / 2)], "µm", 0),
    });
  }
  return said;
}

function titled(text) {
  const title = document.createElement("h3");
  title.textContent = text;
  return title;
}
