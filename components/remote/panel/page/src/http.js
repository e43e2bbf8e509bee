// Requests to the server.

const BASE = "/api/v1";
const KEY = "ferrule-key";
/** What the browser keeps of a sign-in by token that has no answer yet. */
const LOGIN = "ferrule-login";
/** Time after which a request that the network has lost is sent again. */
export const RETRY_MS = 1000;

/** A refusal of the server, or of the network. */
export class Refusal extends Error {
  constructor({ code, text, hint }) {
    super(hint ? `${text} (${hint})` : text);
    this.code = code;
  }
}

/** Returns the key of this tab's session. */
export const sessionKey = () => sessionStorage.getItem(KEY);

/** Returns the refusal for a request or an answer that was lost; the end that the page itself gave it stays as it is. */
const lost = (error) => (error.name === "AbortError" ? error : new Refusal({ code: "no-server", text: error.message }));

/** Returns the JSON of a response. */
async function answerOf(response) {
  try {
    return await response.json();
  } catch (error) {
    throw lost(error);
  }
}

/** Sends a request; returns the response or throws a refusal. A question that the network has lost is asked once more. */
export async function request(method, path, { body, json, signal } = {}) {
  const headers = {};
  if (sessionKey()) headers["X-Ferrule-Key"] = sessionKey();
  if (json !== undefined) headers["Content-Type"] = "application/json";
  const send = () => fetch(BASE + path, {
    method, headers, signal, body: json === undefined ? body : JSON.stringify(json), cache: "no-store",
  });
  let response;
  try {
    response = await send().catch((error) => {
      if (method !== "GET" || error.name === "AbortError") throw error;
      return send();
    });
  } catch (error) {
    throw lost(error);
  }
  if (response.ok) return response;
  let found = null;
  try {
    found = (await response.json()).error;
  } catch {
    // Proxies answer with pages of their own.
  }
  throw new Refusal(found ?? { code: String(response.status), text: response.statusText });
}

/** Waits. */
export const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

/** Does something until the server answers; `say` gets the reason while it does not. */
export async function persistent(work, say) {
  for (;;) {
    try {
      return await work();
    } catch (error) {
      if (error.code !== "no-server") throw error;
      say(error);
      await pause(RETRY_MS);
    }
  }
}

/** Asks for something that is JSON. */
export const getJson = async (path, options) => answerOf(await request("GET", path, options));

/** Returns a path with patterns that select names. */
export function listPath(kind, patterns = []) {
  const query = patterns.map((p) => `pattern=${encodeURIComponent(p)}`).join("&");
  return `/${kind}${query ? `?${query}` : ""}`;
}

/** Begin of the names of programs that were sent. */
export const UPLOADS = "uploads/";

/** Returns the path of a program. */
export const programPath = (name, tail = "") => `/programs/${encodeURIComponent(name)}${tail}`;

/** Stores a program, and resolves to its name: whatever its text comes from, it is an upload. */
export async function storeProgram(name, body) {
  const plain = name.startsWith(UPLOADS) ? name.slice(UPLOADS.length) : name;
  return (await answerOf(await request("PUT", programPath(UPLOADS + plain), { body }))).name;
}

/** Returns the name of a program whose path the task has. */
export function programName(path) {
  const [folder, file] = (path ?? "").split("/").slice(-2);
  return `${folder}/` === UPLOADS && file ? UPLOADS + file : file ?? folder;
}

/** Opens a session with the token of the address, or with a user and a password. */
export async function signIn(how) {
  try {
    const answer = await answerOf(await request("POST", "/session", { json: how }));
    sessionStorage.setItem(KEY, answer.key);
    sessionStorage.removeItem(LOGIN);
    return answer;
  } catch (error) {
    if (error.code !== "no-server") sessionStorage.removeItem(LOGIN);
    throw error;
  }
}

/** Returns the session of this tab, or null. */
export async function currentSession() {
  if (!sessionKey()) return null;
  try {
    return await getJson("/session");
  } catch (error) {
    if (error.code === "no-session") return null;
    throw error;
  }
}

/** Ends the session. */
export async function signOut() {
  await request("DELETE", "/session");
  sessionStorage.removeItem(KEY);
}

/**
 * Takes the one-time token out of the page's address, and returns the sign-in with it; without one, a sign-in that has no answer
 * yet, or null. Sent again, also by the page that is loaded again meanwhile, it is the same attempt: an answer that was lost is no
 * use of the token.
 */
export function login() {
  const found = /^#token=(.+)$/.exec(location.hash);
  if (!found) return JSON.parse(sessionStorage.getItem(LOGIN));
  const made = { token: found[1], attempt: [...crypto.getRandomValues(new Uint8Array(16))].join("-") };
  sessionStorage.setItem(LOGIN, JSON.stringify(made));
  history.replaceState(null, "", location.pathname + location.search);
  return made;
}
