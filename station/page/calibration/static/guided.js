// What is shown of one sensor in a guided session.
import { adviceOf } from "./advice.js";
import { fieldPlot, tiltPlot } from "./coverage.js";
import { element } from "./elements.js";
import { lastPicture } from "./last.js";
import { quantity } from "./words.js";

const SHOWN = {
  poses: (value) => quantity(value, "", 0),
  covered: (value) => quantity(100 * value, "%", 0),
  focal: (value) => quantity(100 * value, "%", 2),
  sheet: (value) => quantity(value, "mm", 3),
  dots: (value) => quantity(value, "", 2),
  stripe: (value) => quantity(value, "", 2),
};

export function blockOf(guidance, say, several, open) {
  const parts = [nextCard(guidance, say, open), grid(guidance, say, open), posesCard(guidance, say)];
  const title = several ? [element("h2", {}, say("sensor", { sensor: guidance.sensor }))] : [];
  return element("div", { class: "guided-block" }, ...title, ...parts);
}

function nextCard(guidance, say, open) {
  const [first, ...more] = adviceOf(guidance, say);
  const last = guidance.poses.at(-1);
  const lines = open ? [element("p", { class: "do", role: "status" }, first), ...more.map((line) => element("p", { class: "hint" }, line))] : [];
  return element("section", { class: guidance.enough ? "card next enough" : "card next" },
    element("h2", {}, say("next_title")), ...lines,
    element("p", {}, last ? foundIn(last, say) : say("no_pictures")));
}

function foundIn(pose, say) {
  if (pose.why) return say("last_missing", { number: pose.number, why: pose.why });
  const stripe = pose.stripe ? say("last_stripe", { points: pose.stripe }) : say("last_no_stripe");
  return `${say("last_found", { number: pose.number, dots: pose.dots, dots_of: pose.dots_of })} ${stripe}`;
}

function grid(guidance, say, open) {
  return element("div", { class: "guided-grid" },
    lastPicture(guidance, say, open), criteriaCard(guidance, say), fieldCard(guidance, say), tiltCard(guidance, say));
}

function criteriaCard(guidance, say) {
  const rows = guidance.criteria.map((each) => {
    const shown = SHOWN[each.demand];
    const limit = say(each.at_least ? "at_least" : "at_most", { limit: shown(each.limit) });
    const state = each.value === null ? "unknown" : each.met ? "met" : "missing";
    return element("tr", {},
      element("th", { scope: "row" }, say(each.demand)),
      element("td", { class: "num" }, each.value === null ? "–" : shown(each.value)),
      element("td", { class: "num" }, limit),
      element("td", {}, element("span", { class: `badge ${{ met: "good", missing: "warn", unknown: "" }[state]}` }, say(state))));
  });
  return card(say("criteria"), tableOf([say("criterion"), `#${say("now")}`, `#${say("wanted")}`, say("state")], rows));
}

function fieldCard(guidance, say) {
  if (!guidance.wanted_cells) return card(say("field"), element("p", { class: "empty" }, say("field_unknown")));
  const wanted = guidance.wanted_cells.flat();
  const dots = guidance.dots_on_cells.flat();
  const seen = wanted.filter((each, at) => each && dots[at]).length;
  const said = say("field_said", { seen, wanted: wanted.filter(Boolean).length });
  return card(say("field"), fieldPlot(guidance, said), element("p", { class: "hint" }, said));
}

function tiltCard(guidance, say) {
  const known = guidance.poses.filter((pose) => pose.depth_mm !== null);
  const said = say("tilts_said", { count: known.length });
  const depths = known.map((pose) => pose.depth_mm);
  const reach = known.length ? [element("p", { class: "hint" }, say("depths", {
    low: quantity(Math.min(...depths), "mm", 0), high: quantity(Math.max(...depths), "mm", 0),
  }))] : [];
  return card(say("tilts"), tiltPlot(guidance, said), element("p", { class: "hint" }, said), ...reach);
}

function posesCard(guidance, say) {
  const rows = guidance.poses.map((pose) => element("tr", {},
    element("th", { scope: "row" }, String(pose.number)),
    element("td", {}, pose.why ? `${say("not_found")}: ${pose.why}` : say("yes")),
    element("td", { class: "num" }, `${pose.dots} / ${pose.dots_of}`),
    element("td", { class: "num" }, String(pose.stripe)),
    element("td", { class: "num" }, quantity(pose.tilt_deg, "°", 0)),
    element("td", { class: "num" }, quantity(pose.depth_mm, "mm", 0))));
  const heads = [say("number"), say("found"), ...["dots_found", "stripe_found", "tilt", "depth"].map((key) => `#${say(key)}`)];
  return card(say("poses_title"), rows.length ? tableOf(heads, rows) : element("p", { class: "empty" }, say("no_pictures")));
}

function card(title, ...content) {
  return element("section", { class: "card" }, element("h3", {}, title), ...content);
}

/** Return a table; the heads of columns of numbers begin with "#". */
function tableOf(heads, rows) {
  const head = element("tr", {}, ...heads.map((text) => element(
    "th", { scope: "col", class: text.startsWith("#") ? "num" : null }, text.replace("#", ""),
  )));
  return element("div", { class: "wide" }, element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows)));
}
