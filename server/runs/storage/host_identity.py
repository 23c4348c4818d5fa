"""Identity of a host. Processes with equal identities can reach each other's loopback addresses and Unix sockets."""

import platform
import uuid
from functools import cache
from pathlib import Path


@cache
def host_identity() -> str:
    """Return the identity of this host: on Linux the kernel's boot id and the namespaces of network and mounts.

    Containers on one machine share the boot id, and cloned machines share the name; neither share all of these.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        namespaces = [str(Path("/proc/self/ns", name).readlink()) for name in ("net", "mnt")]
    except OSError:
        return f"{platform.node()[:100]} {uuid.getnode():x}"
    return " ".join((boot, *namespaces))
