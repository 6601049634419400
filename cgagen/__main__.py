"""`python -m cgagen` and the `cgagen` script."""


def run() -> None:
    """Run the command line and leave with its exit code."""
    try:
        from cgagen.cli import main
    except KeyboardInterrupt:  # so early that nobody else could say it
        raise SystemExit(130) from None
    raise SystemExit(main())


if __name__ == "__main__":
    run()
