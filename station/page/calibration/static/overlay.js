// One picture with every point where it was observed and where it belongs, and what is between.
import { element, shape } from "./elements.js";

const MARKS_ACROSS = 220;
const PICTURE_WIDTH_PX = 1280;
const CLOSER = 1.6;

export class Overlay {
  /** Draw in `place`; `show` is "before", "after" or "both", deviations are drawn `factor` times. */
  constructor(place, say) {
    this.place = place;
    this.say = say;
    this.show = "both";
    this.factor = 1;
    this.view = null;
    this.picture = null;
    addMoves(this);
  }

  draw(picture) {
    this.picture = picture;
    this.view = around(picture);
    this.layers = shape("g");
    this.svg = shape("svg", { role: "img", "aria-label": picture.name }, ...ground(picture), this.layers);
    const none = picture.frame ? [] : [element("p", { class: "none" }, this.say("no_picture"))];
    this.place.replaceChildren(...none, this.svg);
    this.again();
  }

  /** Draw the marks anew; the picture below them stays, and is not loaded again. */
  again() {
    if (!this.picture) return;
    this.layers.replaceChildren(this.points());
    this.look();
  }

  points() {
    const unit = this.view.width / MARKS_ACROSS;
    const layers = shape("g", { "stroke-width": 0.55 * unit });
    for (const [points, size] of [[this.picture.stripe, 0.9], [this.picture.dots, 2]]) {
      layers.append(...marks(points, size * unit, this));
    }
    return layers;
  }

  zoom(factor) {
    const { view } = this;
    const [width, height] = [view.width / factor, view.height / factor];
    this.view = { u: view.u + (view.width - width) / 2, v: view.v + (view.height - height) / 2, width, height };
    this.again();
  }

  whole() {
    const [width, height] = this.picture.size_px;
    this.view = { u: -0.5, v: -0.5, width, height };
    this.again();
  }

  move(du, dv) {
    this.view = { ...this.view, u: this.view.u + du * this.view.width, v: this.view.v + dv * this.view.height };
    this.look();
  }

  look() {
    const { u, v, width, height } = this.view;
    this.svg.setAttribute("viewBox", `${u} ${v} ${width} ${height}`);
  }
}

function ground(picture) {
  if (!picture.frame) return [];
  const { recording, number } = picture.frame;
  const [width, height] = picture.size_px;
  const href = `/v1/recordings/${encodeURIComponent(recording)}/frames/${number}/picture?max_width=${PICTURE_WIDTH_PX}`;
  return [shape("image", { href, x: -0.5, y: -0.5, width, height, preserveAspectRatio: "none" })];
}

/** Return the part of the picture that its points take, at the shape of the whole. */
function around(picture) {
  const all = [...picture.dots.seen_px, ...picture.stripe.seen_px];
  const [us, vs] = [all.map(([u]) => u), all.map(([, v]) => v)];
  const [width, height] = picture.size_px;
  if (!all.length) return { u: -0.5, v: -0.5, width, height };
  const middle = [(Math.min(...us) + Math.max(...us)) / 2, (Math.min(...vs) + Math.max(...vs)) / 2];
  const part = Math.min(1, 1.2 * Math.max(
    (Math.max(...us) - Math.min(...us)) / width, (Math.max(...vs) - Math.min(...vs)) / height,
  ));
  return { u: middle[0] - (part * width) / 2, v: middle[1] - (part * height) / 2, width: part * width, height: part * height };
}

function marks(points, size, { show, factor }) {
  const paths = { seen: [], corrected: [], tie: [] };
  const rings = [];
  points.seen_px.forEach((seen, at) => {
    const corrected = points.corrected_px[at];
    const drawn = corrected ? seen.map((value, axis) => corrected[axis] + factor * (value - corrected[axis])) : seen;
    paths.seen.push(plus(drawn, size));
    if (corrected) {
      paths.corrected.push(times(corrected, size));
      paths.tie.push(`M${corrected}L${drawn}`);
    }
    if (!points.used[at]) rings.push(ring(drawn, size, points.reason[at]));
  });
  const wanted = { before: ["seen"], after: ["corrected"], both: ["tie", "seen", "corrected"] }[show];
  return [...wanted.map((kind) => shape("path", { d: paths[kind].join(""), class: `mark-${kind}` })), ...rings];
}

function plus([u, v], half) {
  const size = 1.4 * half; // longer than the other cross, so that each is seen where both are
  return `M${u - size} ${v}h${2 * size}M${u} ${v - size}v${2 * size}`;
}

function times([u, v], size) {
  const half = 0.75 * size;
  return `M${u - half} ${v - half}l${2 * half} ${2 * half}m0 ${-2 * half}l${-2 * half} ${2 * half}`;
}

function ring([cx, cy], size, reason) {
  return shape("circle", { cx, cy, r: 1.5 * size, class: "mark-unused" }, shape("title", {}, reason));
}

function addMoves(overlay) {
  const keys = {
    "+": () => overlay.zoom(CLOSER), "-": () => overlay.zoom(1 / CLOSER), 0: () => overlay.whole(),
    ArrowLeft: () => overlay.move(-0.1, 0), ArrowRight: () => overlay.move(0.1, 0),
    ArrowUp: () => overlay.move(0, -0.1), ArrowDown: () => overlay.move(0, 0.1),
  };
  overlay.place.addEventListener("keydown", (event) => {
    if (!overlay.picture || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  overlay.place.addEventListener("pointermove", (event) => {
    if (!event.buttons || !overlay.picture) return;
    const box = overlay.place.getBoundingClientRect();
    overlay.move(-event.movementX / box.width, -event.movementY / box.height);
  });
}
