import assert from "node:assert/strict";
import { test } from "node:test";

import { Python } from "../../../../agents/lab/playground/python.js";

/** A worker that does what a test says, and knows what it was asked. */
class Puppet {
  asked = [];
  isEnded = false;
  postMessage(message) {
    this.asked.push(message);
  }
  terminate() {
    this.isEnded = true;
  }
  say(data) {
    this.onmessage({ data });
  }
}

function pair(limit = 1000) {
  const [puppets, told] = [[], []];
  const start = () => puppets[puppets.push(new Puppet()) - 1];
  return { python: new Python(start, "w.whl", limit, (state) => told.push(state)), puppets, told };
}

test("an answer is that of the question, and states are told", async () => {
  const { python, puppets, told } = pair();
  puppets[0].say({ state: "Loading" });
  puppets[0].say({ isReady: true });
  const asked = python.ask({ do: "step" });
  puppets[0].say({ done: 1, all: 2 });
  puppets[0].say({ answer: { steps: 1 } });
  assert.deepEqual(await asked, { steps: 1 });
  assert.deepEqual(told, ["Loading", "", "Episode 1 of 2"]);
  assert.deepEqual(puppets[0].asked, [{ wheel: "w.whl" }, { wheel: "w.whl", question: { do: "step" } }]);
});

test("a worker that does not answer is ended, and another begins", async () => {
  const { python, puppets } = pair(5);
  puppets[0].say({ isReady: true });
  await assert.rejects(python.ask({ do: "run" }), /no answer in 0.005 s/);
  assert.equal(puppets[0].isEnded, true);
  assert.equal(python.isReady, false);
  puppets[1].say({ isReady: true });
  const asked = python.ask({ do: "run" });
  puppets[1].say({ answer: { steps: 2 } });
  assert.deepEqual(await asked, { steps: 2 });
});

test("a failure of Python fails the question that it was asked", async () => {
  const { python, puppets, told } = pair();
  const asked = python.ask({ do: "run" });
  puppets[0].say({ failure: "no memory" });
  await assert.rejects(asked, /no memory/);
  assert.deepEqual(told, ["no memory"]);
});
