"""The service on the wire: thin servicers that translate, call, translate."""
