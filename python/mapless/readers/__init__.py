"""Readers of the formats that Python has libraries for: one file each. A reader has

formats: tuple[str, ...]                       names for --format
fits(path) -> bool                             whether `path` looks like one of them, by its name or first bytes
open(path, options, format) -> CloudSource     `format`: one of them, or ""; raises InputError

registry.py has all of them. This file loads none: the command needs the names of formats and options alone.
"""

from mapless.readers.options import FIELDS, FORMATS, OPTIONS, Options

__all__ = ["FIELDS", "FORMATS", "OPTIONS", "Options"]
