"""Alembic environment that runs the migrations on the connection given by `migrate`."""

from alembic import context

from arramon_server.runs.storage.tables import metadata

context.configure(connection=context.config.attributes["connection"], target_metadata=metadata)
with context.begin_transaction():
    context.run_migrations()
