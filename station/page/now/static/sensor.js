// What a sensor does, as the page that is kept as the station is says it.
export class SensorOfPage {
  #id;

  constructor(id) {
    this.#id = id;
  }

  get doing() {
    return this.#state.doing;
  }

  // Idle, or held by a calibration session, between whose pictures there is time.
  get lookable() {
    return this.doing === "idle" || "held" in this.#state;
  }

  // One that has recorded nothing yet is not asked for its last picture.
  get pictured() {
    return "pictured" in this.#state;
  }

  // A look that is refused is over: a train comes, or a session begins.
  get looksOn() {
    return false;
  }

  get #state() {
    return document.getElementById(`sensor-${this.#id}-doing`).dataset;
  }
}
