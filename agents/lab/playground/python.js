// Connection to Python in a worker, which is stopped if it takes too long: an agent may never return.

export class Python {
  /**
   * @param {() => Worker} start function that creates the worker.
   * @param {string} wheel address of the project's wheel.
   * @param {number} limit milliseconds without a message after which the worker is stopped.
   * @param {(state: string) => void} report function that is called with the state of Python.
   */
  constructor(start, wheel, limit, report) {
    Object.assign(this, { start, wheel, limit, report, asked: null, isReady: false });
    this.begin();
  }

  /** Start a new worker. */
  begin() {
    this.isReady = false;
    this.worker = this.start();
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.end(new Error(event.message || "Python cannot be loaded"));
    this.worker.postMessage({ wheel: this.wheel });
  }

  /** Return the answer to a question; throw if it takes too long or is stopped. */
  ask(question) {
    return new Promise((resolve, reject) => {
      this.asked = { resolve, reject };
      this.wait();
      this.worker.postMessage({ wheel: this.wheel, question });
    });
  }

  /** Give up the current question, and start a new worker. */
  stop(reason = "stopped") {
    this.worker.terminate();
    this.end(new Error(reason));
    this.begin();
  }

  wait() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.stop(`no answer in ${this.limit / 1000} s; is there an endless loop?`), this.limit);
  }

  hear({ state, isReady, done, all, answer, failure }) {
    if (state) this.report(state);
    if (isReady) {
      this.isReady = true;
      this.report("");
    }
    if (done !== undefined) {
      this.wait();
      this.report(`Episode ${done} of ${all}`);
    }
    if (answer) this.end(null, answer);
    if (failure) this.end(new Error(failure));
  }

  end(error, answer) {
    clearTimeout(this.timer);
    const asked = this.asked;
    this.asked = null;
    if (asked) error ? asked.reject(error) : asked.resolve(answer);
    if (error) this.report(error.message);
  }
}
