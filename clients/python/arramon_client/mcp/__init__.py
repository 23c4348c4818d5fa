"""Runs as tools of the Model Context Protocol, for assistants and editors: `arramon-client mcp`."""
