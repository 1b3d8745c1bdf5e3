/* For LD_PRELOAD: ends or fails the n-th call that changes a file, as a kill or a full disk at that moment would.
   fault_set(mode, n): mode 0 count only, 1 kill before the call, 2 kill after half of a write, 3 no space from the call on. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <sys/types.h>
#include <unistd.h>

static int mode = 0;
static long wanted = -1, count = 0;

void fault_set(int new_mode, long n) { mode = new_mode; wanted = n; count = 0; }
long fault_count(void) { return count; }

/* 0: go on, 1: fail, 2: half of it, then die */
static int met(void)
{
    long now = count++;
    if (mode == 3 && now >= wanted) { errno = ENOSPC; return 1; }
    if (now == wanted && mode == 1) kill(getpid(), SIGKILL);
    return now == wanted && mode == 2 ? 2 : 0;
}

typedef ssize_t (*pwrite_t)(int, const void *, size_t, off_t);

static ssize_t written(const char *name, int fd, const void *data, size_t size, off_t offset)
{
    pwrite_t real = (pwrite_t)dlsym(RTLD_NEXT, name);
    int what = met();
    if (what == 1) return -1;
    if (what == 2) { real(fd, data, size / 2, offset); kill(getpid(), SIGKILL); }
    return real(fd, data, size, offset);
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t offset) { return written("pwrite", fd, data, size, offset); }
ssize_t pwrite64(int fd, const void *data, size_t size, off_t offset) { return written("pwrite64", fd, data, size, offset); }

#define SIMPLE(name, parameters, arguments) \
    int name parameters { int (*real) parameters = (int (*) parameters)dlsym(RTLD_NEXT, #name); \
                          int what = met(); if (what == 1) return -1; if (what == 2) kill(getpid(), SIGKILL); \
                          return real arguments; }
SIMPLE(ftruncate, (int fd, off_t size), (fd, size))
SIMPLE(ftruncate64, (int fd, off_t size), (fd, size))
SIMPLE(fsync, (int fd), (fd))
SIMPLE(rename, (const char *old, const char *new), (old, new))
