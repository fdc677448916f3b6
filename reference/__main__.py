"""`python -m reference` rebuilds the stored truth of the catalogue; with `--prove NAME` it proves a case's motion."""

import sys


def main(argv: list[str]) -> int:
    if any(word == "--prove" or word.startswith("--prove=") for word in argv):
        from .proofs import command

        return command.main(argv)
    from .certification.rebuild import main as rebuild

    return rebuild(argv)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
