// In a calibration session each camera is looked through from the beginning, between its pictures.
import { beginButtons } from "./buttons.js";
import { SensorView } from "./view.js";
import { Words } from "./words.js";

const words = new Words(JSON.parse(document.getElementById("aim-texts").textContent), document.documentElement.dataset.zone);
const figures = [...document.querySelectorAll("#aim figure[data-sensor]")];
// A look that is refused, as while a picture is taken, is tried again: who aims has both hands full.
const IN_SESSION = { doing: "aimed", lookable: true, pictured: true, looksOn: true };

for (const figure of figures) {
  const view = new SensorView(figure, words, figures.length, IN_SESSION);
  beginButtons(figure, view);
  view.look(true);
  view.begin();
}
