"""Tests of the client, against a small scripted server."""
