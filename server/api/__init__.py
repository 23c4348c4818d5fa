"""The gRPC API: the two services, their messages, and the interceptors around them."""
