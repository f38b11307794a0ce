// Jobs are followed by the events the station sends; where those do not come, they are asked for.
import { quantity } from "./words.js";

// A browser keeps six connections to a station, over all its windows: the page needs some, too.
const MOST_STREAMS = 2;
const ENDED = new Set(["done", "failed", "cancelled"]);
const streams = new Map();
let unfollowed = false;

function follow() {
  const shown = [...document.querySelectorAll("[data-job]")].map((part) => part.dataset.job);
  for (const job of streams.keys()) if (!shown.includes(job)) leave(job);
  for (const job of shown) if (!streams.has(job) && streams.size < MOST_STREAMS) begin(job);
  unfollowed = shown.some((job) => !streams.has(job));
}

function begin(job) {
  const stream = new EventSource(`/v1/jobs/${encodeURIComponent(job)}/events`);
  streams.set(job, stream);
  stream.addEventListener("job", (event) => {
    const told = JSON.parse(event.data);
    // The station ends the stream with the job, and a browser would ask for it again.
    if (ENDED.has(told.state)) leave(job);
    if (ENDED.has(told.state)) changed();
    else show(told);
  });
}

function leave(job) {
  streams.get(job).close();
  streams.delete(job);
}

function show({ id, progress, doing }) {
  const part = [...document.querySelectorAll("[data-job]")].find((each) => each.dataset.job === id);
  if (!part) return;
  part.querySelector("progress").value = progress;
  part.querySelector(".hint").textContent = `${quantity(100 * progress, "%", 0)} · ${doing}`;
}

function changed() {
  document.body.dispatchEvent(new CustomEvent("job-changed"));
}

// A stream that broke is tried again by the browser, or was refused; until it is there, ask.
document.body.addEventListener("second", () => {
  const broken = [...streams.values()].some((stream) => stream.readyState !== EventSource.OPEN);
  if (broken || unfollowed) changed();
});
document.body.addEventListener("htmx:afterSettle", follow);
follow();
