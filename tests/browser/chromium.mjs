// Headless Chromium, spoken to through a pipe in its DevTools protocol. Nothing but Node.js is needed for it.

import { spawn } from "node:child_process";
import { accessSync, constants, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { delimiter, join } from "node:path";

/** Where Chromium is: $CHROMIUM, or one of its names on the path; undefined if nowhere. */
export function findChromium() {
  if (process.env.CHROMIUM !== undefined) return process.env.CHROMIUM || undefined;
  for (const name of ["chromium", "chromium-browser", "google-chrome"]) {
    for (const folder of (process.env.PATH ?? "").split(delimiter)) {
      try {
        accessSync(join(folder, name), constants.X_OK);
        return join(folder, name);
      } catch {}
    }
  }
  return undefined;
}

/** One browser with one page. */
export class Chromium {
  #next = 1;
  #answers = new Map();
  #listeners = [];
  #rest = "";

  constructor(program) {
    this.profile = mkdtempSync(join(tmpdir(), "uiclink-browser-"));
    const flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
      "--force-device-scale-factor=1", "--remote-debugging-pipe", `--user-data-dir=${this.profile}`, "about:blank"];
    this.process = spawn(program, flags, { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    this.gone = new Promise((resolve) => this.process.once("exit", resolve));
    this.process.once("error", (error) => this.#fail(error));
    this.gone.then((code) => this.#fail(new Error(`Chromium ended with code ${code}`)));
    this.process.stdio[3].on("error", () => {});
    this.process.stdio[4].setEncoding("utf8").on("data", (text) => this.#read(text));
  }

  /** Opens the one page; afterwards `send` speaks to it. */
  async start() {
    const { targetInfos } = await this.send("Target.getTargets");
    const { targetId } = targetInfos.find((target) => target.type === "page");
    const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
    this.session = sessionId;
    for (const domain of ["Page", "Runtime", "Log", "Network"]) await this.send(`${domain}.enable`);
  }

  send(method, params = {}) {
    const id = this.#next++;
    const message = { id, method, params };
    if (this.session !== undefined) message.sessionId = this.session;
    this.process.stdio[3].write(JSON.stringify(message) + "\0");
    return new Promise((resolve, reject) => this.#answers.set(id, { method, resolve, reject }));
  }

  /** Calls `listener(method, params)` at every event. */
  listen(listener) {
    this.#listeners.push(listener);
  }

  /** The value of an expression, a promise's once it is there. */
  async evaluate(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate",
      { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async close() {
    this.session = undefined;
    await Promise.race([this.send("Browser.close").catch(() => {}), this.gone]);
    const killer = setTimeout(() => this.process.kill("SIGKILL"), 3000);
    await this.gone;
    clearTimeout(killer);
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 100 });
  }

  #read(text) {
    const messages = (this.#rest + text).split("\0");
    this.#rest = messages.pop();
    for (const message of messages.map((one) => JSON.parse(one))) {
      if (message.id === undefined) {
        for (const listener of this.#listeners) listener(message.method, message.params);
        continue;
      }
      const { method, resolve, reject } = this.#answers.get(message.id);
      this.#answers.delete(message.id);
      if (message.error) reject(new Error(`${method}: ${message.error.message}`));
      else resolve(message.result);
    }
  }

  #fail(error) {
    for (const { reject } of this.#answers.values()) reject(error);
    this.#answers.clear();
  }
}
