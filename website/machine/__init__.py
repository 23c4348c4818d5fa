"""Files of the site for programs: JSON Schemas, an OpenAPI description, a list of pages for language models."""
