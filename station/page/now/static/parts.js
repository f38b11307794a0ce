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
}

function deskNow() {
  return document.getElementById("now-running").dataset.desk;
}
