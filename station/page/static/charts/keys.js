// A chart at the keyboard: read value by value, zoom, show all.
const ZOOM = 0.5;

/** Let keys move through a chart of uPlot; `tell(place)` says what is under the cursor. */
export function addKeys(element, chartOf, tell) {
  let place = null;
  const actions = {
    ArrowRight: () => go(1),
    ArrowLeft: () => go(-1),
    Home: () => go(-Infinity),
    End: () => go(Infinity),
    "+": () => zoom(ZOOM),
    "-": () => zoom(1 / ZOOM),
    0: () => showAll(chartOf()),
    Escape: () => showAll(chartOf()),
  };

  function go(step) {
    const chart = chartOf();
    const last = chart.data[0].length - 1;
    if (last < 0) return;
    place = Math.min(Math.max((place ?? (step > 0 ? -1 : last + 1)) + step, 0), last);
    chart.setCursor({ left: chart.valToPos(chart.data[0][place], "x"), top: 0 });
    tell(place);
  }

  function zoom(factor) {
    const chart = chartOf();
    const { min, max } = chart.scales.x;
    const middle = place === null ? (min + max) / 2 : chart.data[0][place];
    const half = ((max - min) / 2) * factor;
    if (half > 0) chart.setScale("x", { min: middle - half, max: middle + half });
  }

  element.tabIndex = 0;
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in actions)) return;
    event.preventDefault();
    actions[event.key]();
  });
}

/** Show all that a chart has. */
export function showAll(chart) {
  chart.setData(chart.data, true);
}
