"""The pytest plugin of cgagen: firmware on trial, in this project and in anybody's.

It comes with the package, so it is loaded in every run of pytest on a machine that has cgagen.
Therefore it imports nothing of cgagen before a test asks for one of its fixtures, and all its
words begin with `hil`.

Fixtures: `hil_config` (what was asked for), `hil_subject` (robot, genome, images), `hil_image`,
`hil_target` (open, identity checked), `hil_registers` (the emulator from a snapshot behind
sensing), `hil_oracle` (the simulator), `hil_stimuli` (readings of the level), `hil_check`
(applies readings or a trace, fails with a report), `hil_judge` (the same for a trial of one's
own), `hil_evidence` (for the report), `hil_trace` and `hil_vectors` (files), `hil_vcd`
(draws a bench), `hil_artifacts` (a folder).
Markers: `hil_needs(CAPABILITY, ...)`, `hil_hardware`, `hil_req(ID, ...)`, `hil_trace(FILE, ...)`,
`hil_vectors(FILE, ...)`, `hil_slow`.

The order for every option: command line, ini file, environment. Under pytest-xdist the workers
share the tests of the emulator; what hangs on a wire has a lock, and `--dist loadgroup` keeps
its tests in one worker.
"""

import traceback
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from cgagen.pytest_plugin.artifacts import FILES, TestFiles
from cgagen.pytest_plugin.fixtures import (
    blocked,
    fixtures_of,
    hil_artifacts,
    hil_check,
    hil_config,
    hil_evidence,
    hil_image,
    hil_judge,
    hil_oracle,
    hil_registers,
    hil_stimuli,
    hil_trace,
    hil_vcd,
    hil_vectors,
    is_a_sentence,
    missing,
    reset,
)
from cgagen.pytest_plugin.options import (
    FIRMWARE,
    MARKERS,
    HilConfig,
    add_options,
    given,
    on_command_line,
    on_wires,
    targets_of,
)
from cgagen.pytest_plugin.ours import of_reference, refuse_contradictions, subjects_of
from cgagen.pytest_plugin.session import (
    BLOCKED,
    LEVEL,
    REQUIREMENT,
    SESSION,
    VERDICT,
    WORKER,
    Ears,
    HilSession,
)
from cgagen.pytest_plugin.told import NOT_TRIED
from cgagen.shown import printable

if TYPE_CHECKING:
    from hil.target import Target

__all__ = [
    "HilConfig",
    "hil_artifacts",
    "hil_check",
    "hil_config",
    "hil_evidence",
    "hil_image",
    "hil_judge",
    "hil_oracle",
    "hil_registers",
    "hil_stimuli",
    "hil_trace",
    "hil_vcd",
    "hil_vectors",
]

FIXTURES = frozenset({*__all__, "hil_subject", "hil_target"} - {"HilConfig"})
"""Tests that ask for one of these are tests of firmware."""

ALONE = ("no", "loadgroup")
"""Ways of pytest-xdist to give tests to workers that leave those of a wire in one."""

REPORTING = ("coverage", "report", "kills", "requirements")
"""Options that are looked at before the tests."""

_LINES = pytest.StashKey[list[str]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options, all of them prefixed."""
    add_options(parser)


def pytest_configure(config: pytest.Config) -> None:
    """Make the markers known, and the fixtures that depend on options."""
    for marker in MARKERS:
        config.addinivalue_line("markers", marker)
    config.stash[SESSION] = HilSession(config)
    config.pluginmanager.register(Ears(config.stash[SESSION]), "cgagen-hil-ears")
    config.stash[_LINES] = []
    if on_command_line(config):
        config.stash[SESSION].asked  # noqa: B018  a wrong word is refused before the tests
    named = any(given(config, name) for name in FIRMWARE)
    fixtures = fixtures_of(subjects_of(named), targets_of(config))
    config.pluginmanager.register(fixtures, "cgagen-hil")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Look at what a report needs, and begin to count executed lines, where that is wanted.

    Raises:
        pytest.UsageError: several workers would fight for one wire; or options say two things.
    """
    config = session.config
    named = config.getoption("--hil-target", None) or config.getini("hil_target")
    if named and on_wires(config) and config.getoption("dist", "no") not in ALONE:
        raise pytest.UsageError(
            "a target on a wire has room for one worker of pytest-xdist; add --dist loadgroup, or "
            "leave -n out"
        )
    if any(given(config, name) for name in REPORTING):
        config.stash[SESSION].start()
    refuse_contradictions(config)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Run a test once for each trace, or each table of vectors, that was named."""
    named = tuple(map(Path, given(metafunc.config, "trace")))
    tables = tuple(path for path in named if path.suffix.lower() == ".csv")
    for name, files in (("hil_trace", named), ("hil_vectors", tables)):
        if _is_ours(metafunc, name):
            marks = metafunc.definition.iter_markers(name)
            beside = metafunc.definition.path.parent
            own = [beside / str(word) for mark in marks for word in mark.args]
            paths = files or tuple(own) or (None,)
            ids = [path.name if path else "none" for path in paths]
            metafunc.parametrize(name, paths, indirect=True, ids=ids)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave long tests out that nobody asked for; keep those of a wire in one worker of xdist."""
    if "slow" not in (config.getoption("markexpr", "") or ""):
        named = {word.rpartition("::")[2].partition("[")[0] for word in config.args if "::" in word}
        long = [
            item
            for item in items
            if item.get_closest_marker("hil_slow")
            and getattr(item, "originalname", item.name) not in named
        ]
        if long:
            config.hook.pytest_deselected(items=long)
            items[:] = [item for item in items if item not in long]
    others = sum(of_reference(config, item.path) and not _of_firmware(item) for item in items)
    if others:
        config.stash[_LINES].append(f"{others} tests are of the reference firmware alone")
    if config.pluginmanager.hasplugin("xdist") and on_wires(config):
        for item in items:
            if "hil_target" in getattr(item, "fixturenames", ()):
                item.add_marker(pytest.mark.xdist_group("cgagen-hil-wire"))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Leave hardware alone that was not named; prepare for what a test leaves behind."""
    if not _of_firmware(item):
        return
    for mark in item.iter_markers("hil_req"):
        item.user_properties += [(REQUIREMENT, str(one)) for one in mark.args]
    wanted = item.config.stash[SESSION].asked
    item.user_properties.append((LEVEL, wanted.level))
    item.stash[FILES] = TestFiles(item, wanted)
    if next(item.iter_markers("hil_hardware"), None) and not on_wires(item.config):
        missing(item, "needs a target on a wire; name one with --hil-target serial:PORT")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Skip what a target cannot do, or refuse; write down what the test does."""
    _check_needs(item)
    files, funcargs = item.stash.get(FILES, None), getattr(item, "funcargs", {})
    if files is None:
        return (yield)
    files.begin(funcargs)
    failure = ""
    try:
        return (yield)
    except pytest.skip.Exception:
        raise
    except BaseException as error:
        failure = "".join(traceback.format_exception_only(error))
        raise
    finally:
        files.finish(failure)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> object | None:
    """Repeat a test that a sick bench has blocked, as often as asked for."""
    target: Any = pyfuncitem.funcargs.get("hil_target")
    if target is None:
        return None
    names = pyfuncitem._fixtureinfo.argnames
    words = {name: pyfuncitem.funcargs[name] for name in names}
    for _ in range(pyfuncitem.config.stash[SESSION].asked.reruns):
        try:
            pyfuncitem.obj(**words)
            return True
        except Exception as error:
            if not blocked(error):
                raise
            reset(target)
    return None  # the last time as any other test


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Say BLOCKED of a test that could not be made, and a sentence where that says all."""
    report = yield
    if call.excinfo is not None and _of_firmware(item):
        if isinstance(call.excinfo.value, pytest.skip.Exception):
            report.user_properties.append((VERDICT, NOT_TRIED))
            item.user_properties.append((VERDICT, NOT_TRIED))  # for JUnit, which reads the last
        error, sets_up = call.excinfo.value, call.when == "setup"
        if blocked(error, sets_up):
            report.user_properties.append((VERDICT, BLOCKED))
        if sets_up and report.failed:
            if FILES in item.stash:
                item.stash[FILES].finish(str(error))
            if is_a_sentence(error) and not item.config.getoption("fulltrace", False):
                report.longrepr = call.excinfo.getrepr(style="value", chain=False)
    return report


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    """Take what a worker of pytest-xdist has found; one that has died has lost it."""
    node.config.stash[SESSION].take(getattr(node, "workeroutput", {}).get(WORKER))


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write what was asked for, or hand it over."""
    own = session.config.stash[SESSION]
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output[WORKER] = own.hand_over()
    else:
        session.config.stash[_LINES] += own.finish()
        if own.failed:
            session.exitstatus = pytest.ExitCode.USAGE_ERROR


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say what was tried."""
    lines = config.stash.get(_LINES, [])
    if lines:
        terminalreporter.section("firmware on trial")
        for line in lines:
            terminalreporter.write_line(printable(line))


def _of_firmware(item: pytest.Item) -> bool:
    """Whether a test asks for a fixture of ours, or stands for a requirement of this firmware."""
    names = getattr(item, "fixturenames", ())
    asks = not FIXTURES.isdisjoint(names)
    required = item.get_closest_marker("hil_req") is not None
    return asks or (required and not of_reference(item.config, item.path))


def _is_ours(metafunc: pytest.Metafunc, name: str) -> bool:
    """Whether a test gets our fixture of this name, and not one of its own project."""
    known = metafunc.definition._fixtureinfo.name2fixturedefs.get(name, ())
    return bool(known) and known[-1].func.__module__ == fixtures_of.__module__


def _check_needs(item: pytest.Item) -> None:
    for mark in item.iter_markers("hil_needs"):
        target: Target | None = getattr(item, "funcargs", {}).get("hil_target")
        if target is None:
            pytest.fail("hil_needs is about a target; ask for the fixture hil_target", False)
        lacks = [one for one in mark.args if one not in target.caps]
        if lacks:
            missing(item, f"{target.url} cannot show: {', '.join(lacks)}")
