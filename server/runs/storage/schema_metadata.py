"""The database's schema, to which the modules of tables add theirs."""

from sqlalchemy import MetaData

metadata = MetaData()
