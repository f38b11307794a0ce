// Frames of a recording by their numbers: the picture, and the stripe found on that very picture.
const RETRY_MS = 1000;
const ATTEMPTS = 5;
const KEPT = 24;

/** The station's answer in words, for the person. */
export class Refused extends Error {}

export class Frames {
  #place;
  #kept = new Map();

  constructor(place) {
    this.#place = place;
  }

  /** Return `{bitmap, found}` of a frame; `found` is the document of its stripe. Throws Refused. */
  async load(number, width) {
    const key = `${number} ${width}`;
    const kept = this.#kept.get(key) ?? this.#ask(number, width);
    this.#kept.delete(key);
    this.#kept.set(key, kept);
    if (this.#kept.size > KEPT) this.#forget(this.#kept.keys().next().value);
    try {
      return await kept;
    } catch (error) {
      this.#kept.delete(key);
      throw error;
    }
  }

  async #ask(number, width) {
    const place = `${this.#place}/${number}`;
    const [picture, stripe] = await Promise.all([
      answered(`${place}/picture?format=jpeg&max_width=${width}`),
      answered(`${place}/stripe`),
    ]);
    return { bitmap: await createImageBitmap(await picture.blob()), found: await stripe.json() };
  }

  #forget(key) {
    const kept = this.#kept.get(key);
    this.#kept.delete(key);
    kept.then(({ bitmap }) => bitmap.close(), () => {});
  }
}

/** Fetch; where the station is busy, ask again. */
export async function answered(address) {
  for (let attempt = 1; ; attempt += 1) {
    const answer = await fetch(address);
    if (answer.ok) return answer;
    if (answer.status !== 503 || attempt === ATTEMPTS) throw new Refused(await reason(answer));
    await new Promise((resolve) => { setTimeout(resolve, RETRY_MS); });
  }
}

async function reason(answer) {
  try {
    return (await answer.json()).detail;
  } catch {
    return String(answer.status);
  }
}
