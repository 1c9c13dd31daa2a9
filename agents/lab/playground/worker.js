// Runs Python for the page: loads Pyodide and the project's wheel, and answers questions.

import { loadPyodide } from "./pyodide/pyodide.mjs";

const ARCHIVE = "warehouse.whl";

const UNPACK = `
import shutil, site
shutil.unpack_archive("${ARCHIVE}", site.getsitepackages()[0], "zip")
`;

/** Load Python and the project, report the progress, and return the session. */
async function load(wheel) {
  postMessage({ state: "Loading Python …" });
  const pyodide = await loadPyodide();
  await pyodide.loadPackage("numpy", { messageCallback() {} });
  postMessage({ state: "Loading the warehouse …" });
  const response = await fetch(wheel);
  pyodide.FS.writeFile(ARCHIVE, new Uint8Array(await response.arrayBuffer()));
  pyodide.runPython(UNPACK);
  const { Session } = pyodide.pyimport("agents.lab.playground.session");
  return Session();
}

let session;

addEventListener("message", async ({ data }) => {
  try {
    session ??= load(data.wheel);
    const python = await session;
    if (data.question === undefined) postMessage({ isReady: true });
    else postMessage({ answer: JSON.parse(python.answer(JSON.stringify(data.question), (done, all) => postMessage({ done, all }))) });
  } catch (error) {
    postMessage({ failure: String(error) });
  }
});
