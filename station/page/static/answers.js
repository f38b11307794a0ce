// Hears what answers tell the page, also where the part that called is no longer on it.
//
// htmx tells it to the part. One that was loaded anew meanwhile, as those are that are asked for
// every second, is nowhere, and what was done, or refused, would never be said.
export function beginHearing(refused) {
  document.body.addEventListener("htmx:beforeSend", ({ detail: { elt, xhr } }) => {
    // Heard before htmx does: it may itself take away the part, having told it.
    xhr.addEventListener("readystatechange", () => {
      if (xhr.readyState !== XMLHttpRequest.DONE || elt.isConnected) return;
      if (xhr.status >= 400) refused(xhr);
      else tell(xhr.getResponseHeader("HX-Trigger"));
    });
  });
}

// Either one event's name, or all events by their names with what they tell.
function tell(header) {
  if (header === null) return;
  const events = header.startsWith("{") ? JSON.parse(header) : { [header]: null };
  for (const [name, detail] of Object.entries(events)) {
    document.body.dispatchEvent(new CustomEvent(name, { detail }));
  }
}
