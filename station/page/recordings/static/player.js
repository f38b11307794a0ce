// Looking through a recording: the frame that is wanted last is shown, one is loaded at a time.
import { whenAppearanceChanges } from "../charts/colours.js";
import { moment, quantity } from "../charts/numbers.js";
import { addControls } from "./controls.js";
import { eventsTable, leftOut } from "./events_table.js";
import { answered, Frames, Refused } from "./frames.js";
import { Playing } from "./playing.js";
import { Stage } from "./stage.js";
import { fill, textsOf } from "./texts.js";
import { Timeline } from "./timeline.js";

const element = document.getElementById("player");
const count = Number(element.dataset.frames);
const texts = textsOf(element, "player");
const frames = new Frames(element.dataset.pictures);
const stage = new Stage(element);
const playing = new Playing(() => (wanted < count ? go(wanted + 1, true) : false));
const said = element.querySelector(".stage-said");
const failed = element.querySelector(".stage-failed");
let wanted = 1;
let loading = null;
let timeline = null;

const showPlace = addControls(element, { go, numberNow: () => wanted, playing });

/** Show a frame; resolves, once it or a later wanted one is shown, to true. */
function go(number, byPlaying = false) {
  if (!byPlaying) playing.stop();
  wanted = Math.min(Math.max(Math.round(number), 1), count);
  showPlace(wanted);
  timeline?.show(wanted);
  loading ??= load().finally(() => { loading = null; });
  return loading;
}

async function load() {
  let shown = null;
  while (shown !== wanted) {
    shown = wanted;
    try {
      tell(await frames.load(shown, stage.width));
    } catch (error) {
      refuse(error, texts);
    }
  }
  return true;
}

function tell(seen) {
  failed.hidden = true;
  stage.show(seen);
  const { found } = seen;
  const time = moment(Date.parse(found.time) / 1000);
  const told = [fill(texts.picture, { number: found.number, frame: found.frame, time })];
  told.push(found.focus === null ? texts.no_stripe : fill(texts.points, {
    count: found.stripe.points,
    width: quantity(found.focus.width_px, "px"),
    peak: found.focus.peak_counts,
    clipped: quantity(100 * found.brightness.clipped_share),
  }));
  said.textContent = told.join(". ");
  element.dataset.shown = found.number;
}

function refuse(error, { failed: words }) {
  playing.stop();
  failed.hidden = false;
  const why = error instanceof Refused ? error.message : texts.unreachable;
  failed.textContent = fill(words, { why });
}

async function addTimeline() {
  const place = element.querySelector(".timeline");
  const own = textsOf(element, "timeline");
  try {
    const document_ = await (await answered(element.dataset.timeline)).json();
    const names = textsOf(element, "events");
    const wheels = JSON.parse(element.querySelector("script[data-wheels]").textContent);
    timeline = new Timeline(place, { timeline: document_, wheels, texts: own, names, go });
    timeline.show(wanted);
    addEvents(document_, own, names);
    addWheelButtons(document_.places);
    element.dataset.timelineShown = "";
  } catch (error) {
    const why = error instanceof Refused ? error.message : texts.unreachable;
    place.textContent = fill(own.failed, { why });
  }
}

function addEvents(told, own, names) {
  const details = element.querySelector("details.events");
  const box = details.querySelector(".wide");
  const note = document.createElement("p");
  note.className = "hint";
  note.textContent = leftOut(told, own);
  box.replaceChildren(note, ...(told.events.length ? [eventsTable(told, own, names, go)] : []));
  details.hidden = false;
}

function addWheelButtons(places) {
  for (const button of document.querySelectorAll("button[data-frame], button[data-time]")) {
    const { frame, time } = button.dataset;
    const number = time ? timeline.numberAt(time) : places[frame]?.number;
    if (!number) continue;
    button.disabled = false;
    button.addEventListener("click", () => {
      go(number);
      element.querySelector(".stage").focus();
    });
  }
}

element.querySelector("[data-stripe]").addEventListener("change", (event) => {
  stage.withStripe = event.target.checked;
  stage.draw();
});
element.querySelector("[data-brighten]").addEventListener("change", (event) => {
  stage.brightened = event.target.checked;
  element.classList.toggle("brightened", event.target.checked);
  stage.draw();
});
whenAppearanceChanges(() => stage.draw());
const asked = Number(new URLSearchParams(location.search).get("frame"));
go(asked || 1);
addTimeline();
