"""The commands of ``warehouse``, a file each."""
