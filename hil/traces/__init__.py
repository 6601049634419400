"""Traces: what a robot has sensed, recorded once and replayed on every target.

Inside this room, `values` says what a trace is, `vectors` (CSV), `candump` (frames in files) and
`questions` (frames and readings) turn files into it, `sidecar` ties a file to its origin,
`storage` reads and writes, `replaying` compares, `recording` and `listening` make new ones, `shown`
puts them in words. The recorded traces lie here, too; `shipped` says how they came about.
"""

from hil.traces.replaying import Replay, replay
from hil.traces.storage import read_trace, write_trace
from hil.traces.values import Origin, Sample, Trace

__all__ = ["Origin", "Replay", "Sample", "Trace", "read_trace", "replay", "write_trace"]
