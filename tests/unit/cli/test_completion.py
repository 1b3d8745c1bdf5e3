"""`rsc completion`: what a shell offers is what the parsers take."""

import shutil
import subprocess

import pytest

from rsc.cli import main

BASH = shutil.which("bash")


@pytest.fixture
def script(capsys):
    def printed(shell):
        assert main(["completion", shell]) == 0
        return capsys.readouterr().out

    return printed


def offered(script, *words, folder=None):
    """What bash offers for the last word of a command line."""
    line = " ".join(f"'{word}'" for word in ("rsc", *words))
    ask = f'{script}\nCOMP_WORDS=({line}); COMP_CWORD={len(words)}; _rsc; printf "%s\\n" "${{COMPREPLY[@]}}"'
    done = subprocess.run([BASH, "-u", "-c", ask], capture_output=True, text=True, check=True, cwd=folder)
    assert not done.stderr
    return done.stdout.split()


@pytest.mark.skipif(BASH is None, reason="needs bash")
def test_bash_offers_commands_options_and_values(script, tmp_path):
    bash = script("bash")
    assert offered(bash, "re") == ["remedy", "report"] and {"run", "sweep", "completion"} <= set(offered(bash, ""))
    assert offered(bash, "sweep", "--ra") == ["--random"] and offered(bash, "--ver") == ["--version"]
    assert offered(bash, "sweep", "scene.toml", "--vary", "x=1:2:3", "--js") == ["--json"]
    assert offered(bash, "new", "la") == ["laval"] and set(offered(bash, "new", "laval", "--start", "")) >= {"rest"}
    assert offered(bash, "import", "") == ["ross", "fe"] and "--stiffness" in offered(bash, "import", "fe", "--")
    assert "--stiffness" not in offered(bash, "import", "ross", "--")
    assert offered(bash, "run", "sc") == []  # then the shell completes names of files: -o default
    assert "complete -o default -F _rsc rsc" in bash


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish")
@pytest.mark.parametrize(
    ("line", "word"), [("rsc re", "report"), ("rsc sweep --ra", "--random"), ("rsc import fe --stif", "--stiffness")]
)
def test_fish_offers_the_same(line, word, script, tmp_path):
    (tmp_path / "script").write_text(script("fish"))
    ask = f"source script; complete -C '{line}'"
    done = subprocess.run(["fish", "-c", ask], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert [each.split("\t")[0] for each in done.stdout.splitlines()] == [word]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_and_option_is_in_every_script(shell, script, capsys):
    text = script(shell)
    for command in ("check", "compare", "sweep", "impact", "completion"):
        with pytest.raises(SystemExit):
            main([command, "--help"])
        options = [word.strip(",[]") for word in capsys.readouterr().out.split() if word.startswith(("--", "[--"))]
        assert command in text and options
        for option in options:
            assert (f"-l {option[2:]} " if shell == "fish" else option) in text, (command, option)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_is_one_of_its_shell(shell, script, tmp_path):
    program = shutil.which(shell) or pytest.skip(f"needs {shell}")
    (tmp_path / "script").write_text(script(shell))
    assert subprocess.run([program, "-n", tmp_path / "script"], capture_output=True, check=False).returncode == 0


def test_another_shell_is_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["completion", "csh"])
    assert ended.value.code == 2 and "invalid choice" in capsys.readouterr().err
