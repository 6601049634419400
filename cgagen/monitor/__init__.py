"""Listening to a Stamp: a DEBUG terminal that knows what our firmware says.

`echo` takes out what the wiring sends back, `decode` turns the firmware's lines into words, and
`listen` carries bytes between a port and whoever wants them.
"""

from cgagen.monitor.decode import Decoder
from cgagen.monitor.echo import EchoFilter
from cgagen.monitor.listen import Listener, listen

__all__ = ["Decoder", "EchoFilter", "Listener", "listen"]
