// A new key is on the page until it was copied: nothing else holds it.
import { say } from "../saying.js";

const place = document.getElementById("new-key");

place.addEventListener("htmx:afterSwap", () => {
  document.getElementById("new-key-title").focus();
});

place.addEventListener("click", (event) => {
  const { copy, clear } = event.target.dataset;
  if (copy) copyText(document.getElementById(copy));
  if (clear) document.getElementById(clear).replaceChildren();
});

// Browsers copy for encrypted pages alone; on others the text is selected for the keyboard.
async function copyText(field) {
  field.select();
  try {
    await navigator.clipboard.writeText(field.value);
    say(place.dataset.copied, "good");
  } catch {
    field.focus();
    say(place.dataset.select, "good");
  }
}
