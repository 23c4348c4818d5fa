"""The project's agents, one folder each. They depend only on `arramon_client` and `arramon_lang`."""
