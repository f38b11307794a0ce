// Moving and zooming: mouse, fingers, keys.
const STEP = 1.5;
const WHEEL_PX = 400;
const MOVE_PX = 60;

/** Let a person move `view` on `field`, which then takes the focus. */
export function addGestures(field, view) {
  addWheel(field, view);
  addPointers(field, view);
  addKeys(field, view);
}

function addWheel(field, view) {
  field.addEventListener("wheel", (event) => {
    // Seen as a whole, turning back scrolls the page.
    if (view.isWhole && event.deltaY > 0) return;
    event.preventDefault();
    view.zoomBy(2 ** (-event.deltaY / WHEEL_PX), pixelOf(field, event));
  }, { passive: false });
  field.addEventListener("dblclick", (event) => view.zoomBy(2, pixelOf(field, event)));
}

function addPointers(field, view) {
  const down = new Map();
  field.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    field.setPointerCapture(event.pointerId);
    down.set(event.pointerId, pixelOf(field, event));
  });
  field.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return;
    const now = pixelOf(field, event);
    const other = [...down].find(([pointer]) => pointer !== event.pointerId)?.[1];
    down.set(event.pointerId, now);
    if (other) view.zoomBy(distance(now, other) / Math.max(distance(before, other), 1), other);
    else view.moveBy(now[0] - before[0], now[1] - before[1]);
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
    field.addEventListener(name, (event) => down.delete(event.pointerId));
  }
}

function addKeys(field, view) {
  const actions = {
    ArrowLeft: () => view.moveBy(MOVE_PX, 0),
    ArrowRight: () => view.moveBy(-MOVE_PX, 0),
    ArrowUp: () => view.moveBy(0, MOVE_PX),
    ArrowDown: () => view.moveBy(0, -MOVE_PX),
    "+": () => view.zoomBy(STEP),
    "=": () => view.zoomBy(STEP),
    "-": () => view.zoomBy(1 / STEP),
    0: () => view.showWhole(),
    Escape: () => view.showWhole(),
  };
  field.tabIndex = 0;
  field.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in actions)) return;
    event.preventDefault();
    actions[event.key]();
  });
}

/** Return buttons that do the same. */
export function zoomButtons(view, words) {
  const row = document.createElement("div");
  row.className = "zoom row";
  for (const [sign, name, action] of [
    ["+", words.zoom_in, () => view.zoomBy(STEP)],
    ["\u2212", words.zoom_out, () => view.zoomBy(1 / STEP)],
    ["", words.reset, () => view.showWhole()],
  ]) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = sign || name;
    button.setAttribute("aria-label", name);
    button.addEventListener("click", action);
    row.append(button);
  }
  return row;
}

function pixelOf(field, event) {
  const box = field.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

function distance([x1, y1], [x2, y2]) {
  return Math.hypot(x2 - x1, y2 - y1);
}
