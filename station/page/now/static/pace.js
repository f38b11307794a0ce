// When a sensor's next picture is asked for: soon while there are new ones, seldom while there are
// none, and not before the station says so when it is busy.
const SOON_MS = 220;
const OF_EACH_SENSOR_MS = 70; // 2 Hz of each of 8: one process makes them all, one at a time
const LOOK_MS = 350;
const RECORDING_MS = 500;
const SELDOM_MS = 3000;
const SLOWER = 1.5;
const NOTHING_MS = 5000;

export class Pace {
  #sensors;
  #waitMs = 0;

  constructor(sensors) {
    this.#sensors = sensors;
  }

  get waitMs() {
    return this.#waitMs;
  }

  // A picture came, `tookMs` after it was asked for.
  cameNew(tookMs, looking) {
    const everyMs = looking ? LOOK_MS : Math.max(SOON_MS, this.#sensors * OF_EACH_SENSOR_MS);
    this.#waitMs = Math.max(everyMs - tookMs, 0);
  }

  // There is no newer one.
  cameNone(recording) {
    const mostMs = recording ? RECORDING_MS : SELDOM_MS;
    this.#waitMs = Math.min(Math.max(this.#waitMs, SOON_MS) * SLOWER, mostMs);
  }

  // The station has no time for it now.
  isBusy(retryAfterS) {
    const longerMs = Math.min(this.#waitMs * 2, NOTHING_MS);
    this.#waitMs = Math.max(longerMs, retryAfterS * 1000, SOON_MS);
  }

  // There is none, or nobody answers.
  isAway() {
    this.#waitMs = NOTHING_MS;
  }
}
