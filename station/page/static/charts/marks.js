// What a chart shows besides its lines: limits, spans, moments, and bars of uncertainty.
import { colour } from "./colours.js";

const TEXT_PX = 12;
const CAP_PX = 3;

/** Fill spans of the y axis: `{from, to, colour}`; null is open. Drawn below everything. */
export function drawSpans(chart, spans) {
  within(chart, (context, box) => {
    for (const span of spans) {
      const top = span.to === null ? box.top : chart.valToPos(span.to, "y", true);
      const low = span.from === null ? box.top + box.height : chart.valToPos(span.from, "y", true);
      context.globalAlpha = 0.14;
      context.fillStyle = colour(span.colour);
      context.fillRect(box.left, top, box.width, low - top);
    }
  });
}

/** Draw levels of the y axis: `{value, label, colour, dash}`. */
export function drawLevels(chart, levels) {
  within(chart, (context, box) => {
    for (const level of levels) {
      const y = chart.valToPos(level.value, "y", true);
      stroke(context, level, [box.left, y], [box.left + box.width, y]);
      write(context, level.label, box.left + 6, y - 4, "left");
    }
  });
}

/** Draw moments of the x axis: `{x, label, colour, dash}`. */
export function drawMoments(chart, moments) {
  within(chart, (context, box) => {
    // Two that lie close are written one above the other.
    const lineHeight = 1.3 * TEXT_PX * ratio(chart);
    for (const [place, each] of moments.entries()) {
      const x = chart.valToPos(each.x, "x", true);
      stroke(context, each, [x, box.top], [x, box.top + box.height]);
      if (x >= box.left && x <= box.left + box.width) {
        // Behind the last third it would run out of the picture.
        const late = x > box.left + box.width * 0.67;
        write(context, each.label, x + (late ? -4 : 4), box.top + box.height - 6 - (place % 2) * lineHeight, late ? "right" : "left");
      }
    }
  });
}

/** Fill the u95 about a series' values. */
export function drawBand(chart, values, u95, colourName) {
  within(chart, (context) => {
    context.fillStyle = colour(colourName);
    context.globalAlpha = 0.2;
    context.beginPath();
    for (const way of [1, -1]) {
      const places = values.map((_, place) => place).filter((place) => values[place] !== null);
      if (way < 0) places.reverse();
      for (const place of places) {
        const x = chart.valToPos(chart.data[0][place], "x", true);
        context.lineTo(x, chart.valToPos(values[place] + way * u95[place], "y", true));
      }
    }
    context.fill();
  });
}

/** Draw bars of a series' u95 about its values. */
export function drawBars(chart, values, u95, colourName) {
  within(chart, (context) => {
    context.strokeStyle = colour(colourName);
    context.lineWidth = ratio(chart);
    const cap = CAP_PX * ratio(chart);
    context.beginPath();
    values.forEach((value, place) => {
      if (value === null || !u95[place]) return;
      const x = chart.valToPos(chart.data[0][place], "x", true);
      const [top, low] = [1, -1].map((way) => chart.valToPos(value + way * u95[place], "y", true));
      context.moveTo(x, top);
      context.lineTo(x, low);
      for (const y of [top, low]) {
        context.moveTo(x - cap, y);
        context.lineTo(x + cap, y);
      }
    });
    context.stroke();
  });
}

function within(chart, draw) {
  const { ctx: context, bbox: box } = chart;
  context.save();
  context.beginPath();
  context.rect(box.left, box.top, box.width, box.height);
  context.clip();
  context.font = `${TEXT_PX * ratio(chart)}px system-ui, sans-serif`;
  draw(context, box);
  context.restore();
}

function stroke(context, { colour: name = "--soft", dash = [6, 4] }, start, end) {
  context.strokeStyle = colour(name);
  context.fillStyle = colour(name);
  context.setLineDash(dash.map((length) => length * devicePixelRatio));
  context.lineWidth = devicePixelRatio;
  context.beginPath();
  context.moveTo(...start);
  context.lineTo(...end);
  context.stroke();
  context.setLineDash([]);
}

function write(context, text, x, y, align) {
  if (!text) return;
  context.textAlign = align;
  context.fillText(text, x, y);
}

function ratio(chart) {
  return chart.pxRatio || devicePixelRatio;
}
