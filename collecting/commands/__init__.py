"""The command line of collections."""
