"""The collection that a command names. Only commands list the others: pages say nothing of them to strangers."""

from arramon_collecting.storage.records import Collection
from arramon_collecting.storage.store import Store
from arramon_server.errors import NotFound, quoted


def find_collection(store: Store, name: str) -> Collection:
    """Return a collection.

    Raises:
        NotFound: if there is none of that name; the message lists the existing ones.
    """
    there = store.collections.all()
    for one in there:
        if one.name == name:
            return one
    names = ", ".join(one.name for one in there) or "none yet"
    raise NotFound(f"there is no collection {quoted(name)}; there are {names}")
