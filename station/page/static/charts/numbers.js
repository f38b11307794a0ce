// Numbers and times as the rest of the page writes them.
const NARROW_SPACE = "\u202f";
const MINUS = "\u2212";
const NONE = "\u2013";

/** Return a value with its unit; a dash where there is none. */
export function quantity(value, unit = "", digits = 2) {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  const rounded = value.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", MINUS);
  return unit ? `${rounded}${NARROW_SPACE}${unit}` : rounded;
}

/** Return the zone that times are shown in: UTC, the station's, or else the browser's own. */
export function zone() {
  const root = document.documentElement.dataset;
  return root.times === "utc" ? "UTC" : root.zone || Intl.DateTimeFormat().resolvedOptions().timeZone;
}

/** Return a moment, seconds since 1970, in the zone that is shown. */
export function moment(seconds) {
  if (seconds === null || seconds === undefined) return NONE;
  return new Intl.DateTimeFormat("sv-SE", {
    timeZone: zone(), dateStyle: "short", timeStyle: "medium",
  }).format(new Date(seconds * 1000));
}
