// Drawing a time line: how many frames, which wheels, what happened, and the frame that is shown.
import { colour } from "../charts/colours.js";

const LABEL_PX = 12;
export const LANES = { frames: [4, 44], wheels: [52, 70], events: [78, 98] };
export const HEIGHT_PX = 102;
const MARK_PX = 5;
const LOOKS = {
  alarm: { colour: "--bad", sign: "\u2715" },
  warning: { colour: "--warn", sign: "!" },
  fine: { colour: "--good", sign: "\u2713" },
  unmeasured: { colour: "--soft", sign: "?" },
};

/** Draw `{bins, wheels: [{from, to, standing}], events: [{part, loss}], here}`; parts are 0 to 1. */
export function drawTimeline(canvas, shown) {
  const width = canvas.clientWidth;
  canvas.width = Math.round(width * devicePixelRatio);
  canvas.height = Math.round(HEIGHT_PX * devicePixelRatio);
  const context = canvas.getContext("2d");
  context.scale(devicePixelRatio, devicePixelRatio);
  for (const lane of Object.values(LANES)) drawGround(context, lane, width);
  drawBins(context, shown.bins, width);
  for (const wheel of shown.wheels) drawWheel(context, wheel, width);
  // Losses last: nothing may cover them.
  for (const event of [...shown.events].sort((a, b) => a.loss - b.loss)) drawEvent(context, event, width);
  drawHere(context, shown.here * width);
}

function drawGround(context, [top, low], width) {
  context.fillStyle = colour("--sunk");
  context.fillRect(0, top, width, low - top);
}

function drawBins(context, bins, width) {
  const [top, low] = LANES.frames;
  const most = Math.max(...bins, 1);
  context.fillStyle = colour("--accent");
  bins.forEach((count, place) => {
    if (!count) return;
    const height = Math.max(((low - top) * count) / most, 2);
    const left = (place * width) / bins.length;
    context.fillRect(left, low - height, Math.max(width / bins.length - 0.5, 1), height);
  });
}

function drawWheel(context, { from, to, standing }, width) {
  const [top, low] = LANES.wheels;
  const look = LOOKS[standing];
  const left = from * width;
  context.fillStyle = colour(look.colour);
  context.fillRect(left, low - 3, Math.max((to - from) * width, 3), 3);
  context.font = `bold ${LABEL_PX}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.fillText(look.sign, Math.min(Math.max(((from + to) / 2) * width, 5), width - 5), top + LABEL_PX);
}

function drawEvent(context, { part, loss }, width) {
  const [top, low] = LANES.events;
  const x = Math.min(Math.max(part * width, MARK_PX), width - MARK_PX);
  context.fillStyle = colour(loss ? "--bad" : "--soft");
  if (!loss) {
    context.fillRect(x - 0.75, top + 4, 1.5, low - top - 8);
    return;
  }
  const middle = (top + low) / 2;
  context.beginPath();
  context.moveTo(x, middle - MARK_PX - 2);
  context.lineTo(x + MARK_PX, middle);
  context.lineTo(x, middle + MARK_PX + 2);
  context.lineTo(x - MARK_PX, middle);
  context.fill();
}

function drawHere(context, x) {
  context.fillStyle = colour("--ink");
  context.fillRect(x - 1, 0, 2, HEIGHT_PX);
}
