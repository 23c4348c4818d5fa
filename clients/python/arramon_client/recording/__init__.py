"""Recording of a run: frames, actions and maps, as files and as pages for a browser."""
