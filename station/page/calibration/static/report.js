// The drawings of a report: the figures are had once, a picture's points when it is looked at.
import { drawByPicture } from "./bypicture.js";
import { drawComparison } from "./comparison.js";
import { drawHistogram } from "./histogram.js";
import { drawNeedles } from "./needles.js";
import { pictureList } from "./pictures.js";
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

async function draw(showPictures) {
  const wanted = place.dataset.figures;
  const answer = await fetch(wanted);
  if (!answer.ok) throw new Error(String(answer.status));
  const figures = await answer.json();
  if (wanted !== place.dataset.figures) return; // another sensor was wanted meanwhile
  showPictures(figures.pictures);
  drawByPicture(at("by-picture"), figures.pictures, say);
  drawHistogram(at("dots-histogram"), figures.histograms.dots, say, false);
  drawHistogram(at("stripe-histogram"), figures.histograms.stripe, say, true);
  drawNeedles(at("dots-field"), figures.field.dots, figures.size_px, say);
  drawNeedles(at("stripe-field"), figures.field.stripe, figures.size_px, say);
  // Of a rig's sensor these stand in the report of its own calibration.
  if (at("sheet-map")) drawSheet(figures.sheet);
  if (at("comparison-map")) drawComparison(at("comparison-map"), figures.comparison, say);
}

function unreachable() {
  for (const id of ["overlay", "sheet-map", "comparison-map"]) if (at(id)) at(id).textContent = say("unreachable");
}

function begin() {
  const showPictures = pictureList(place, say);
  const sensors = place.querySelectorAll("button[data-figures]");
  for (const button of sensors) {
    button.addEventListener("click", () => {
      Object.assign(place.dataset, { figures: button.dataset.figures, pictures: button.dataset.pictures });
      for (const each of sensors) each.setAttribute("aria-pressed", String(each === button));
      draw(showPictures).catch(unreachable);
    });
  }
  draw(showPictures).catch(unreachable);
}

if (place) begin();
