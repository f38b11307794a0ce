// One frame after the other, at a rate that the station keeps up with.

export class Playing {
  #step;
  #on = false;

  /** `step()` shows the next frame and resolves to whether there was one. */
  constructor(step) {
    this.#step = step;
    this.rate = 5;
    this.whenChanged = () => {};
  }

  get on() {
    return this.#on;
  }

  toggle() {
    if (this.#on) this.stop();
    else this.#start();
  }

  stop() {
    if (!this.#on) return;
    this.#on = false;
    this.whenChanged(false);
  }

  async #start() {
    this.#on = true;
    this.whenChanged(true);
    while (this.#on) {
      const begun = performance.now();
      if (document.visibilityState === "visible" && !(await this.#step())) break;
      const left = 1000 / this.rate - (performance.now() - begun);
      await new Promise((resolve) => { setTimeout(resolve, Math.max(left, 0)); });
    }
    this.stop();
  }
}
