"""The project's agents, one folder each. They import only `arramon_client` and `lang`."""
