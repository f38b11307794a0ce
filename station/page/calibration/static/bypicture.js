// The RMS of each picture, dots and stripe side by side: one that stands out was taken badly.
import { element, plot, shape } from "./elements.js";
import { quantity } from "./words.js";

const WIDTH = 400;
const HEIGHT = 200;
const FOOT = 20;
const LEFT = 44;

export function drawByPicture(place, pictures, say) {
  const solved = pictures.filter((each) => !each.left_out);
  const values = solved.flatMap((each) => [each.dots_rms_px, each.stripe_rms_px]).filter((value) => value !== null);
  if (!values.length) {
    place.textContent = say("no_points");
    return;
  }
  const highest = 1.1 * Math.max(...values);
  const step = (WIDTH - LEFT) / solved.length;
  const y = (value) => HEIGHT - FOOT - (value / highest) * (HEIGHT - FOOT - 6);
  const bars = solved.flatMap((each, at) => [
    bar(LEFT + at * step, each.dots_rms_px, "bar", `${each.name}: ${say("dots")} ${quantity(each.dots_rms_px, "px", 3)}`),
    bar(LEFT + (at + 0.42) * step, each.stripe_rms_px, "bar second", `${each.name}: ${say("stripe")} ${quantity(each.stripe_rms_px, "px", 3)}`),
  ]);
  function bar(x, value, kind, title) {
    if (value === null) return null;
    return shape("rect", { x, y: y(value), width: 0.4 * step, height: y(0) - y(value), class: kind }, shape("title", {}, title));
  }
  const labels = [0, highest / 2, highest].map((value) => shape(
    "text", { x: LEFT - 5, y: y(value) + 4, "text-anchor": "end" }, value.toFixed(2),
  ));
  const said = `${say("dots")}, ${say("stripe")}: ${say("rms")}, px`;
  place.replaceChildren(
    plot(WIDTH, HEIGHT, said, bars, labels, shape("text", { x: LEFT, y: HEIGHT - 4 }, said)),
    element("p", { class: "hint" }, `■ ${say("dots")}  ■ ${say("stripe")}`),
  );
  const [first, second] = ["--accent", "--right"];
  place.lastChild.replaceChildren(key(first, say("dots")), " ", key(second, say("stripe")));
}

function key(colour, text) {
  const mark = element("span", { "aria-hidden": "true" }, "■ ");
  mark.style.color = `var(${colour})`;
  return element("span", {}, mark, text);
}
