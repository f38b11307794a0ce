// Colours are those of the style sheets: a canvas asks for them when it is drawn.

/** Return the colour that a variable of the style sheets has now, as `--left`. */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Call `redraw` when the page turns dark or light; returns what ends it. */
export function whenAppearanceChanges(redraw) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  document.body.addEventListener("appearance", redraw);
  system.addEventListener("change", redraw);
  return () => {
    document.body.removeEventListener("appearance", redraw);
    system.removeEventListener("change", redraw);
  };
}
