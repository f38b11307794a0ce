// What every page does: vouch for its calls, say what came of them, and tick.
import { beginHearing } from "./answers.js";
import { beginTicking } from "./ticking.js";
import { beginToggles } from "./toggles.js";
import { say, sayAgain, sayDone } from "./saying.js";

const csrfToken = document.querySelector('meta[name="csrf-token"]').content;

document.body.addEventListener("htmx:configRequest", (event) => {
  event.detail.headers["X-CSRF-Token"] = csrfToken;
});

document.body.addEventListener("said", (event) => sayDone(event.detail.text));

// Of parts that are asked for again and again only the first failure is said.
let unreachable = false;
document.body.addEventListener("htmx:sendError", () => {
  if (!unreachable) say(document.getElementById("said").dataset.unreachable, "bad");
  unreachable = true;
});
document.body.addEventListener("htmx:afterOnLoad", () => { unreachable = false; });

const sayRefused = (call) => say(problemIn(call), "bad");
document.body.addEventListener("htmx:responseError", (event) => sayRefused(event.detail.xhr));
beginHearing(sayRefused);

function problemIn(call) {
  try {
    return JSON.parse(call.responseText).detail;
  } catch {
    return document.getElementById("said").dataset.unforeseen;
  }
}

beginToggles();
beginTicking();
sayAgain();
