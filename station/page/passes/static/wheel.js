// The page of a wheel: its profile and wear, the trend of its wheelset, and the stripe on its frames.
import { lineChart } from "../charts/line.js";
import { profileChart } from "./profile.js";
import { showStripes } from "./stripe.js";
import { beginTrend } from "./trend.js";

const words = JSON.parse(document.getElementById("profile-words").textContent);

async function showProfile(place) {
  const wear = document.getElementById("wear");
  try {
    const answer = await fetch(place.dataset.from, { headers: { Accept: "application/json" } });
    if (!answer.ok) throw new Error(`answered ${answer.status}`);
    const drawing = await answer.json();
    await profileChart(place, [drawing], words).drawn;
    showWear(wear, drawing.wear);
  } catch {
    for (const each of [place, wear]) each.replaceChildren(failure());
  }
}

function showWear(place, wear) {
  if (wear === null) {
    place.closest("section").hidden = true;
    return;
  }
  const texts = JSON.parse(document.getElementById("wheel-words").textContent);
  lineChart(place, {
    x: wear.d_mm,
    series: [{ label: texts.wear, values: wear.wear_mm, u95: wear.u95_mm, spread: "band", colour: "--laser" }],
    levels: [{ value: 0, label: "", colour: "--soft" }],
    labels: { title: texts.title, x: texts.d, y: texts.wear },
    units: { x: "mm", y: "mm" },
    digits: { x: 1, y: 2 },
    height: 240,
  });
}

function failure() {
  const line = document.createElement("p");
  line.className = "refused";
  line.setAttribute("role", "alert");
  line.textContent = words.failed;
  return line;
}

const profile = document.getElementById("profile");
if (profile) showProfile(profile);
const trend = document.getElementById("trend");
if (trend) beginTrend(trend, document.getElementById("trended"));
document.body.addEventListener("htmx:load", (event) => showStripes(event.detail.elt));
