// What stands below a picture: from when it is, and how bright and sharp.
const RECORDS = new Set(["recording", "recorded"]);

export function caption(figure, words, seen) {
  const put = putter(figure);
  figure.querySelector('[data-part="moment"]').replaceChildren(words.time(seen.time));
  put("frame", seen.frame === null ? "" : words.say("frame", { frame: seen.frame }));
  put("figures", words.say("figures", {
    stripe: words.stripe(seen),
    max: seen.brightness.max_counts,
    clipped: words.percent(seen.brightness.clipped_share),
  }));
}

// Told anew while the picture stays: a recording begins, and days go by.
export function captionKind(figure, words, seen, doing) {
  putter(figure)("kind", kindOf(words, seen, doing));
}

// The figures to turn the lens ring by; returns the narrowest stripe so far, px.
export function aim(figure, words, seen, bestWidth) {
  const put = putter(figure);
  const { brightness, focus } = seen;
  const best = narrower(focus?.width_px ?? null, bestWidth);
  const none = words.say("none_value");
  put("width", focus ? words.say("width", { width: focus.width_px.toFixed(2) }) : none);
  put("width-best", best === null ? "" : words.say("width_best", { width: best.toFixed(2) }));
  put("peak", focus ? words.say("peak", { peak: focus.peak_counts.toFixed(0) }) : none);
  put("brightest", words.say("brightest", { max: brightness.max_counts, p999: brightness.p999_counts }));
  put("clipped", words.say("clipped", {
    clipped: words.percent(brightness.clipped_share),
    stripe: focus ? words.percent(focus.clipped_share) : none,
  }));
  return best;
}

function kindOf(words, seen, doing) {
  if (seen.recording === null) return words.say("look");
  if (doing === "blind") return words.say("blind");
  if (RECORDS.has(doing)) return words.say("live");
  return words.say("last", { age: words.lasting((Date.now() - Date.parse(seen.time)) / 1000) });
}

function narrower(width, best) {
  if (width === null) return best;
  return best === null ? width : Math.min(width, best);
}

function putter(figure) {
  return (name, text) => { figure.querySelector(`[data-part="${name}"]`).textContent = text; };
}
