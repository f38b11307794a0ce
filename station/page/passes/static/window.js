// What part of the wheel is seen: millimetres to pixels, one scale for both axes.
const CLOSEST = 120;

export class Window {
  /** Show `whole`, {d: [least, greatest], h: [...]}, mm; `changed` is called when that moves. */
  constructor(whole, changed) {
    this.whole = whole;
    this.changed = changed;
    this.widthPx = 1;
    this.heightPx = 1;
    this.zoom = 1;
    this.middle = middleOf(whole);
  }

  /** Pixels a millimetre. */
  get scale() {
    const [wide, high] = [span(this.whole.d), span(this.whole.h)];
    return Math.min(this.widthPx / wide, this.heightPx / high) * this.zoom;
  }

  get isWhole() {
    return this.zoom === 1;
  }

  /** Return the pixel of a place (d, h). */
  place([d, h]) {
    return [
      this.widthPx / 2 + (d - this.middle[0]) * this.scale,
      this.heightPx / 2 - (h - this.middle[1]) * this.scale,
    ];
  }

  /** Return the place of a pixel. */
  at([x, y]) {
    return [
      this.middle[0] + (x - this.widthPx / 2) / this.scale,
      this.middle[1] - (y - this.heightPx / 2) / this.scale,
    ];
  }

  resize(widthPx, heightPx) {
    this.widthPx = widthPx;
    this.heightPx = heightPx;
    this.changed();
  }

  /** Zoom by a factor; the place under a pixel stays there. */
  zoomBy(factor, pixel = [this.widthPx / 2, this.heightPx / 2]) {
    const held = this.at(pixel);
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), CLOSEST);
    const now = this.at(pixel);
    this.#goTo([this.middle[0] + held[0] - now[0], this.middle[1] + held[1] - now[1]]);
  }

  moveBy(rightPx, downPx) {
    this.#goTo([this.middle[0] - rightPx / this.scale, this.middle[1] + downPx / this.scale]);
  }

  showWhole() {
    this.zoom = 1;
    this.#goTo(middleOf(this.whole));
  }

  /** Never lose the wheel: what is in the middle is a place of the whole. */
  #goTo([d, h]) {
    this.middle = this.zoom === 1
      ? middleOf(this.whole)
      : [within(d, this.whole.d), within(h, this.whole.h)];
    this.changed();
  }
}

function span([least, greatest]) {
  return greatest - least;
}

function middleOf({ d, h }) {
  return [(d[0] + d[1]) / 2, (h[0] + h[1]) / 2];
}

function within(value, [least, greatest]) {
  return Math.min(Math.max(value, least), greatest);
}
