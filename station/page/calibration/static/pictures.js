// The pictures of a calibration: the list, and the one that is looked at.
import { element } from "./elements.js";
import { Overlay } from "./overlay.js";
import { quantity } from "./words.js";

const CLOSER = 1.6;

/** Return what shows a list of pictures, in place of the one before. */
export function pictureList(place, say) {
  const table = document.getElementById("picture-table");
  const said = document.getElementById("overlay-said");
  const overlay = new Overlay(document.getElementById("overlay"), say);
  let asked = 0;

  async function show(at) {
    asked += 1;
    const mine = asked;
    for (const row of table.tBodies[0].rows) row.setAttribute("aria-current", String(row.sectionRowIndex === at));
    const answer = await fetch(`${place.dataset.pictures}${at}`);
    if (mine !== asked) return; // another was wanted meanwhile
    if (!answer.ok) {
      said.textContent = say("unreachable");
      return;
    }
    const picture = await answer.json();
    overlay.draw(picture);
    said.textContent = told(picture, say);
  }

  beginTools(overlay);
  return (pictures) => {
    const standing = pictures.some((each) => each.distance_mm !== null);
    for (const head of table.querySelectorAll("[data-standing]")) head.hidden = !standing;
    table.tBodies[0].replaceChildren(...pictures.map((each, at) => row(each, say, standing, () => show(at))));
    if (pictures.length) show(0);
  };
}

function row(picture, say, standing, show) {
  const button = element("button", { type: "button", "aria-label": say("show", { name: picture.name }) }, picture.name);
  button.addEventListener("click", show);
  const stands = standing ? [number(picture.tilt_deg, 0), number(picture.distance_mm, 0)] : [];
  return element("tr", {},
    element("th", { scope: "row" }, button),
    number(picture.dots_rms_px, 3), number(picture.stripe_rms_px, 3), stands);
}

function number(value, digits) {
  return element("td", { class: "num" }, quantity(value, "", digits));
}

function told(picture, say) {
  const parts = [say("picture_said", {
    name: picture.name,
    dots: picture.dots_used, dots_of: picture.dots_of, dots_rms: quantity(picture.dots_rms_px, "px", 3),
    stripe: picture.stripe_used, stripe_of: picture.stripe_of, stripe_rms: quantity(picture.stripe_rms_px, "px", 3),
  })];
  if (picture.left_out) parts.push(say("left_out", { why: picture.left_out }));
  for (const [kind, reason, count] of picture.unused) parts.push(say("unused", { count, kind: say(`kind_${kind}`), reason }));
  return [...parts, ...picture.warnings].join(" ");
}

function beginTools(overlay) {
  const shows = document.querySelectorAll("[data-show]");
  for (const button of shows) {
    button.addEventListener("click", () => {
      overlay.show = button.dataset.show;
      for (const each of shows) each.setAttribute("aria-pressed", String(each === button));
      overlay.again();
    });
  }
  document.getElementById("magnified").addEventListener("change", (event) => {
    overlay.factor = Number(event.target.value);
    overlay.again();
  });
  const zooms = { in: () => overlay.zoom(CLOSER), out: () => overlay.zoom(1 / CLOSER), all: () => overlay.whole() };
  for (const button of document.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => overlay.picture && zooms[button.dataset.zoom]());
  }
}
