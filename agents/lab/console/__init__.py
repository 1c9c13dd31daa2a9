"""Parts that the commands share: options, output, progress bar, errors to exit codes."""
