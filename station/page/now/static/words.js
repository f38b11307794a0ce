// What is told of a picture, in the words of the page.
// As the shell writes times; of the languages browsers know, Swedish orders them so.
const WRITTEN = {
  year: "numeric", month: "2-digit", day: "2-digit",
  hour: "2-digit", minute: "2-digit", second: "2-digit", timeZoneName: "short",
};
const UNITS = [["days", 86400], ["hours", 3600], ["minutes", 60], ["seconds", 1]];

export class Words {
  #texts;
  #zone;

  constructor(texts, zone) {
    this.#texts = texts;
    // Without a zone in its settings the station's is not known here: the browser's, which it names.
    this.#zone = zone || undefined;
  }

  say(key, values = {}) {
    return this.#texts[key].replace(/\{(\w+)\}/g, (_, name) => String(values[name]));
  }

  lasting(seconds) {
    const [unit, length] = UNITS.find((each) => seconds >= each[1]) ?? UNITS.at(-1);
    return this.say(unit, { count: Math.max(0, Math.floor(seconds / length)) });
  }

  // A moment as the shell's own times are: in the station's zone, and in UTC at a button's touch.
  time(iso) {
    const element = document.createElement("time");
    element.dateTime = iso;
    element.append(this.#span("local", iso, this.#zone), this.#span("utc", iso, "UTC"));
    return element;
  }

  percent(share) {
    const percent = 100 * share;
    return `${percent.toFixed(percent < 0.1 && percent > 0 ? 3 : 1)}\u202f%`;
  }

  stripe(document_) {
    const { focus, stripe } = document_;
    if (focus === null) return this.say("no_stripe");
    return this.say("stripe", { points: stripe.points, width: focus.width_px.toFixed(2) });
  }

  #span(name, iso, timeZone) {
    const span = document.createElement("span");
    span.className = name;
    span.textContent = new Intl.DateTimeFormat("sv-SE", { timeZone, ...WRITTEN }).format(new Date(iso));
    return span;
  }
}
