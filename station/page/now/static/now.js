// Each sensor's picture lives; the rest of the page is kept as the station is.
import { beginButtons } from "./buttons.js";
import { beginParts } from "./parts.js";
import { SensorOfPage } from "./sensor.js";
import { Words } from "./words.js";
import { SensorView } from "./view.js";

const ARM = "/now/arm";
const words = new Words(JSON.parse(document.getElementById("now-texts").textContent), document.documentElement.dataset.zone);
const figures = [...document.querySelectorAll("figure[data-sensor]")];

beginParts();
for (const figure of figures) {
  const view = new SensorView(figure, words, figures.length, new SensorOfPage(figure.dataset.sensor));
  beginButtons(figure, view);
  view.begin();
  // A train comes: nobody looks any more.
  document.body.addEventListener("htmx:beforeRequest", (event) => {
    if (view.looking && event.detail.requestConfig.path === ARM) view.look(false);
  });
}
