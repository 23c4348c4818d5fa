// Requests to the server. An answer that says what is wrong becomes a Refusal; a broken connection stays a TypeError.
export class Refusal extends Error {
  constructor(status, answer) {
    super(answer.error ?? "");
    Object.assign(this, { status, answer });
  }

  // Whether the same request may succeed later.
  get isTemporary() { return this.status === 429 || this.status >= 500; }
}

export class Server {
  constructor(base, csrf) { Object.assign(this, { base, csrf }); }

  async get(path, query = {}) {
    const response = await fetch(`${this.base}/${path}?${new URLSearchParams(query)}`, { credentials: "same-origin", headers: { Accept: "application/json, image/*" } });
    if (!response.ok) throw new Refusal(response.status, await readJson(response));
    return response;
  }

  async post(path, content, { keepalive = false } = {}) {
    const response = await fetch(`${this.base}/${path}`, {
      method: "POST",
      credentials: "same-origin",
      headers: { "Content-Type": "application/json", "X-CSRF-Token": this.csrf },
      body: JSON.stringify(content),
      keepalive,
    });
    const answer = await readJson(response);
    if (!response.ok) throw new Refusal(response.status, answer);
    return answer;
  }
}

async function readJson(response) {
  try { return await response.json(); } catch { return {}; }
}

export function randomHex() {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((one) => one.toString(16).padStart(2, "0")).join("");
}
