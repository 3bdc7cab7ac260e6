"""Boards that people have: whatever gives numbers one after another can be captured like a board of the protocol."""

from daq.sources.source import Reading, Source, SourceDescription
from daq.sources.source_board import SourceBoard

__all__ = ["Reading", "Source", "SourceBoard", "SourceDescription"]
