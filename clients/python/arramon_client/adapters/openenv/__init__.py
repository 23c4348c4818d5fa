"""The benchmark as an environment of OpenEnv: `environment` and `app` serve it, `client` plays it, over `messages`."""
