// Stands after Pyodide in the file that the kernel of live pages runs: the kernel gets Python without the packages that
// it asks for and pages do not need, and with settings.
{
  const load = self.loadPyodide;

  // IPython runs this file when it starts. Jedi is not there, so IPython completes names by their values. Matplotlib
  // would say in red, as if something failed, that it looks for fonts.
  const SETTINGS = `
import logging

logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
get_config().InteractiveShellApp.exec_lines = ["get_ipython().Completer.use_jedi = False"]
`;

  self.loadPyodide = async ({ packages, unneeded, ...options }) => {
    const needed = packages.filter((name) => !unneeded.includes(name));
    const pyodide = await load({ ...options, packages: needed });
    pyodide.FS.mkdirTree("/etc/ipython");
    pyodide.FS.writeFile("/etc/ipython/ipython_config.py", SETTINGS);
    return pyodide;
  };
}
