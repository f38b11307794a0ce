// What a chart shows, in figures: for those who do not see it, and for copying.
import { words } from "./words.js";

/**
 * Return a closed `<details>` with a table; it is filled when it is opened.
 *
 * `rows()` gives the texts of each row, of as many columns as `heads`.
 */
export function tableOf(caption, heads, rows) {
  const details = document.createElement("details");
  details.className = "chart-table";
  const summary = document.createElement("summary");
  summary.textContent = words.as_table;
  details.append(summary);
  details.addEventListener("toggle", () => {
    details.querySelector(".wide")?.remove();
    if (details.open) details.append(filled(caption, heads, rows()));
  });
  return details;
}

function filled(caption, heads, rows) {
  const table = document.createElement("table");
  const named = table.createCaption();
  named.textContent = caption;
  addRow(table.createTHead(), heads, "th");
  const body = table.createTBody();
  for (const row of rows) addRow(body, row, "td");
  const box = document.createElement("div");
  box.className = "wide";
  // A region that scrolls is to be reached by the keyboard.
  box.tabIndex = 0;
  box.setAttribute("role", "region");
  box.setAttribute("aria-label", caption);
  box.append(table);
  return box;
}

function addRow(part, texts, kind) {
  const row = part.insertRow();
  texts.forEach((text, place) => {
    const first = kind === "td" && place === 0;
    const cell = document.createElement(first ? "th" : kind);
    if (cell.tagName === "TH") cell.scope = first ? "row" : "col";
    if (place > 0) cell.className = "num";
    cell.textContent = text;
    row.append(cell);
  });
}
