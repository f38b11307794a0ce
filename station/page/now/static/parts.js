// Parts of the page that are as before are left alone: what somebody reads, marks or has the focus
// on must not be put anew every second.
export function beginParts() {
  const shown = new Map();
  let desk = deskNow();

  document.body.addEventListener("htmx:oobBeforeSwap", (event) => {
    const { target, fragment } = event.detail;
    const coming = fragment.firstElementChild?.outerHTML;
    if (shown.get(target.id) === coming) event.preventDefault();
    else shown.set(target.id, coming);
  });

  document.body.addEventListener("htmx:oobAfterSwap", () => {
    if (deskNow() === desk) return;
    desk = deskNow();
    document.body.dispatchEvent(new CustomEvent("desk-changed"));
  });

  // Both a button's answer and what is asked every second tell of a change: what somebody has typed
  // since the first is not to be put anew by the second.
  document.body.addEventListener("htmx:beforeSwap", ({ detail }) => {
    if (detail.target.id !== "now-desk") return;
    const coming = new DOMParser().parseFromString(detail.serverResponse, "text/html").getElementById("now-desk");
    if (coming?.dataset.desk === detail.target.dataset.desk) detail.shouldSwap = false;
  });
}

function deskNow() {
  return document.getElementById("now-running").dataset.desk;
}
