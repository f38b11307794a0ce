// Uploading a recording: how far it is, and what the station says of it.
import { fill } from "./texts.js";

const section = document.getElementById("upload");
const texts = JSON.parse(section.querySelector("script").textContent);
const csrfToken = document.querySelector('meta[name="csrf-token"]').content;
const mostBytes = Number(section.dataset.mostBytes);
const form = section.querySelector("form");
const progress = section.querySelector("progress");
const said = section.querySelector('[role="status"]');
const [send, cancel] = form.querySelectorAll("button");

form.addEventListener("submit", (event) => {
  event.preventDefault();
  const file = form.querySelector("input").files[0];
  if (!file) tell(texts.no_file);
  else if (file.size > mostBytes) {
    tell(fill(texts.too_large, { size: inMegabytes(file.size), most: inMegabytes(mostBytes) }));
  } else upload(file);
});

// `fetch` tells nothing of how much has been sent.
function upload(file) {
  const call = new XMLHttpRequest();
  call.open("POST", "/v1/recordings");
  call.setRequestHeader("Content-Type", "application/octet-stream");
  call.setRequestHeader("X-CSRF-Token", csrfToken);
  call.upload.addEventListener("progress", ({ loaded, total }) => {
    progress.value = loaded / total;
    tell(loaded === total ? texts.checking : fill(texts.sending, {
      done: inMegabytes(loaded), all: inMegabytes(total),
    }));
  });
  call.addEventListener("load", () => finish(call));
  call.addEventListener("error", () => tell(texts.lost));
  call.addEventListener("abort", () => tell(texts.cancelled));
  call.addEventListener("loadend", () => setBusy(false));
  cancel.onclick = () => call.abort();
  setBusy(true);
  call.send(file);
}

function finish(call) {
  const answer = parsed(call.responseText);
  if (call.status >= 400) {
    tell(answer.detail ?? texts.lost);
    return;
  }
  tell(fill(texts.done, { id: answer.id }));
  const link = document.createElement("a");
  link.href = `/recordings/${encodeURIComponent(answer.id)}`;
  link.textContent = texts.open;
  said.append(" ", link);
}

function setBusy(busy) {
  send.disabled = busy;
  cancel.hidden = !busy;
  progress.hidden = !busy;
}

function tell(text) {
  said.textContent = text;
}

function inMegabytes(bytes) {
  return `${(bytes / 1e6).toFixed(1)}\u202fMB`;
}

function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return {};
  }
}
