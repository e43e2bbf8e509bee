// The state of the machine as the server last reported it.

/** Parts that change together: `motion`, `task`, `lease`, `link`, `programs` … Listeners run once per picture. */
export class Store {
  constructor() {
    this.parts = {};
    this.listeners = new Set();
    this.reporters = new Set();
    this.isWaiting = false;
  }

  /** Returns a part; one that was never reported is empty. */
  get(part) {
    return this.parts[part] ?? {};
  }

  /** Takes over the changed fields of a part. */
  merge(part, changes) {
    this.replace(part, { ...this.get(part), ...changes });
  }

  /** Replaces a part. */
  replace(part, value) {
    this.parts[part] = value;
    for (const reporter of this.reporters) reporter(part);
    this.notify();
  }

  /** Calls `listener` now and after changes, until the signal. */
  listen(listener, signal) {
    this.listeners.add(listener);
    signal.addEventListener("abort", () => this.listeners.delete(listener));
    listener(this);
  }

  /** Calls `reporter` with the name of a part at each change, however many there are in a picture, until the signal. */
  report(reporter, signal) {
    this.reporters.add(reporter);
    signal.addEventListener("abort", () => this.reporters.delete(reporter));
  }

  notify() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    const run = () => {
      this.isWaiting = false;
      for (const listener of [...this.listeners]) listener(this);
    };
    // A hidden page draws no pictures, but must know its state.
    if (document.hidden) setTimeout(run, 0);
    else requestAnimationFrame(run);
  }
}
