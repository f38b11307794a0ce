// The texts that the page holds for its scripts.

/** Return the texts of a name, as `player`; `{gaps}` are filled by `fill`. */
export function textsOf(element, name) {
  return JSON.parse(element.querySelector(`script[data-texts="${name}"]`).textContent);
}

/** Fill the gaps of a text. */
export function fill(text, values) {
  return text.replace(/\{(\w+)\}/g, (gap, name) => values[name] ?? gap);
}
