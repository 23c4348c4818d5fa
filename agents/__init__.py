"""Agent plugins, one folder each. They know only `arramon_client` and `lang`."""
