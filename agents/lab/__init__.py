"""The laboratory: runs of agents, experiments, reports, grades and the commands of `warehouse`."""
