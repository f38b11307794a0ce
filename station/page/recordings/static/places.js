// Where frames lie in the time of a recording, as far as its time line tells.

export class Places {
  #first;
  #frames;
  #seconds;
  #count;

  constructor(timeline) {
    this.#first = timeline.bins.first;
    this.#frames = timeline.bins.frames;
    this.#seconds = timeline.seconds || 1;
    this.#count = timeline.frames;
  }

  get parts() {
    return this.#frames.length;
  }

  /** Return the part of the time, 0 to 1, at which a frame lies. */
  partOf(number) {
    let low = 0;
    let high = this.parts - 1;
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.#first[middle] <= number) low = middle;
      else high = middle - 1;
    }
    // Of parts without a frame the number is that of the next one: the first of them has none before.
    const within = this.#frames[low] ? (number - this.#first[low]) / this.#frames[low] : 0;
    return (low + Math.min(Math.max(within, 0), 1)) / this.parts;
  }

  /** Return the number of the frame at a part of the time. */
  numberAt(part) {
    const place = Math.min(Math.max(part, 0), 1) * this.parts;
    const bin = Math.min(Math.floor(place), this.parts - 1);
    const number = this.#first[bin] + Math.floor((place - bin) * this.#frames[bin]);
    return Math.min(Math.max(number, 1), this.#count);
  }

  /** Return the part of the time of a moment, s since its begin. */
  partAt(seconds) {
    return Math.min(Math.max(seconds / this.#seconds, 0), 1);
  }
}
