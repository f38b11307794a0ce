// Elements of SVG.
const NAMESPACE = "http://www.w3.org/2000/svg";

/** Return an element with attributes, and texts or elements inside. */
export function svg(name, attributes = {}, ...inside) {
  const element = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...inside);
  return element;
}

export function line([x1, y1], [x2, y2], kind) {
  return svg("line", { class: kind, x1, y1, x2, y2 });
}

export function text([x, y], words, kind, anchor = "start") {
  return svg("text", { class: kind, x, y, "text-anchor": anchor }, words);
}
