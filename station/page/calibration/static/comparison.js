// How far a calibration differs from the one in force.
import { element } from "./elements.js";
import { drawMap } from "./shades.js";
import { quantity } from "./words.js";

export function drawComparison(place, comparison, say) {
  if (comparison === null) {
    const why = place.dataset.inForce === "true" ? "comparison_self" : "comparison_none";
    place.replaceChildren(element("p", { class: "empty" }, say(why)));
    return;
  }
  if (comparison.why_not) {
    place.replaceChildren(element("p", { class: "warning" }, say("comparison_why", { why: comparison.why_not })));
    return;
  }
  const mm = (value) => quantity(value, "mm", 4);
  const said = say("comparison_said", {
    rms: mm(comparison.rms_mm), expected: mm(comparison.expected_mm), largest: mm(comparison.largest_mm),
    at: comparison.largest_at_px.map((value) => value.toFixed(0)).join(", "),
  });
  const sheet = say("comparison_sheet", { rms: mm(comparison.sheet_rms_mm), expected: mm(comparison.sheet_expected_mm) });
  const verdict = element("p", {}, element(
    "span", { class: comparison.agree ? "badge good" : "badge warn" },
    say(comparison.agree ? "comparison_agree" : "comparison_differ"),
  ));
  drawMap(place, comparison.map, say, said, element("p", { class: "hint" }, sheet));
  place.prepend(verdict);
}
