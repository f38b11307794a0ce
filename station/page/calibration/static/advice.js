// One plain sentence of what to do next.
import { quantity } from "./words.js";

const FIRST = 3;

/** Return the sentences that say what to do next. */
export function adviceOf(guidance, say) {
  if (guidance.enough) return [say("enough")];
  const found = guidance.poses.filter((pose) => !pose.why).length;
  if (guidance.next) return [sentence(guidance.next, say), say("gain", { share: quantity(100 * guidance.next.falls_to, "%", 0) })];
  if (guidance.unsolved) return [say("unsolved", { why: guidance.unsolved }), say("first_more")];
  if (guidance.wanted_cells) return [say("nowhere")];
  return [say(found < FIRST ? `first_${found + 1}` : "first_more")];
}

function sentence(next, say) {
  const where = say(`where_${third(next.down)}${third(next.across)}`);
  const tilt = next.tilt_deg < 5 ? say("facing") : say("tilted", {
    edge: say(`edge_${edgeAt(next.near_edge_deg)}`), angle: quantity(next.tilt_deg, "°", 0).replace("\u202f", ""),
  });
  return say("show", { where, depth: quantity(10 * Math.round(next.depth_mm / 10), "mm", 0), tilt });
}

/** Return 0, 1 or 2: the third of the picture that a part of it lies in. */
function third(part) {
  return Math.min(Math.max(Math.floor(3 * part), 0), 2);
}

/** Return the edge in a direction of the picture: 0 is right, 90 is down. */
export function edgeAt(degrees) {
  return ["right", "bottom", "left", "top"][((Math.round(degrees / 90) % 4) + 4) % 4];
}
