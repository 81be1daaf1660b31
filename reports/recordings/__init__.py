"""Recordings: every engine of a case beside the truth in one rerun file, synchronised in time.

This folder is the only place that calls rerun's logging interface.
"""

from plumbline.reports.recordings.layout import recording_of
from plumbline.reports.recordings.write import moment_recording, write_recordings

__all__ = ["moment_recording", "recording_of", "write_recordings"]
