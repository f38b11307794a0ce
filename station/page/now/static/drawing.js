// A picture and the stripe found on it, put on the screen in one stroke: they belong together.
const NS = "http://www.w3.org/2000/svg";

export async function draw(screen, seen, alt) {
  const image = await imageOf(seen.picture);
  image.alt = alt;
  const before = screen.querySelector("img");
  if (before) before.replaceWith(image);
  else screen.prepend(image);
  screen.style.setProperty("--ratio", String(seen.width_px / seen.height_px));
  drawStripe(screen.querySelector("svg"), seen);
}

// As many strokes of no length, round at their ends, as there are points: a dot each.
function drawStripe(overlay, { width_px: width, height_px: height, stripe }) {
  // (0, 0) is the centre of the first pixel, so the picture begins half a pixel before it.
  overlay.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
  const dots = stripe.u_px.map((u, place) => `M${u} ${stripe.v_px[place]}h0`);
  const path = overlay.querySelector("path") ?? overlay.appendChild(document.createElementNS(NS, "path"));
  path.setAttribute("d", dots.join(""));
}

async function imageOf({ media_type: type, base64, width_px: width, height_px: height }) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  const image = new Image(width, height);
  image.src = address;
  try {
    await image.decode();
  } finally {
    URL.revokeObjectURL(address);
  }
  return image;
}
