// Runs a file of Python with Pyodide in node: node pyodide.mjs FOLDER FILE WHEEL. It loads NumPy and then the wheel,
// which is the project's.

import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, file, wheel] = process.argv.slice(2);
const { loadPyodide } = await import(pathToFileURL(`${folder}/pyodide.mjs`));
const pyodide = await loadPyodide({ indexURL: `${folder}/` });
await pyodide.loadPackage("numpy", { messageCallback() {} });
pyodide.FS.writeFile("own.whl", new Uint8Array(readFileSync(wheel)));
pyodide.runPython('import shutil, site; shutil.unpack_archive("own.whl", site.getsitepackages()[0], "zip")');
pyodide.runPython(readFileSync(file, "utf8"));
