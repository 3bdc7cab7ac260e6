"""Recordings for other programs: one file in a format that its own library reads back."""

from daq.exporting.exported import Exported
from daq.exporting.formats import FORMATS, encode, form_of

__all__ = ["FORMATS", "Exported", "encode", "form_of"]
