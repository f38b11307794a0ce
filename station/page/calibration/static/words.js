// The texts of a script, which its page holds as JSON, with gaps as `{name}`.
export function wordsOf(id) {
  const texts = JSON.parse(document.getElementById(id).textContent);
  return (key, values = {}) => texts[key].replace(/\{(\w+)\}/g, (_, name) => String(values[name]));
}

/** Return a number with its unit, or a dash where there is none. */
export function quantity(value, unit, digits) {
  if (value === null || value === undefined) return "–";
  const text = value.toFixed(digits).replace("-", "−");
  return unit ? `${text}\u202f${unit}` : text;
}
