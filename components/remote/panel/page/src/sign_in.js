// The form of a person who has no session.

import { el, field } from "./dom.js";
import { signIn } from "./http.js";

/** Makes the form: a token of the machine's own screen, or a user and a password. */
export function signInForm(t, refusal, run) {
  const note = el("p", { role: "alert", class: "note" }, refusal?.message ?? "");
  const input = (name, type, complete) => el("input", { name, type, autocomplete: complete });
  const form = el(
    "form", { onsubmit: submit },
    field(t("sign.token"), input("token", "text", "off")),
    el("p", {}, t("sign.or")),
    field(t("sign.user"), input("user", "text", "username")),
    field(t("sign.password"), input("password", "password", "current-password")),
    note, el("button", { type: "submit", class: "primary" }, t("sign.in")),
  );
  async function submit(event) {
    event.preventDefault();
    const { token, user, password } = Object.fromEntries(new FormData(form));
    // A person may paste the whole address.
    const bare = token.trim().replace(/^.*#token=/, "");
    try {
      run(await signIn(bare === "" ? { user, password } : { token: bare }));
    } catch (error) {
      note.textContent = error.message;
    }
  }
  return el("main", { class: "sign-in" }, el("h1", {}, "Ferrule"), el("p", {}, t("sign.hint")), form);
}
