// Runs a file of Python by Pyodide in node: node pyodide.mjs FOLDER FILE LOADED. What is loaded before is the wheel of the
// project, with NumPy, or what another file of Python imports.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, file, loaded] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(`${folder}/pyodide.mjs`));
const pyodide = await loadPyodide({ indexURL: `${folder}/` });
const quiet = { messageCallback() {} };
if (loaded.endsWith(".whl")) {
  await pyodide.loadPackage("numpy", quiet);
  pyodide.FS.writeFile("own.whl", new Uint8Array(readFileSync(loaded)));
  pyodide.runPython('import shutil, site; shutil.unpack_archive("own.whl", site.getsitepackages()[0], "zip")');
} else await pyodide.loadPackagesFromImports(readFileSync(loaded, "utf8"), quiet);
pyodide.runPython(readFileSync(file, "utf8"));
