// The texts of all charts, which `shell/charts.html` puts into the head of a page.
const place = document.getElementById("chart-words");

export const words = place ? JSON.parse(place.textContent) : {};
