"""Real Stamps on a cable: both controllers' bench hooks as targets.

The chip must be in bench mode or have just been reset; opening a port asks for no reset
(DECISIONS.md 43). What is said on the wire is `cgagen.link.bench_hook`'s; here is who is asked, and
what must be in the chip.
"""

from itertools import count

from cgagen.bench_protocol import Banner, reading_text
from cgagen.closing import Closing
from cgagen.errors import IdentityError, RigError, TargetTimeout
from cgagen.flash import plan_of
from cgagen.flash.verify import read_sent
from cgagen.link.bench_hook import BenchHook, banner_in
from cgagen.stamp.image import Image
from hil.roster import check_reading
from hil.subject import Subject
from hil.target import IMAGE, STATE, Identity, Observation, Stimulus

SERIAL, SERIAL_RESET = "serial", "serial-reset"
"""How the name of such a target begins: left alone, or reset when it is opened."""


class OtherChipError(IdentityError):
    """The other controller is behind the port, whatever is in it: a wrong cable."""


class WiredChip(Closing):
    """A controller on a port, with the subject's bytes in it.

    Args:
        port: a device, `id:SERIAL`, `auto`, or a URL of pyserial's.
        subject: what is to be in the chip.
        gaps: leave the pauses that a Stamp needs; a server of emulated chips leaves them itself.
        reset: pulse ATN by DTR when it is opened. Otherwise it has to listen: a Stamp does so for
            half a second after a reset, and in bench mode.

    Attributes:
        hook: the conversation.
        chip: `main` or `locomotion`.
    """

    chip: str

    def __init__(self, port: str, subject: Subject, gaps: bool = True, reset: bool = False) -> None:
        self.url = f"{SERIAL_RESET if reset else SERIAL}:{port}"
        self.subject = subject
        self._resets = reset
        self.hook = BenchHook(port, gaps)

    @property
    def stale(self) -> int:
        """Answers to earlier questions that came late and were thrown away."""
        return self.hook.stale

    def open(self) -> None:
        """Open the port, say hello, and make sure that the chip holds the subject's bytes.

        Raises:
            RigError: no such port, or nobody answers.
            IdentityError: another program is in the chip.
        """
        self.hook.open()
        try:
            if self._resets:
                self.reset()
            else:
                self._greet()
            self._prove()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the port; the chip stays in bench mode, so that it does not walk away."""
        self.hook.close()

    def reset(self) -> None:
        """Pulse ATN by DTR, say hello again, and look who has greeted.

        Raises:
            RigError: this port has no DTR, or nobody answers afterwards.
            IdentityError: another program greets.
        """
        self._compare(self.hook.enter())

    def identity(self) -> Identity:
        """Return what the banner in the EEPROM says, with the digest of all that is loaded."""
        image = self.subject.images[self.chip]
        eeprom = read_sent(self.hook, plan_of(image))
        banner = banner_in(eeprom) or self.hook.banner()  # another program's lies elsewhere
        self._compare(banner)
        digest = Image(image.model, eeprom).digest
        return Identity(banner.robot, banner.genome, {self.chip: digest}, self.hook.nonce)

    def _greet(self) -> None:
        """Say hello; a chip that does not listen is at work, and nothing is known of it."""
        try:
            self.hook.hello()
        except TargetTimeout as error:
            raise RigError(
                f"{error}, or have it reset by DTR: {SERIAL_RESET}:{self.hook.port}"
            ) from error

    def _prove(self) -> None:
        found = self.identity().images[self.chip]
        wanted = self.subject.images[self.chip].digest
        if found != wanted:
            raise IdentityError(
                f"{self.hook.port}: the chip's EEPROM has digest {found[:8]}, the image "
                f"{wanted[:8]}; load the image again"
            )

    def _compare(self, banner: Banner) -> None:
        port, subject = self.hook.port, self.subject
        if banner.chip != self.chip:
            raise OtherChipError(
                f"{port}: the {banner.chip} controller is behind it, not the {self.chip} "
                "controller; give the other port"
            )
        if (banner.robot, banner.genome) != (subject.plain_name, subject.genome_digest):
            raise IdentityError(
                f"{port}: the chip holds {banner.robot} with genome {banner.genome}, not "
                f"{subject.plain_name} with {subject.genome_digest}; load that build"
            )


class WiredTarget(WiredChip):
    """The main controller: it is told what it would measure, and decides."""

    chip = "main"
    caps = frozenset({STATE, IMAGE})

    def __init__(self, port: str, subject: Subject, gaps: bool = True, reset: bool = False) -> None:
        super().__init__(port, subject, gaps, reset)
        self._questions = count(0)

    def decide(self, stimulus: Stimulus) -> Observation:
        """Ask for a decision.

        Raises:
            ReadingError: the stimulus is not one of this robot.
            TargetTimeout: it listens and does not answer.
            RigError: nothing comes from it any more.
        """
        check_reading(stimulus, self.subject.robot)
        left, right = stimulus.touched
        readings = reading_text((not left) | (not right) << 1, (*stimulus.sonars, *stimulus.lights))
        try:
            answer = self.hook.question(readings)
        except TargetTimeout as error:
            raise TargetTimeout(f"{error} (the reading was {stimulus.text()})") from error
        return Observation(next(self._questions), answer.command, answer.state)


class WiredLegs(WiredChip):
    """The locomotion controller: it is told to walk, and says when the legs stand."""

    chip = "locomotion"

    def move(self, command: int, sign: str | None = None) -> None:
        """Have a movement walked once; returns when the legs stand.

        Args:
            command: 0 to 7.
            sign: a character; the one of the movement before is answered and not walked again.

        Raises:
            RigError: it does not take it, or does not end it.
        """
        self.hook.move(command, sign)

    def centre(self) -> None:
        """Have all legs put down and straight out. Raises RigError."""
        self.hook.centre()

    def leave(self) -> None:
        """Let it wait for GO again. Raises RigError."""
        self.hook.leave()
