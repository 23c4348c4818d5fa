"""Perception of frames: visual encoders (interface in `encoder.py`), obstacles, free ground and landmarks."""
