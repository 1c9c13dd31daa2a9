"""A page that runs this project in a browser: an agent is written, run and graded there.

Python is Pyodide, in a worker of the page. Nothing is sent anywhere.
"""
