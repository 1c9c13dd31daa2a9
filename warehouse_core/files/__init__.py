"""Atomic writing of files, and safe reading of arrays from untrusted files."""

from warehouse_core.files.atomic import atomic_path
from warehouse_core.files.npz import read_arrays, write_arrays

__all__ = ["atomic_path", "read_arrays", "write_arrays"]
