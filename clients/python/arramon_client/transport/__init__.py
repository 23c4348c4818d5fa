"""Connection to a server: channel, credentials, streams, retries and image decoding."""
