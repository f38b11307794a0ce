// The drawings of a report: the figures are had once, a picture's points when it is looked at.
import { drawByPicture } from "./bypicture.js";
import { drawComparison } from "./comparison.js";
import { drawHistogram } from "./histogram.js";
import { drawNeedles } from "./needles.js";
import { beginPictures } from "./pictures.js";
import { drawMap, quantile } from "./shades.js";
import { quantity, wordsOf } from "./words.js";

const say = wordsOf("report-words");
const place = document.getElementById("drawings");
const at = (id) => document.getElementById(id);

function drawSheet(sheet) {
  const known = sheet.values_mm.filter((value) => value !== null);
  const label = known.length ? say("map_said", {
    rms: quantity(sheet.rms_mm, "mm", 4),
    low: quantity(quantile(known, 0), "mm", 4), high: quantity(quantile(known, 1), "mm", 4),
  }) : "";
  drawMap(at("sheet-map"), sheet, say, label);
}

async function begin() {
  const answer = await fetch(place.dataset.figures);
  if (!answer.ok) throw new Error(String(answer.status));
  const figures = await answer.json();
  beginPictures(place, figures.pictures, say);
  drawByPicture(at("by-picture"), figures.pictures, say);
  drawHistogram(at("dots-histogram"), figures.histograms.dots, say, false);
  drawHistogram(at("stripe-histogram"), figures.histograms.stripe, say, true);
  drawNeedles(at("dots-field"), figures.field.dots, figures.size_px, say);
  drawNeedles(at("stripe-field"), figures.field.stripe, figures.size_px, say);
  drawSheet(figures.sheet);
  drawComparison(at("comparison-map"), figures.comparison, say);
}

begin().catch(() => {
  for (const id of ["overlay", "sheet-map", "comparison-map"]) at(id).textContent = say("unreachable");
});
