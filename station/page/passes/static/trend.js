// How a reading of a wheelset changed over its passes; which reading is in the address bar.
import { lineChart } from "../charts/line.js";

export function beginTrend(place, choice) {
  const asked = new URLSearchParams(location.search).get("trend");
  if ([...choice.options].some((option) => option.value === asked)) choice.value = asked;
  let chart = null;

  async function show() {
    const quantity = choice.value;
    let trend = null;
    try {
      const answer = await fetch(place.dataset.from + encodeURIComponent(quantity));
      if (answer.status !== 404) {
        if (!answer.ok) throw new Error(`answered ${answer.status}`);
        trend = await answer.json();
      }
    } catch {
      if (quantity === choice.value) tell(place.dataset.failed, "refused");
      return;
    }
    if (quantity !== choice.value) return; // another was chosen meanwhile
    chart?.destroy();
    chart = null;
    if (!trend?.x.length) {
      tell(place.dataset.alone, "empty");
      return;
    }
    const title = choice.selectedOptions[0].textContent;
    const box = document.createElement("div");
    place.replaceChildren(box, ...trend.rates.map(line));
    chart = lineChart(box, trend, {
      labels: { title, x: place.dataset.at, y: title },
      units: { y: "mm" },
      digits: { y: 2 },
      times: true,
      height: 320,
    });
  }

  function tell(text, kind) {
    const said = line(text);
    said.className = kind;
    place.replaceChildren(said);
  }

  choice.addEventListener("change", () => {
    const address = new URL(location.href);
    address.searchParams.set("trend", choice.value);
    history.replaceState(null, "", address);
    show();
  });
  show();
}

function line(text) {
  const said = document.createElement("p");
  said.className = "hint";
  said.textContent = text;
  return said;
}
