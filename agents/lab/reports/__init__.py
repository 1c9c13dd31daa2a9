"""Reports on the results of experiments: answers, figures, examples, one page."""
