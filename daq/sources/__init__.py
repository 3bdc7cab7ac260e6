"""Boards that people have: whatever gives numbers one after another can be captured like a board of the protocol."""

from daq.sources.source import Reading as Reading, Source as Source, SourceDescription as SourceDescription
from daq.sources.source_board import SourceBoard as SourceBoard
