// How a sensor drifts: charts over time of what its calibrations say.
import { lineChart } from "../charts/line.js";
import { wordsOf } from "./words.js";

const say = wordsOf("drift-words");
const drift = JSON.parse(document.getElementById("drift").textContent);
const moments = drift.in_force.map((each) => ({ x: each.at_s, label: say("in_force"), colour: "--soft" }));

function chart(id, title, y, unit, digits, series) {
  lineChart(document.getElementById(id), { x: drift.at_s, series, moments }, {
    labels: { title, x: say("time"), y }, units: { y: unit }, digits: { y: digits }, times: true, height: 240,
  });
}

const one = (label, column) => [{ label, ...column, points: true }];
chart("drift-mid", say("mid"), say("distance"), "mm", 3, one(say("distance"), drift.mid_mm));
chart("drift-angle", say("angle"), say("angle_axis"), "°", 4, one(say("angle_axis"), drift.angle_deg));
chart("drift-offset", say("offset"), say("distance"), "mm", 3, one(say("distance"), drift.offset_mm));
chart("drift-residuals", say("residuals"), say("rms"), "px", 3, [
  { label: say("dots"), values: drift.dots_px, points: true },
  { label: say("stripe"), values: drift.stripe_px, points: true },
]);
