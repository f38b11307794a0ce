// What readings would be with a calibration: their shifts beside what both calibrations leave open.
import { element } from "./elements.js";
import { quantity, wordsOf } from "./words.js";

const place = document.getElementById("shifts");
const say = wordsOf("shifts-words");
const name = wordsOf("quantities");

async function drawShifts() {
  const answer = await fetch(place.dataset.shifts);
  if (!answer.ok) throw new Error(String(answer.status));
  const told = await answer.json();
  if (!told.shifts.length) {
    place.replaceChildren(element("p", { class: "hint" }, say("none", { why: told.reason })));
    return;
  }
  place.replaceChildren(verdict(told), most(told), table(told), wheel(told));
}

function verdict({ shifts, within }) {
  const beyond = shifts.filter((each) => !each.within);
  const every = beyond.length === shifts.length;
  const some = () => say("some_beyond", { which: beyond.map((each) => name(each.quantity)).join(", ") });
  const text = within ? say("all_within") : every ? say("all_beyond") : some();
  return element("p", {},
    element("span", { class: within ? "badge good" : "badge warn" }, say(within ? "within" : "beyond")), " ", text);
}

function most({ shifts }) {
  const largest = shifts.reduce((one, other) => (Math.abs(other.shift_mm) > Math.abs(one.shift_mm) ? other : one));
  const values = {
    by: quantity(Math.abs(largest.shift_mm), "mm", 4), which: name(largest.quantity),
    stated: quantity(largest.reading_u95_mm, "mm", 3),
  };
  return element("p", {}, say(largest.reading_u95_mm === null ? "most" : "most_beside", values));
}

function table({ shifts }) {
  const heads = ["quantity", "by", "u95", "stated", "state"];
  return element("div", { class: "wide" }, element("table", {},
    element("caption", { class: "hidden-text" }, say("caption")),
    element("thead", {}, element("tr", {}, heads.map((key) => element(
      "th", { scope: "col", class: ["quantity", "state"].includes(key) ? null : "num" }, say(key),
    )))),
    element("tbody", {}, shifts.map((each) => row(each))),
  ));
}

function row(shift) {
  return element("tr", {},
    element("th", { scope: "row" }, name(shift.quantity)),
    element("td", { class: "num" }, signed(shift.shift_mm)),
    element("td", { class: "num" }, quantity(shift.u95_mm, "", 4)),
    element("td", { class: "num" }, quantity(shift.reading_u95_mm, "", 3)),
    element("td", {}, element(
      "span", { class: shift.within ? "badge good" : "badge warn" }, say(shift.within ? "within" : "beyond"),
    )));
}

function signed(value) {
  const text = quantity(value, "", 4);
  return value > 0 ? `+${text}` : text;
}

function wheel(told) {
  const on = told.pass_id === null ? say("told_on_wheel") : say("told_on", { pass: told.pass_id });
  return element("p", { class: "hint" },
    on, " ", element("a", { href: `/wheels/${told.measurement}` }, say("look")), ". ", say("independent"));
}

drawShifts().catch(() => place.replaceChildren(element("p", { class: "warning" }, say("unreachable"))));
