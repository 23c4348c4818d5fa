"""Playback of recorded episodes: every step with what the rules answered, and the agent's view, from the journal."""
