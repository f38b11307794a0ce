// Telling the person what came of a call; screen readers read it out.
const GONE_AFTER_MS = 8000;
const LEAVES_WITHIN_MS = 2000;
const KEPT_AS = "said";

// Says what was said as the page before was left for this one.
export function sayAgain() {
  const text = sessionStorage.getItem(KEPT_AS);
  sessionStorage.removeItem(KEPT_AS);
  if (text) say(text, "good");
}

// Says what was done; should the page be left at once, it is said on the next one.
export function sayDone(text) {
  say(text, "good");
  sessionStorage.setItem(KEPT_AS, text);
  setTimeout(() => sessionStorage.removeItem(KEPT_AS), LEAVES_WITHIN_MS);
}

export function say(text, kind) {
  const place = document.getElementById("said");
  // A part that is loaded every second fails every second: what stands there is not said again.
  if ([...place.children].some((line) => line.firstChild.textContent === text)) return;
  const line = document.createElement("div");
  line.className = `said ${kind}`;
  line.append(document.createElement("p"));
  line.firstChild.textContent = text;
  const close = document.createElement("button");
  close.type = "button";
  close.className = "quiet";
  close.textContent = place.dataset.close;
  close.addEventListener("click", () => line.remove());
  line.append(close);
  place.append(line);
  // What went wrong stays until it was read.
  if (kind === "good") setTimeout(() => line.remove(), GONE_AFTER_MS);
}
