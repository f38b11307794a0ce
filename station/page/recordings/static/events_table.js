// The events of a recording as a table: what the time line shows, to be read and gone to.
import { quantity } from "../charts/numbers.js";
import { fill } from "./texts.js";

/** Return the table; `go(number)` shows a frame. */
export function eventsTable(timeline, texts, names, go) {
  const table = document.createElement("table");
  table.createCaption().textContent = texts.events_caption;
  table.caption.className = "hidden-text";
  const head = table.createTHead().insertRow();
  for (const name of [texts.time, texts.kind, texts.detail, texts.count, texts.frame]) {
    const cell = document.createElement("th");
    cell.scope = "col";
    cell.textContent = name;
    head.append(cell);
  }
  const body = table.createTBody();
  for (const event of timeline.events) addEvent(body.insertRow(), event, texts, names, go);
  return table;
}

/** Return what is to be said beside the table; empty where it has all events. */
export function leftOut(timeline, texts) {
  if (!timeline.events.length) return texts.no_events;
  return timeline.events_left_out ? fill(texts.left_out, { count: timeline.events_left_out }) : "";
}

function addEvent(row, event, texts, names, go) {
  const when = document.createElement("th");
  when.scope = "row";
  when.textContent = quantity(event.at_s, "s", 3);
  row.append(when);
  const kind = row.insertCell();
  kind.textContent = names[event.kind] ?? event.kind;
  if (event.loss) {
    const badge = document.createElement("span");
    badge.className = "badge bad";
    badge.textContent = texts.loss;
    kind.append(" ", badge);
  }
  row.insertCell().textContent = event.detail;
  row.insertCell().textContent = event.count || "";
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = event.number;
  button.setAttribute("aria-label", `${texts.go} ${event.number}`);
  button.addEventListener("click", () => go(event.number));
  row.insertCell().append(button);
}
