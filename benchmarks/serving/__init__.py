"""The server: steps per second end to end, and what each part of it costs."""
