"""The learned reader: a small network that reads instructions in every language that it was trained on as steps."""
