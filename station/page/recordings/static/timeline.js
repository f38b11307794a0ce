// The time line of a recording: click, drag or arrow keys go to a frame.
import { whenAppearanceChanges } from "../charts/colours.js";
import { quantity } from "../charts/numbers.js";
import { Places } from "./places.js";
import { fill } from "./texts.js";
import { drawTimeline, HEIGHT_PX, LANES } from "./timeline_drawing.js";

const NEAR_PX = 8;

export class Timeline {
  #element;
  #texts;
  #places;
  #shown;
  #said;
  #canvas;
  #begun;
  #number = 1;

  /** `go(number)` shows a frame; `names` are the words of events by their kinds. */
  constructor(element, { timeline, wheels, texts, names, go }) {
    this.#element = element;
    this.#texts = texts;
    this.#places = new Places(timeline);
    this.#begun = timeline.from;
    this.#shown = {
      bins: timeline.bins.frames,
      wheels: wheels.map((each) => this.#wheel(each, timeline)).filter(Boolean),
      events: timeline.events.map((each) => ({
        part: this.#places.partAt(each.at_s), loss: each.loss, number: each.number,
        text: [names[each.kind] ?? each.kind, each.detail].filter(Boolean).join(": "),
      })),
      here: 0,
    };
    this.seconds = timeline.seconds;
    this.#build(describe(texts, timeline, this.#shown));
    this.#listen(go);
  }

  show(number) {
    this.#number = number;
    this.#shown.here = this.#places.partOf(number);
    this.#draw();
  }

  /** Return the number of the frame that was received at a moment, as RFC 3339 has it. */
  numberAt(time) {
    return this.#places.numberAt(this.#places.partAt(secondsFrom(this.#begun, time)));
  }

  /** Return where a wheel is marked: by its frames, or where they are another sensor's by its time. */
  #wheel({ first, last, time, standing }, { places }) {
    const [from, to] = [places[first], places[last]];
    if (from && to) {
      const [left, right] = [from, to].map((each) => this.#places.partAt(each.at_s));
      return { from: left, to: right, standing, number: from.number };
    }
    if (first !== null || !time) return null;
    const at = this.#places.partAt(secondsFrom(this.#begun, time));
    return { from: at, to: at, standing, number: this.#places.numberAt(at) };
  }

  #build(description) {
    this.#canvas = document.createElement("canvas");
    this.#canvas.style.height = `${HEIGHT_PX}px`;
    this.#canvas.tabIndex = 0;
    this.#canvas.setAttribute("role", "img");
    this.#canvas.setAttribute("aria-label", `${description} ${this.#texts.hint}`);
    this.#said = document.createElement("p");
    this.#said.className = "hint timeline-said";
    this.#said.textContent = description;
    this.#said.dataset.always = description;
    this.#element.replaceChildren(lanes(this.#texts), this.#canvas, this.#said);
    whenAppearanceChanges(() => this.#draw());
    new ResizeObserver(() => this.#draw()).observe(this.#element);
  }

  #draw() {
    drawTimeline(this.#canvas, this.#shown);
  }

  #listen(go) {
    const canvas = this.#canvas;
    const goThere = (event) => go(this.#under(event)?.number ?? this.#places.numberAt(partUnder(event)));
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      goThere(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) go(this.#places.numberAt(partUnder(event)));
      else this.#tell(event);
    });
    canvas.addEventListener("pointerleave", () => { this.#said.textContent = this.#said.dataset.always; });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      go(this.#stepped(step));
    });
  }

  /** Return the frame one part on; at least the next one. */
  #stepped(step) {
    const number = this.#places.numberAt(this.#shown.here + (step + 0.01) / this.#places.parts);
    return number === this.#number ? number + step : number;
  }

  #tell(event) {
    const under = this.#under(event);
    const part = partUnder(event);
    this.#said.textContent = under?.text ?? fill(this.#texts.at, {
      seconds: quantity(part * this.seconds), number: this.#places.numberAt(part),
    });
  }

  /** Return the event, or the wheel, under the pointer. */
  #under(event) {
    const y = event.offsetY;
    const x = event.offsetX;
    const width = this.#canvas.clientWidth;
    if (inLane(LANES.events, y)) {
      return nearest(this.#shown.events, (each) => Math.abs(each.part * width - x));
    }
    if (inLane(LANES.wheels, y)) {
      return nearest(this.#shown.wheels, (each) => Math.max(each.from * width - x, x - each.to * width, 0));
    }
    return null;
  }
}

function lanes(texts) {
  const names = document.createElement("div");
  names.className = "timeline-lanes";
  names.setAttribute("aria-hidden", "true");
  for (const [lane, [top]] of Object.entries(LANES)) {
    const name = document.createElement("span");
    name.textContent = texts[lane];
    name.style.top = `${top}px`;
    names.append(name);
  }
  return names;
}

function describe(texts, timeline, shown) {
  return fill(texts.description, {
    frames: timeline.frames,
    seconds: quantity(timeline.seconds),
    events: timeline.events.length + timeline.events_left_out,
    losses: timeline.events.filter((each) => each.loss).length,
    wheels: shown.wheels.length,
  });
}

function secondsFrom(begun, time) {
  return (Date.parse(time) - Date.parse(begun)) / 1000;
}

function inLane([top, low], y) {
  return y >= top - 4 && y <= low + 4;
}

function nearest(items, distance) {
  const found = items.reduce((best, each) => (
    !best || distance(each) < distance(best) ? each : best), null);
  return found && distance(found) <= NEAR_PX ? found : null;
}

function partUnder(event) {
  return event.offsetX / event.currentTarget.clientWidth;
}
