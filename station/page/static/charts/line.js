// Lines over a quantity or over time: a thin helper over uPlot (the page includes shell/charts.html).
import { colour, whenAppearanceChanges } from "./colours.js";
import { DATES } from "./dates.js";
import { addKeys } from "./keys.js";
import { drawBand, drawBars, drawLevels, drawMoments, drawSpans } from "./marks.js";
import { moment, quantity, zone } from "./numbers.js";
import { tableOf } from "./table.js";
import { words } from "./words.js";

const HEIGHT_PX = 280;
const LEAST_WIDTH_PX = 240;
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3]];

/**
 * Draw a chart in an element, and return it with `update(data)` and `destroy()`.
 *
 * data: {
 *   x: [numbers, ascending; seconds since 1970 where `times`],
 *   series: [{label, values: [number or null], u95: [...]?, colour: "--left"?, points: true?,
 *             line: false? (points alone), dash: [6, 4]?, spread: "band"? (not bars)}],
 *   levels: [{value, label, colour, dash}]?   limits, across
 *   moments: [{x, label, colour, dash}]?      changes, upright
 *   spans: [{from, to, colour}]?              bands of y, null open
 * }
 * options: {labels: {title, x, y}, units: {x, y}, digits: {x, y}?, times: false, height: 280,
 *           table: true, legend: true, range: {y: [least, greatest]}?}
 * Both may be given as one object.
 */
export function lineChart(element, data, options = data) {
  let now = data;
  const settings = { units: {}, digits: {}, height: HEIGHT_PX, table: true, legend: true, ...options };
  const field = document.createElement("div");
  field.className = "chart-field";
  const said = document.createElement("p");
  said.className = "hidden-text";
  said.setAttribute("aria-live", "polite");
  element.classList.add("chart");
  element.replaceChildren(field, said);
  field.setAttribute("role", "group");
  field.setAttribute("aria-label", `${settings.labels.title}. ${words.help}`);
  if (settings.table) {
    element.append(tableOf(settings.labels.title, heads(settings, now), () => rows(settings, now)));
  }

  let chart = make();
  addKeys(field, () => chart, (place) => { said.textContent = rows(settings, now)[place].join(", "); });
  const noLonger = whenAppearanceChanges(again);
  const sized = new ResizeObserver(() => chart.setSize(size(field, settings)));
  sized.observe(field);

  function make() {
    return new uPlot(optionsOf(settings, () => now, size(field, settings)), columns(now), field);
  }

  function again() {
    const { min, max } = chart.scales.x;
    chart.destroy();
    chart = make();
    if (min !== null) chart.setScale("x", { min, max });
  }

  return {
    /** Show other values; series that were added or taken away are drawn anew. */
    update(next) {
      const same = next.series.length === now.series.length;
      now = next;
      if (same) chart.setData(columns(now));
      else again();
    },
    destroy() {
      noLonger();
      sized.disconnect();
      chart.destroy();
    },
  };
}

function size(field, settings) {
  return { width: Math.max(field.clientWidth, LEAST_WIDTH_PX), height: settings.height };
}

function columns(data) {
  return [data.x, ...data.series.map((each) => each.values)];
}

function optionsOf(settings, dataNow, sized) {
  const { labels, units, digits, times } = settings;
  return {
    ...sized,
    tzDate: (seconds) => uPlot.tzDate(new Date(seconds * 1000), zone()),
    scales: { x: { time: Boolean(times) }, y: { range: rangeOf(settings, dataNow) } },
    legend: { show: settings.legend },
    cursor: { drag: { x: true, y: false } },
    axes: [{ ...axis(named(labels.x, units.x)), ...(times && { values: DATES }) }, { ...axis(named(labels.y, units.y)), size: 64 }],
    series: [
      { label: labels.x, value: (_, value) => shownX(value, settings) },
      ...dataNow().series.map((each, place) => seriesOf(each, place, units.y, digits.y)),
    ],
    hooks: {
      drawClear: [(chart) => drawSpans(chart, dataNow().spans ?? [])],
      draw: [(chart) => {
        drawLevels(chart, dataNow().levels ?? []);
        drawMoments(chart, dataNow().moments ?? []);
        dataNow().series.forEach((each, place) => {
          const spread = each.spread === "band" ? drawBand : drawBars;
          if (each.u95 && chart.series[place + 1].show) {
            spread(chart, each.values, each.u95, colourOf(each, place));
          }
        });
      }],
    },
  };
}

function axis(label) {
  return {
    label,
    stroke: () => colour("--soft"),
    grid: { stroke: () => colour("--line"), width: 1 },
    ticks: { stroke: () => colour("--line"), width: 1 },
    font: "13px system-ui, sans-serif",
    labelFont: "13px system-ui, sans-serif",
  };
}

function seriesOf(each, place, unit, digits) {
  const line = each.line ?? true;
  return {
    label: each.label,
    stroke: () => colour(colourOf(each, place)),
    width: line ? 2 : 0,
    // Lines differ by more than their colour.
    dash: each.dash ?? DASHES[place % DASHES.length],
    points: { show: each.points ?? !line, size: 7, fill: () => colour(colourOf(each, place)) },
    value: (_, value) => quantity(value, unit, digits),
  };
}

function colourOf(each, place) {
  return each.colour ?? ["--accent", "--right", "--good", "--warn"][place % 4];
}

/** Leave room for the bars of uncertainty and for the limits. */
function rangeOf({ range }, dataNow) {
  if (range?.y) return range.y;
  return () => {
    const wanted = (dataNow().levels ?? []).map((level) => level.value);
    for (const { values, u95 } of dataNow().series) {
      values.forEach((value, place) => {
        if (value === null || value === undefined) return;
        wanted.push(value + (u95?.[place] ?? 0), value - (u95?.[place] ?? 0));
      });
    }
    if (!wanted.length) return [0, 1];
    const [least, greatest] = wanted.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    const room = (greatest - least || Math.abs(greatest) || 1) * 0.08;
    return [least - room, greatest + room];
  };
}

function heads({ labels, units }, data) {
  return [named(labels.x, units.x), ...data.series.flatMap((each) => (
    each.u95 ? [named(each.label, units.y), `± (95\u202f%)`] : [named(each.label, units.y)]
  ))];
}

function rows(settings, data) {
  const digits = settings.digits.y;
  return data.x.map((x, place) => [shownX(x, settings), ...data.series.flatMap((each) => {
    const value = quantity(each.values[place], settings.units.y, digits);
    return each.u95 ? [value, quantity(each.u95[place], settings.units.y, digits)] : [value];
  })]);
}

function shownX(value, { times, units, digits }) {
  return times ? moment(value) : quantity(value, units.x, digits.x);
}

function named(label, unit) {
  return unit ? `${label}, ${unit}` : label;
}
