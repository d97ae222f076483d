import os
import shlex
import subprocess

import pytest

from crazychoir_fw.common.errors import CheckoutError
from crazychoir_fw.firmware import checkout as module
from crazychoir_fw.firmware.checkout import CMSIS_HEADER, describe, locate, open_checkout


def fill(root, *names):
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    return root


COMPLETE = ("bindings/setup.py", "src/modules/src/controller/controller_pid.c", str(CMSIS_HEADER))


def git(root, *arguments):
    identity = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.com", "-c", "commit.gpgsign=false"]
    return subprocess.run(["git", *identity, "-C", str(root), *arguments], check=True, capture_output=True, text=True)


@pytest.fixture
def repository(tmp_path):
    root = fill(tmp_path / "my firmware ü", *COMPLETE)
    git(root, "init", "-q")
    git(root, "add", ".")
    git(root, "commit", "-qm", "all")
    git(root, "tag", "2026.08")
    return root


def test_a_complete_checkout_opens(repository):
    opened = open_checkout(repository)
    assert opened.root == repository
    assert opened.version() == "2026.08"


def test_the_given_path_comes_before_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(tmp_path / "b"))
    assert locate(tmp_path / "a") == tmp_path / "a"
    assert locate() == tmp_path / "b"
    monkeypatch.delenv("CRAZYFLIE_FIRMWARE")
    monkeypatch.setattr(module, "project_root", lambda: tmp_path)
    assert locate() == tmp_path / "firmware"


def test_an_installed_package_finds_the_submodule_from_within_the_repository(tmp_path, monkeypatch):
    repository = fill(tmp_path / "repository", "bindings/provider.h", "pyproject.toml", "docs/firmware.md")
    monkeypatch.delenv("CRAZYFLIE_FIRMWARE", raising=False)
    monkeypatch.setattr(module.crazychoir_fw, "__file__", str(tmp_path / "site-packages/crazychoir_fw/__init__.py"))
    monkeypatch.chdir(repository / "docs")
    assert locate() == repository / "firmware"
    (repository / "firmware").mkdir()
    with pytest.raises(
        CheckoutError, match=r"submodule firmware/ is empty: run `git submodule update --init firmware`"
    ):
        open_checkout()


def test_a_checkout_has_one_name(tmp_path, monkeypatch):
    (tmp_path / "a").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "a")
    monkeypatch.chdir(tmp_path / "a")
    monkeypatch.setenv("HOME", str(tmp_path))
    for name in ("../a", ".", "../link", "~/a", tmp_path / "b" / ".." / "a"):
        assert locate(name) == tmp_path / "a"
        monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(name))
        assert locate() == tmp_path / "a"


def test_an_installed_package_says_what_to_clone(monkeypatch):
    monkeypatch.delenv("CRAZYFLIE_FIRMWARE", raising=False)
    monkeypatch.setattr(module, "project_root", lambda: None)
    with pytest.raises(CheckoutError, match="git clone --recurse-submodules .*CRAZYFLIE_FIRMWARE"):
        locate()


def test_no_such_folder(tmp_path):
    with pytest.raises(CheckoutError, match=f"no firmware checkout at {tmp_path}/none: there is no such folder"):
        open_checkout(tmp_path / "none")


def test_submodule_that_is_not_initialized(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "project_root", lambda: tmp_path)
    (tmp_path / "firmware").mkdir()
    with pytest.raises(CheckoutError, match=r"run `git submodule update --init firmware` in "):
        open_checkout(tmp_path / "firmware")


def test_wrong_path(tmp_path):
    fill(tmp_path, "README.md")
    with pytest.raises(CheckoutError, match="is not a checkout of the Crazyflie firmware, it has no src/"):
        open_checkout(tmp_path)


def test_old_release(tmp_path):
    fill(tmp_path, "bindings/setup.py", "src/modules/src/controller_pid.c", str(CMSIS_HEADER))
    with pytest.raises(CheckoutError, match=r"too old.*supported are releases 2024\.10 and later: run `git -C"):
        open_checkout(tmp_path)


def test_missing_cmsis_names_a_command_that_a_shell_understands(tmp_path):
    root = fill(tmp_path / "a b", *COMPLETE[:2])
    with pytest.raises(CheckoutError) as raised:
        open_checkout(root)
    command = str(raised.value).split("`")[1]
    assert shlex.split(command) == ["git", "-C", str(root), "submodule", "update", "--init", "vendor/CMSIS"]


def test_version_of_changed_sources(repository):
    (repository / COMPLETE[1]).write_text("int x;")
    assert describe(repository) == "2026.08-dirty"


def test_a_folder_in_another_repository_has_no_version_of_its_own(repository):
    inner = fill(repository / "export", *COMPLETE)
    assert describe(inner) is None
    (inner / ".git").mkdir()
    assert describe(inner) is None


def test_no_version_without_git(repository, monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert describe(repository) is None


def test_asking_for_the_version_writes_nothing(repository):
    index = repository / ".git" / "index"
    touched = repository / COMPLETE[1]
    # git would like to note the new time in its index
    touched.write_text(touched.read_text())
    before = index.read_bytes(), index.stat().st_mtime_ns
    assert describe(repository) == "2026.08"
    assert (index.read_bytes(), index.stat().st_mtime_ns) == before


def test_asking_for_the_version_runs_no_program_of_the_repository(repository, tmp_path):
    hook = tmp_path / "hook"
    hook.write_text(f"#!/bin/sh\ntouch '{tmp_path}/ran'\n")
    hook.chmod(0o755)
    git(repository, "config", "core.fsmonitor", str(hook))
    assert describe(repository) == "2026.08"
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("driver", ["clean", "process"])
def test_asking_for_the_version_runs_no_filter_of_the_repository(repository, tmp_path, driver):
    source = repository / COMPLETE[1]
    (repository / ".git" / "info").mkdir(exist_ok=True)
    (repository / ".git" / "info" / "attributes").write_text("* filter=a=b.c\n")
    git(repository, "config", f"filter.a=b.c.{driver}", f"touch '{tmp_path}/ran'; cat")
    git(repository, "config", "filter.a=b.c.required", "true")
    # a file that looks changed is read, and filters come before that
    source.write_text(source.read_text())
    os.utime(source, ns=(10**18, 10**18))
    assert describe(repository) == "2026.08"
    assert not (tmp_path / "ran").exists()


def test_git_that_takes_too_long_is_ended(repository, tmp_path, monkeypatch):
    slow = tmp_path / "bin" / "git"
    slow.parent.mkdir()
    slow.write_text('#!/bin/sh\n[ "$6" = config ] && exit 1\nexec sleep 600\n')
    slow.chmod(0o755)
    monkeypatch.setenv("PATH", str(slow.parent), prepend=os.pathsep)
    asked = []
    real = subprocess.Popen

    class Impatient(real):
        def __init__(self, *args, **options):
            super().__init__(*args, **options)
            asked.append(self)

        def communicate(self, *args, timeout=None):
            return super().communicate(*args, timeout=0.05 if len(asked) > 1 else timeout)

    monkeypatch.setattr(module.subprocess, "Popen", Impatient)
    assert describe(repository) is None
    assert len(asked) == 3
    assert all(process.returncode is not None and process.stdout.closed for process in asked)
