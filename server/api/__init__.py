"""The gRPC API: thin servicers and their interceptors."""
