"""Web page on which students write, run and grade agents in a browser.

Python runs as Pyodide in a worker of the page. The page sends no data anywhere.
"""
