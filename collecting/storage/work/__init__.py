"""Tables of tasks and drafts, and what is submitted."""
