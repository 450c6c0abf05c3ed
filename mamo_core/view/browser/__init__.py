"""Recordings in three dimensions, as one HTML file or on a server of this machine, by viser."""
