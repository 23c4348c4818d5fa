"""Films of recorded episodes: animated pictures, videos, and pages that stand alone."""
