// What a person moves through the frames with: buttons, slider, number, keys.
const STEPS = {
  first: () => 1,
  previous: (number) => number - 1,
  next: (number) => number + 1,
  last: () => Infinity,
};
const KEYS = {
  ArrowLeft: (number) => number - 1,
  ArrowRight: (number) => number + 1,
  PageUp: (number) => number - 10,
  PageDown: (number) => number + 10,
  Home: () => 1,
  End: () => Infinity,
};

/** `go(number)` shows a frame, `numberNow()` tells the one that is wanted; returns `show(number)`. */
export function addControls(element, { go, numberNow, playing }) {
  const slider = element.querySelector(".slider");
  const number = element.querySelector("input[data-number]");
  for (const button of element.querySelectorAll("button[data-go]")) {
    button.addEventListener("click", () => go(STEPS[button.dataset.go](numberNow())));
  }
  for (const button of element.querySelectorAll(".filmstrip button")) {
    button.addEventListener("click", () => go(Number(button.dataset.number)));
  }
  slider.addEventListener("input", () => go(slider.valueAsNumber));
  number.addEventListener("change", () => go(number.valueAsNumber || 1));
  element.querySelector(".stage").addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === " ") playing.toggle();
    else if (event.key in KEYS) go(KEYS[event.key](numberNow()));
    else return;
    event.preventDefault();
  });
  addPlaying(element, playing);
  return (shown) => {
    slider.value = shown;
    if (number !== document.activeElement) number.value = shown;
    markThumbnail(element, shown);
  };
}

function addPlaying(element, playing) {
  const button = element.querySelector("[data-play]");
  const words = { true: button.dataset.pause, false: button.textContent };
  button.addEventListener("click", () => playing.toggle());
  element.querySelector("[data-rate]").addEventListener("change", (event) => {
    playing.rate = Number(event.target.value);
  });
  playing.whenChanged = (on) => {
    button.textContent = words[on];
    button.setAttribute("aria-pressed", String(on));
  };
}

function markThumbnail(element, shown) {
  let here = null;
  for (const button of element.querySelectorAll(".filmstrip button")) {
    button.removeAttribute("aria-current");
    if (Number(button.dataset.number) <= shown) here = button;
  }
  here?.setAttribute("aria-current", "true");
}
