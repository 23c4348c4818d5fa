"""The ArraMon protocol: services and messages of every version."""
