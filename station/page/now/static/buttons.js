// The buttons below a picture: stripe on and off, the whole screen, a look.
const STRIPE = "now-stripe";

export function beginButtons(figure, view) {
  beginStripe(figure);
  beginEnlarge(figure);
  const look = figure.querySelector('[data-press="look"]');
  if (look === null) return;
  look.addEventListener("click", () => view.look(!view.looking));
  figure.addEventListener("looking", (event) => press(look, event.detail.on));
  allow(look, view);
  document.body.addEventListener("htmx:oobAfterSwap", () => allow(look, view));
}

// One button for each picture, and all do the same: which is pressed in full screen is seen later.
function beginStripe(figure) {
  const button = figure.querySelector('[data-press="stripe"]');
  const show = () => {
    const on = localStorage.getItem(STRIPE) !== "off";
    press(button, on);
    figure.classList.toggle("without-stripe", !on);
  };
  button.addEventListener("click", () => {
    localStorage.setItem(STRIPE, localStorage.getItem(STRIPE) === "off" ? "on" : "off");
    document.body.dispatchEvent(new CustomEvent("stripes"));
  });
  document.body.addEventListener("stripes", show);
  show();
}

function beginEnlarge(figure) {
  const button = figure.querySelector('[data-press="enlarge"]');
  if (!document.fullscreenEnabled) {
    button.hidden = true;
    return;
  }
  button.addEventListener("click", () => {
    if (document.fullscreenElement === figure) document.exitFullscreen();
    else figure.requestFullscreen();
  });
  document.addEventListener("fullscreenchange", () => {
    const large = document.fullscreenElement === figure;
    press(button, large);
    button.textContent = large ? button.dataset.shrink : button.dataset.enlarge;
  });
}

function allow(look, view) {
  look.disabled = !view.lookable;
  look.title = view.lookable ? look.dataset.allowed : look.dataset.refused;
}

function press(button, on) {
  button.setAttribute("aria-pressed", String(on));
}
