"""Reports on the results of experiments: a page with answers, figures and examples."""
