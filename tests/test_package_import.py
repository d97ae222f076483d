import os
import subprocess
import sys


def test_sources_that_are_not_built_say_so_in_one_sentence():
    code = "import sys; sys.modules['crazychoir_fw._core'] = None; import crazychoir_fw"
    answer = subprocess.run([sys.executable, "-c", code], env=os.environ, capture_output=True, text=True)
    assert answer.returncode == 1
    assert answer.stderr.splitlines()[-1].startswith("ImportError: crazychoir_fw is imported from its sources in ")
    assert "in another folder to use the installed package" in answer.stderr
    assert answer.stderr.count("Traceback") == 1
    assert "_core" not in answer.stderr


def test_help_reads_no_markdown():
    code = "import sys; from crazychoir_fw.cli import app; sys.argv = ['crazychoir', '--help']\n"
    code += "try: app()\nexcept SystemExit: sys.exit('markdown_it' in sys.modules or 'numpy' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], env=os.environ, capture_output=True, text=True)
    assert (answer.returncode, answer.stderr) == (0, "")
    assert "Fly a mission" in answer.stdout
