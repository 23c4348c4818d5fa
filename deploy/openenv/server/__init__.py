"""The environment's web server."""
