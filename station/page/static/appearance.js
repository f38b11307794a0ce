// Runs before the page is drawn, so that it does not flash: what this browser was told to show.
for (const name of ["theme", "times"]) {
  const told = localStorage.getItem(name);
  if (told) document.documentElement.dataset[name] = told;
}
