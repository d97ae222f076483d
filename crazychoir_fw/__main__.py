"""`python -m crazychoir_fw` is the command `crazychoir`."""

from crazychoir_fw.cli import app

if __name__ == "__main__":
    app(prog_name="crazychoir")
