// Where a frame is seen: its picture with the points of the stripe over it, exactly registered.
import { colour } from "../charts/colours.js";

const WIDTHS = [320, 640, 1024, 1600];
const POINT_PX = 1.4;
const BRIGHTENED = "brightness(4)";

export class Stage {
  #canvas;
  #seen = null;

  constructor(element) {
    this.#canvas = element.querySelector("canvas");
    this.withStripe = true;
    this.brightened = false;
  }

  /** How wide a picture is worth asking for, px. */
  get width() {
    const wanted = this.#canvas.parentElement.clientWidth * devicePixelRatio;
    return WIDTHS.find((width) => width >= wanted) ?? WIDTHS.at(-1);
  }

  show(seen) {
    this.#seen = seen;
    this.draw();
  }

  draw() {
    if (!this.#seen) return;
    const { bitmap, found } = this.#seen;
    const canvas = this.#canvas;
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
    const context = canvas.getContext("2d");
    context.filter = this.brightened ? BRIGHTENED : "none";
    context.drawImage(bitmap, 0, 0);
    context.filter = "none";
    if (this.withStripe) drawPoints(context, found, bitmap.width / found.width_px);
  }
}

function drawPoints(context, found, scale) {
  context.fillStyle = colour("--laser");
  const size = Math.max(POINT_PX * (context.canvas.width / 640), POINT_PX);
  found.stripe.u_px.forEach((u, place) => {
    // (0, 0) is the centre of the first pixel; a canvas begins at its corner.
    const x = (u + 0.5) * scale;
    const y = (found.stripe.v_px[place] + 0.5) * scale;
    context.fillRect(x - size / 2, y - size / 2, size, size);
  });
}
