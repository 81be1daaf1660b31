"""`python -m harness.cli`: the command line, where the script `plumbline` is not on the path."""

from plumbline.harness.cli.main import main

if __name__ == "__main__":
    main()
