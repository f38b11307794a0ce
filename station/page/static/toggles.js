// Dark or light, the station's zone or UTC: as this browser was told last.
const root = document.documentElement;
const ON = { theme: "dark", times: "utc" };
const OFF = { theme: "light", times: "local" };

function isOn(name) {
  const told = root.dataset[name];
  if (told) return told === ON[name];
  return name === "theme" && matchMedia("(prefers-color-scheme: dark)").matches;
}

export function beginToggles() {
  for (const button of document.querySelectorAll("[data-toggle]")) {
    const name = button.dataset.toggle;
    button.setAttribute("aria-pressed", String(isOn(name)));
    button.addEventListener("click", () => {
      const told = isOn(name) ? OFF[name] : ON[name];
      root.dataset[name] = told;
      localStorage.setItem(name, told);
      button.setAttribute("aria-pressed", String(isOn(name)));
      document.body.dispatchEvent(new CustomEvent("appearance"));
    });
  }
}
