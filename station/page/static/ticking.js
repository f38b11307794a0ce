// A page that is looked at has its parts loaded anew: `hx-trigger="second from:body"`.
export function beginTicking() {
  let count = 0;
  setInterval(() => {
    if (document.visibilityState !== "visible") return;
    count += 1;
    document.body.dispatchEvent(new CustomEvent("second"));
    if (count % 5 === 0) document.body.dispatchEvent(new CustomEvent("five-seconds"));
  }, 1000);
}
