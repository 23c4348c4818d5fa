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
    config = _config()
    config.attributes["connection"] = connection
    command.upgrade(config, revision)


def newest_revision() -> str | None:
    """What `migrate` brings a database to."""
    return ScriptDirectory.from_config(_config()).get_current_head()


def revision_of(connection: Connection) -> str | None:
    """What a database is at; None where it was never migrated."""
    return MigrationContext.configure(connection).get_current_revision()


def _config() -> Config:
    config = Config()
    config.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    return config
