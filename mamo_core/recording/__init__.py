"""Executions of a plan, recorded once and shown in many ways."""

from mamo_core.recording.file import read_recording, write_recording
from mamo_core.recording.record import record, recording_of

__all__ = ["read_recording", "record", "recording_of", "write_recording"]
