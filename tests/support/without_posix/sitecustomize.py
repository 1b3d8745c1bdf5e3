"""Python on Linux without what Windows lacks, and with what it has instead: for tests of rsc.operating_system.windows.

Begun by Python itself where this folder is in PYTHONPATH. What is taken away: modules, names of `os` and `signal`, `dir_fd`, the
opening of folders, paths above 259 characters, and every renaming, replacing or removing of a file that any process has open.
What is added: `msvcrt.locking`, `GlobalMemoryStatusEx`, `hdf5.dll`, `O_BINARY`, `SIGBREAK`. What would go wrong silently on
Windows is an AssertionError: a file opened in text mode, a lock on what others read, `os.kill(pid, 0)`.

It is Linux still: names of files, shells, compiled code and HDF5 are not tried by it. Some names that rsc may not use (mypy with
--platform win32 sees to that) are left, since libraries take Linux for granted: `getuid`, `uname`, `statvfs`.
"""

import ctypes
import errno
import fcntl as real_fcntl
import functools
import os
import shutil
import signal
import stat
import subprocess  # noqa: F401 (as well; would take msvcrt for Windows)
import sys
import tempfile
import types

MODULES = {"fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "readline", "curses"}
NAMES = {
    "O_NOFOLLOW", "O_NONBLOCK", "O_NOCTTY", "O_DIRECTORY", "O_PATH", "O_CLOEXEC", "O_SYNC", "geteuid", "getegid", "getgid",
    "fork", "forkpty", "killpg", "setsid", "getpgid", "getpgrp", "mkfifo", "mknod", "pread", "pwrite", "preadv", "pwritev",
    "chown", "lchown", "fchown", "fchmod", "sched_getaffinity", "sched_setaffinity", "nice", "fchdir", "fdatasync", "getloadavg",
    "chroot", "wait3", "wait4", "posix_spawn", "posix_spawnp", "sync", "getgroups", "getxattr", "setxattr", "listxattr",
}  # fmt: skip
SIGNALS = {"SIGKILL", "SIGHUP", "SIGALRM", "SIGUSR1", "SIGUSR2", "SIGQUIT", "alarm", "setitimer", "pthread_kill"}
LONGEST_PATH = 259
O_BINARY = 1 << 30  # no flag of Linux
IN_USE = PermissionError, errno.EACCES, "The process cannot access the file because it is being used by another process"


def _refuse(error, number, text, *names):
    raise error(number, text, *map(os.fspath, names))


class _Without:
    """A finder of modules that does not find some."""

    def __init__(self, finder):
        self._finder = finder

    def __getattr__(self, name):
        return getattr(self._finder, name)

    def find_spec(self, name, path=None, target=None):
        return None if name in MODULES else self._finder.find_spec(name, path, target)


def _is_open(path):
    """Whether any process has the file open."""
    try:
        wanted = os.stat(path)
    except OSError:
        return False
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            names = os.listdir(f"/proc/{process}/fd")
        except OSError:
            continue
        for name in names:
            try:
                held = os.stat(f"/proc/{process}/fd/{name}")
            except OSError:
                continue
            if stat.S_ISREG(held.st_mode) and (held.st_dev, held.st_ino) == (wanted.st_dev, wanted.st_ino):
                return True
    return False


def _short(path):
    if isinstance(path, (str, os.PathLike)) and len(os.path.abspath(path)) > LONGEST_PATH:
        _refuse(FileNotFoundError, errno.ENOENT, "The system cannot find the path specified", path)


def _on_paths(name, closed=False):
    """A function of `os` that takes its paths, and no descriptors of folders; closed: none of them may be open."""
    function = getattr(os, name)

    @functools.wraps(function)
    def changed(*paths, **how):
        if any(how.pop(key, None) is not None for key in ("dir_fd", "src_dir_fd", "dst_dir_fd")):
            raise NotImplementedError(f"{name}: dir_fd unavailable on this platform")
        if isinstance(paths[0], int) and name in ("listdir", "scandir"):
            raise TypeError(f"{name}: path should be string, not int")
        for path in paths:
            _short(path)
            if closed and isinstance(path, (str, os.PathLike)) and _is_open(path):
                _refuse(*IN_USE, path)
        return function(*paths, **how)

    setattr(os, name, changed)


def _opened(path, flags, mode=0o777, *, dir_fd=None, real=os.open):
    if dir_fd is not None:
        raise NotImplementedError("open: dir_fd unavailable on this platform")
    _short(path)
    caller = sys._getframe(1).f_globals.get("__name__", "")
    assert not caller.startswith("rsc.") or flags & O_BINARY or path == os.devnull, f"{caller} opens {path} as text"
    if os.path.isdir(path):
        _refuse(PermissionError, errno.EACCES, "Permission denied", path)
    return real(path, flags & ~O_BINARY, mode)


def _killed(process, number, real=os.kill):
    assert number != 0, "os.kill(pid, 0) ends the process"
    real(process, number)


def _msvcrt():
    """Locks of bytes from the present place on, which hold others off; here by another kind of lock of the same file."""

    def locking(handle, mode, count):
        name = os.readlink(f"/proc/self/fd/{handle}")
        assert name.endswith("lock"), f"nobody could read what is locked of {name}"
        assert os.lseek(handle, 0, os.SEEK_CUR) >= os.fstat(handle).st_size, f"nobody could read the locked part of {name}"
        try:
            real_fcntl.flock(handle, real_fcntl.LOCK_EX | real_fcntl.LOCK_NB)
        except BlockingIOError:
            _refuse(PermissionError, errno.EACCES, "Permission denied")

    module = types.ModuleType("msvcrt")
    module.LK_NBLCK, module.locking = 2, locking
    return module


def _memory_status(pointer):
    pointer._obj.available, pointer._obj.available_virtual = 2**33, 2**46
    return 1


class _Library(ctypes.CDLL):
    def __init__(self, name, *rest, **how):
        if name == "hdf5.dll":
            name = sys.modules["h5py.defs"].__file__
        super().__init__(name, *rest, **how)


sys.meta_path[:] = map(_Without, sys.meta_path)
for gone in MODULES:
    sys.modules.pop(gone, None)
for name in ("stat", "lstat", "mkdir", "listdir", "scandir", "rmdir"):
    _on_paths(name)
for name in ("replace", "rename", "unlink", "remove"):
    _on_paths(name, closed=True)
os.open, os.kill = _opened, _killed
os.supports_dir_fd.clear()
shutil._use_fd_functions = False  # which it looked at when it was loaded: a folder is removed by paths
tempfile.TemporaryFile = tempfile.NamedTemporaryFile  # no file is removed while it is open, by Numba's cache neither
os.supports_fd.clear()
signal.SIGBREAK = signal.SIGUSR1
for module, names in ((os, NAMES), (signal, SIGNALS)):
    for name in names & set(vars(module)):
        delattr(module, name)
os.O_BINARY = O_BINARY
sys.modules["msvcrt"] = _msvcrt()
ctypes.windll = types.SimpleNamespace(kernel32=types.SimpleNamespace(GlobalMemoryStatusEx=_memory_status))
ctypes.CDLL = _Library
