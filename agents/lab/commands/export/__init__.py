"""The command ``warehouse export``: results and episodes as files for other programs."""
