"""Migrations of the database's tables, applied when `database.Database` opens it."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy.engine import Connection


def migrate(connection: Connection, revision: str = "head") -> None:
    """Upgrade a database to a revision, in the transaction of the connection.

    Raises:
        alembic.util.CommandError: if the database has a revision unknown to this version.
    """
    command.upgrade(configuration(connection), revision)


def newest_revision() -> str | None:
    """Return the newest revision, to which `migrate` upgrades."""
    return ScriptDirectory.from_config(configuration()).get_current_head()


def revision_of(connection: Connection) -> str | None:
    """Return the revision of a database; None if it was never migrated."""
    return MigrationContext.configure(connection).get_current_revision()


def configuration(connection: Connection | None = None) -> Config:
    """Return the configuration of Alembic for a connection; None for commands without one."""
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config
