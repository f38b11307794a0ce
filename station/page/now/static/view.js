// One sensor's picture: asked for again and again, never twice at a time, not while nobody looks.
import { aim, caption, captionKind } from "./caption.js";
import { draw } from "./drawing.js";
import { Pace } from "./pace.js";
import { say } from "../saying.js";

const UNSEEN_MS = 500;
const SHORTEST_MS = 20;
const STEP_PX = 64; // pictures of a few widths are made, not one for every pixel of a window
const WIDEST_PX = { card: 640, large: 1600 };
const ENOUGH_MS = 30000;

export class SensorView {
  #figure;
  #screen;
  #words;
  #pace;
  #sensor;
  #tag = null;
  #inView = true;
  #looking = false;
  #bestWidth = null;
  #seen = null;

  constructor(figure, words, sensors) {
    this.#figure = figure;
    this.#screen = figure.querySelector(".screen");
    this.#words = words;
    this.#pace = new Pace(sensors);
    this.#sensor = figure.dataset.sensor;
  }

  begin() {
    new IntersectionObserver((entries) => { this.#inView = entries.at(-1).isIntersecting; }).observe(this.#figure);
    this.#turn();
  }

  get looking() {
    return this.#looking;
  }

  get lookable() {
    return this.#doing === "idle";
  }

  // The camera is asked for pictures, or the recording again.
  look(on) {
    this.#looking = on;
    this.#bestWidth = null;
    this.#tag = null;
    this.#part("aim").hidden = !on;
    this.#figure.dispatchEvent(new CustomEvent("looking", { detail: { on } }));
  }

  async #turn() {
    if (this.#looking && !this.lookable) this.#endLook(this.#words.say("look_busy"));
    const watched = this.#inView && document.visibilityState === "visible";
    if (watched && this.#mayHaveOne) await this.#ask();
    else if (watched) this.#note(this.#words.say("none"));
    if (this.#seen !== null) captionKind(this.#figure, this.#words, this.#seen, this.#doing);
    setTimeout(() => this.#turn(), watched ? Math.max(this.#pace.waitMs, SHORTEST_MS) : UNSEEN_MS);
  }

  async #ask() {
    const looking = this.#looking;
    const began = performance.now();
    try {
      const answer = await this.#fetch(looking);
      if (looking !== this.#looking) return;
      if (answer.status === 304) this.#pace.cameNone(this.#doing !== "idle");
      else if (answer.ok) await this.#show(answer, looking, began);
      else await this.#tell(answer);
    } catch {
      this.#note(this.#words.say("unreachable"));
      this.#pace.isAway();
    }
  }

  #fetch(looking) {
    const source = looking ? "look" : "latest";
    const address = `/v1/sensors/${this.#sensor}/view?source=${source}&max_width=${this.#widthPx}`;
    const headers = this.#tag === null ? {} : { "If-None-Match": this.#tag };
    return fetch(address, { headers, cache: "no-store", signal: AbortSignal.timeout(ENOUGH_MS) });
  }

  async #show(answer, looking, began) {
    this.#tag = looking ? null : answer.headers.get("ETag");
    const seen = await answer.json();
    const words = this.#words;
    await draw(this.#screen, seen, words.say("alt", { sensor: this.#sensor, stripe: words.stripe(seen) }));
    this.#note("");
    this.#seen = seen;
    caption(this.#figure, words, seen);
    if (looking) this.#bestWidth = aim(this.#figure, words, seen, this.#bestWidth);
    this.#pace.cameNew(performance.now() - began, looking);
  }

  async #tell(answer) {
    const why = await detailOf(answer);
    if (this.#looking && answer.status !== 503) {
      this.#endLook(why);
    } else if (answer.status === 503) {
      this.#note(this.#words.say("busy"));
      this.#pace.isBusy(Number(answer.headers.get("Retry-After")) || 1);
    } else {
      this.#note(answer.status === 404 ? this.#words.say("none") : this.#words.say("failed", { why }));
      this.#pace.isAway();
    }
  }

  #endLook(why) {
    this.look(false);
    say(this.#words.say("look_over", { sensor: this.#sensor, why }), "good");
  }

  get #state() {
    return document.getElementById(`sensor-${this.#sensor}-doing`).dataset;
  }

  get #doing() {
    return this.#state.doing;
  }

  // A sensor that has recorded nothing yet is not asked for its last picture.
  get #mayHaveOne() {
    return this.#looking || "pictured" in this.#state;
  }

  get #widthPx() {
    const widest = document.fullscreenElement === this.#figure ? WIDEST_PX.large : WIDEST_PX.card;
    const wanted = this.#screen.clientWidth * devicePixelRatio;
    return Math.min(widest, Math.max(STEP_PX, Math.ceil(wanted / STEP_PX) * STEP_PX));
  }

  #part(name) {
    return this.#figure.querySelector(`[data-part="${name}"]`);
  }

  #note(text) {
    this.#part("note").textContent = text;
    this.#part("note").hidden = text === "";
  }
}

async function detailOf(answer) {
  try {
    return (await answer.json()).detail;
  } catch {
    return String(answer.status);
  }
}
