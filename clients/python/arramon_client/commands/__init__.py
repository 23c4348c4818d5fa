"""The subcommands of `arramon-client`."""
