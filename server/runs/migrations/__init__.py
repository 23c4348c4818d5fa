"""The journal's migrations, applied by `database.Database` when it opens."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy.engine import Connection


def migrate(connection: Connection, revision: str = "head") -> None:
    """Brings a database up to a revision, in the connection's transaction.

    Raises:
        alembic.util.CommandError: if the database is at a revision that is not known here.
    """
    command.upgrade(configuration(connection), revision)


def newest_revision() -> str | None:
    """What `migrate` brings a database to."""
    return ScriptDirectory.from_config(configuration()).get_current_head()


def revision_of(connection: Connection) -> str | None:
    """What a database is at; None where it was never migrated."""
    return MigrationContext.configure(connection).get_current_revision()


def configuration(connection: Connection | None = None) -> Config:
    """For Alembic's commands, through the connection."""
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    config.attributes["connection"] = connection
    return config
