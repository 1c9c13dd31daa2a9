"""The command ``warehouse pogema``: planners beside the published results of POGEMA's benchmark."""
