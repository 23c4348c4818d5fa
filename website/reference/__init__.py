"""Reference pages made from the code: Python names, command lines, protocol."""
