// A guided session: what the pictures show, what is enough, what to do next.
import { blockOf } from "./guided.js";
import { element } from "./elements.js";
import { wordsOf } from "./words.js";

const say = wordsOf("session-words");
const place = document.getElementById("guided");
let shown = "";
let asking = false;
let again = false;

async function look() {
  if (asking) {
    again = true;
    return;
  }
  asking = true;
  try {
    const answer = await fetch(place.dataset.guidance);
    const told = await answer.json();
    if (answer.ok) draw(told);
    else fail(told.detail);
  } catch {
    fail("");
  } finally {
    asking = false;
    if (again) {
      again = false;
      look();
    }
  }
}

function draw(told) {
  // Only what has changed is drawn: nothing moves under somebody's finger.
  const text = JSON.stringify(told);
  if (text === shown) return;
  shown = text;
  place.replaceChildren(...told.sensors.map((each) => blockOf(each, say, told.sensors.length > 1, told.state === "open")));
}

function fail(why) {
  shown = "";
  place.replaceChildren(element("p", { class: "warning", role: "status" }, say("unreachable", { why })));
}

document.body.addEventListener("pictures", look);
if (place.dataset.open === "true") document.body.addEventListener("five-seconds", look);
look();
