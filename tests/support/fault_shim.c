/* For LD_PRELOAD: ends or fails the n-th call that changes a file, as a kill, a full or a failing disk at that moment would.
   fault_set(mode, n): mode 0 count only, 1 kill before the call, 2 kill behind it (a write: behind half of it), 3 no space from the
   call on, 4 an I/O error of this call. fault_under(folder): only calls on what is in this folder, and then opening for writing,
   making, renaming and removing as well; "": all writes, wherever they go.
   memory_set(n, lasting): the n-th allocation by HDF5 or NumPy finds no memory, lasting: all from then on; n < 0: none. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum { GO_ON, FAIL, THEN_DIE };
static int mode = 0;
static long wanted = -1, count = 0;
static char under[PATH_MAX] = "";

void fault_set(int new_mode, long n) { mode = new_mode; wanted = n; count = 0; }
void fault_under(const char *folder) { snprintf(under, sizeof under, "%s", folder); }
long fault_count(void) { return count; }

static void end(void) { kill(getpid(), SIGKILL); }

/* whether a name below an open folder (AT_FDCWD: the current one) is in the folder that is watched; NULL: the open file itself */
static int is_watched(int folder, const char *name)
{
    char link[64], whole[2 * PATH_MAX] = "";
    if (!name || (name[0] != '/' && folder != AT_FDCWD)) {
        snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
        ssize_t n = readlink(link, whole, PATH_MAX - 1);
        if (n < 0) return 0;
        whole[n] = 0;
    } else if (name[0] != '/' && !getcwd(whole, PATH_MAX)) return 0;
    if (name) {
        if (name[0] == '/') whole[0] = 0; else strcat(whole, "/");
        strncat(whole, name, PATH_MAX - 1);
    }
    return strncmp(whole, under, strlen(under)) == 0;
}

static int met(void)
{
    long now = count++;
    if (mode == 3 && now >= wanted) { errno = ENOSPC; return FAIL; }
    if (now != wanted) return GO_ON;
    if (mode == 4) { errno = EIO; return FAIL; }
    if (mode == 1) end();
    return mode == 2 ? THEN_DIE : GO_ON;
}

/* of a call that only counts where a folder is watched, and of one that counts anywhere if none is */
static int met_in(int folder, const char *name) { return under[0] && is_watched(folder, name) ? met() : GO_ON; }
static int met_any(int file, const char *name) { return !under[0] || is_watched(file, name) ? met() : GO_ON; }

/* a function of libc: TYPE is that of the function */
#define REAL(type, name) type *real = (type *)dlsym(RTLD_NEXT, name)
#define DONE(what, call) do { int met_ = (what); if (met_ == FAIL) return -1; \
                              int result = (call); if (met_ == THEN_DIE) end(); return result; } while (0)

/* allocations by HDF5 and NumPy; those of Python and of libraries below are left alone, since a process cannot go on without them */
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
static long memory_wanted = -1, memory_seen = 0;
static int memory_lasting = 0;

void memory_set(long n, int lasting) { memory_seen = 0; memory_lasting = lasting; memory_wanted = n; }
long memory_count(void) { return memory_seen; }

static int starved(void *caller)
{
    Dl_info info;
    if (memory_wanted < 0 || !dladdr(caller, &info) || !info.dli_fname) return 0;
    if (!strstr(info.dli_fname, "libhdf5") && !strstr(info.dli_fname, "_multiarray_umath")) return 0;
    long now = memory_seen++;
    if (memory_lasting ? now < memory_wanted : now != memory_wanted) return 0;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) { return starved(__builtin_return_address(0)) ? NULL : __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return starved(__builtin_return_address(0)) ? NULL : __libc_calloc(n, size); }
void *realloc(void *old, size_t size) { return starved(__builtin_return_address(0)) ? NULL : __libc_realloc(old, size); }

typedef ssize_t pwrite_t(int, const void *, size_t, off_t);
typedef ssize_t write_t(int, const void *, size_t);
typedef int open_t(const char *, int, ...);
typedef int openat_t(int, const char *, int, ...);
typedef int on_file_t(int);
typedef int truncate_t(int, off_t);
typedef int two_names_t(const char *, const char *);
typedef int two_at_t(int, const char *, int, const char *);
typedef int remove_at_t(int, const char *, int);
typedef int make_at_t(int, const char *, mode_t);

static ssize_t written(const char *name, int fd, const void *data, size_t size, off_t offset)
{
    REAL(pwrite_t, name);
    int what = met_any(fd, NULL);
    if (what == FAIL) return -1;
    if (what == THEN_DIE) { real(fd, data, size / 2, offset); end(); }
    return real(fd, data, size, offset);
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t offset) { return written("pwrite", fd, data, size, offset); }
ssize_t pwrite64(int fd, const void *data, size_t size, off_t offset) { return written("pwrite64", fd, data, size, offset); }

ssize_t write(int fd, const void *data, size_t size)
{
    REAL(write_t, "write");
    int what = met_in(fd, NULL);
    if (what == FAIL) return -1;
    if (what == THEN_DIE) { real(fd, data, size / 2); end(); }
    return real(fd, data, size);
}

static int opened(int folder, const char *name, int flags, mode_t rights)
{
    REAL(openat_t, "openat");
    int writes = (flags & O_ACCMODE) != O_RDONLY;
    DONE(writes ? met_in(folder, name) : GO_ON, real(folder, name, flags, rights));
}

static mode_t rights_of(int flags, va_list more) { return flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0; }

#define OPEN(function) \
    int function(const char *name, int flags, ...) \
    { va_list more; va_start(more, flags); mode_t rights = rights_of(flags, more); va_end(more); \
      return opened(AT_FDCWD, name, flags, rights); }
#define OPEN_AT(function) \
    int function(int folder, const char *name, int flags, ...) \
    { va_list more; va_start(more, flags); mode_t rights = rights_of(flags, more); va_end(more); \
      return opened(folder, name, flags, rights); }
OPEN(open)
OPEN(open64)
OPEN_AT(openat)
OPEN_AT(openat64)

int ftruncate(int fd, off_t size) { REAL(truncate_t, "ftruncate"); DONE(met_any(fd, NULL), real(fd, size)); }
int ftruncate64(int fd, off_t size) { REAL(truncate_t, "ftruncate64"); DONE(met_any(fd, NULL), real(fd, size)); }
int fsync(int fd) { REAL(on_file_t, "fsync"); DONE(met_any(fd, NULL), real(fd)); }
int rename(const char *old, const char *new) { REAL(two_names_t, "rename"); DONE(met_any(AT_FDCWD, new), real(old, new)); }
int renameat(int from, const char *old, int to, const char *new)
{ REAL(two_at_t, "renameat"); DONE(met_any(to, new), real(from, old, to, new)); }
int unlinkat(int folder, const char *name, int flags)  /* which a full disk does not keep from being done */
{ REAL(remove_at_t, "unlinkat"); DONE(mode == 3 ? GO_ON : met_in(folder, name), real(folder, name, flags)); }
int mkdirat(int folder, const char *name, mode_t rights)
{ REAL(make_at_t, "mkdirat"); DONE(met_in(folder, name), real(folder, name, rights)); }
int mkdir(const char *name, mode_t rights) { return mkdirat(AT_FDCWD, name, rights); }
