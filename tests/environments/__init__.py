"""Tests of `server.environments`."""
