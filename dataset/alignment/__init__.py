"""Statistical check of instructions, independent of the grammar: how well a text's words fit a route."""
