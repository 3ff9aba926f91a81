"""A ROS domain that is reserved for one exam, among all exams that share a network."""

from __future__ import annotations

import os
import socket

from dcrb_ros.schema.refusal import Refusal

FIRST_DOMAIN, DOMAINS = 110, 120
"""ROS domains for exams; low ones are left to users, and 232 is the highest that is valid on all systems."""
FIRST_PORT = 20_000
"""A domain is reserved by binding the TCP port of this number plus the domain at the loopback address.

Ports belong to a network, as ROS domains do: containers with ``--network host`` share both, and share no folder in which a file could be
locked. The system frees the port when the process ends, however it ends.
"""
LOOPBACK = "127.0.0.1"


class ReservedDomain:
    """A ROS domain, reserved until this object is deleted or the process ends."""

    def __init__(self) -> None:
        """Reserve a domain.

        Raises:
            Refusal: all are reserved.
        """
        first = os.getpid()
        for offset in range(DOMAINS):
            self.number = FIRST_DOMAIN + (first + offset) % DOMAINS
            self._lock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            try:
                self._lock.bind((LOOPBACK, FIRST_PORT + self.number))
                return
            except OSError:
                self._lock.close()
        last = FIRST_DOMAIN + DOMAINS - 1
        raise Refusal(f"the ROS domains {FIRST_DOMAIN} .. {last} are all reserved by exams on this machine: wait until one has ended")
