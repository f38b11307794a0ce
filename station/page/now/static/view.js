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
const AWAY = new Set(["blind", "unavailable"]);

export class SensorView {
  #figure;
  #screen;
  #words;
  #pace;
  #sensor;
  #state;
  #tag = null;
  #inView = false;
  #looking = false;
  #bestWidth = null;
  #seen = null;

  // `state`: what the sensor does, whether it has pictures, whether it may be looked through.
  constructor(figure, words, sensors, state) {
    this.#figure = figure;
    this.#screen = figure.querySelector(".screen");
    this.#words = words;
    this.#pace = new Pace(sensors);
    this.#sensor = figure.dataset.sensor;
    this.#state = state;
  }

  // Told first whether it is in view: of many sensors only those on the screen are asked.
  begin() {
    let begun = false;
    new IntersectionObserver((entries) => {
      this.#inView = entries.at(-1).isIntersecting;
      if (!begun) this.#turn();
      begun = true;
    }).observe(this.#figure);
  }

  get looking() {
    return this.#looking;
  }

  get lookable() {
    return this.#state.lookable;
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
    if (watched && (this.#looking || this.#state.pictured)) await this.#ask();
    else if (watched) this.#note(this.#words.say("none"));
    if (this.#seen !== null) captionKind(this.#figure, this.#words, this.#seen, this.#state.doing);
    setTimeout(() => this.#turn(), watched ? Math.max(this.#pace.waitMs, SHORTEST_MS) : UNSEEN_MS);
  }

  async #ask() {
    const looking = this.#looking;
    const began = performance.now();
    try {
      const answer = await this.#fetch(looking);
      if (looking !== this.#looking) return;
      if (answer.status === 304) this.#pace.cameNone(this.#state.doing !== "idle");
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
    const { detail: why, state } = await problemOf(answer);
    if (this.#looking && this.#state.looksOn) {
      this.#lookOn(answer, why, state);
    } else if (this.#looking && answer.status !== 503) {
      this.#endLook(why);
    } else if (answer.status === 503) {
      this.#note(this.#words.say("busy"));
      this.#pace.isBusy(retryAfterS(answer));
    } else {
      this.#note(answer.status === 404 ? this.#words.say("none") : this.#words.say("failed", { why }));
      this.#pace.isAway();
    }
  }

  // Whoever holds a target has no hand free to press the button again.
  #lookOn(answer, why, state) {
    if (state === "recording") { // takes a picture for the session just now
      this.#pace.isBusy(0);
      return;
    }
    this.#note(AWAY.has(state) ? this.#words.say("away") : this.#words.say("failed", { why }));
    this.#pace.isBusy(retryAfterS(answer));
  }

  #endLook(why) {
    this.look(false);
    say(this.#words.say("look_over", { sensor: this.#sensor, why }), "good");
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

async function problemOf(answer) {
  try {
    return await answer.json();
  } catch {
    return { detail: String(answer.status) };
  }
}

function retryAfterS(answer) {
  return Number(answer.headers.get("Retry-After")) || 1;
}
