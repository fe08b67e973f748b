"""A seccomp filter without any library: no new processes, signals to others, sockets, or changes to
files.

The system calls refused fail with EPERM; those that this table does not know (newer than it) with
ENOSYS.
"""

from __future__ import annotations

import ctypes
import errno
import os
import struct

# Name, number on x86_64, on aarch64, - where the machine has none.
_REFUSED = """
fork                 57    -
vfork                58    -
clone                56  220
execve               59  221
execveat            322  281
kill                 62  129
tkill               200  130
tgkill              234  131
rt_sigqueueinfo     129  138
rt_tgsigqueueinfo   297  240
ptrace              101  117
process_vm_readv    310  270
process_vm_writev   311  271
kcmp                312  272
setsid              112  157
setpgid             109  154
setpriority         141  140
sched_setparam      142  118
sched_setscheduler  144  119
sched_setaffinity   203  122
sched_setattr       314  274
ioprio_set          251   30
migrate_pages       256  238
move_pages          279  239
prctl               157  167
personality         135   92
unshare             272   97
setns               308  268
mount               165   40
umount2             166   39
pivot_root          155   41
chroot              161   51
quotactl            179   60
acct                163   89
add_key             248  217
request_key         249  218
keyctl              250  219
bpf                 321  280
perf_event_open     298  241
userfaultfd         323  282
socket               41  198
socketpair           53  199
shmget               29  194
semget               64  190
msgget               68  186
mq_open             240  180
memfd_create        319  279
fanotify_init       300  262
open_by_handle_at   304  265
creat                85    -
mkdir                83    -
mkdirat             258   34
rmdir                84    -
unlink               87    -
unlinkat            263   35
rename               82    -
renameat            264   38
renameat2           316  276
link                 86    -
linkat              265   37
symlink              88    -
symlinkat           266   36
mknod               133    -
mknodat             259   33
chmod                90    -
fchmod               91   52
fchmodat            268   53
chown                92    -
fchown               93   55
lchown               94    -
fchownat            260   54
truncate             76   45
ftruncate            77   46
fallocate           285   47
utime               132    -
utimes              235    -
utimensat           280   88
futimesat           261    -
setxattr            188    5
lsetxattr           189    6
fsetxattr           190    7
removexattr         197   14
lremovexattr        198   15
fremovexattr        199   16
"""
# From this number on the machines agree: close_range, faccessat2, epoll_pwait2, futex_waitv,
# cachestat, map_shadow_stack, futex_wake, futex_wait, futex_requeue and mseal are let through.
_NEW, _NEW_KEPT = 424, (436, 439, 441, 449, 451, 453, 454, 455, 456, 462)
_MACHINES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}
_OPEN, _OPENAT, _FCNTL, _IOCTL, _PRLIMIT = (2, None), (257, 56), (72, 25), (16, 29), (302, 261)
_WRITING = (
    os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | 0o20000000
)  # the last is O_TMPFILE's own bit
_OWNERS = (8, 10, 15)  # F_SETOWN, F_SETSIG, F_SETOWN_EX: signals to others by way of a descriptor
_IOCTLS = (
    0x5401,
    0x5413,
    0x541B,
    0x5421,
    0x5450,
    0x5451,
)  # is it a terminal, its size, bytes waiting, flags
_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = (
    0x20,
    0x15,
    0x35,
    0x45,
    0x06,
)  # the filter machine's instructions
_ALLOW, _REFUSE, _UNKNOWN, _KILL = (
    0x7FFF0000,
    0x00050000 | errno.EPERM,
    0x00050000 | errno.ENOSYS,
    0x80000000,
)
_NO_NEW_PRIVILEGES, _SECCOMP, _FILTER = 38, 22, 2  # prctl


def program(machine: str) -> list[tuple[int, int, int, int]]:
    """Return the filter's instructions (code, jump if true, jump if false, operand) for "x86_64" or
    "aarch64".
    """
    column, architecture = _MACHINES[machine]

    def ends(compare, operand, outcome):
        return [(compare, 0, 1, operand), (_RETURN, 0, 0, outcome)]

    def argument(call, index, *then):
        if call[column] is None:
            return []
        steps = [(_LOAD, 0, 0, 16 + 8 * index), *then]
        return [(_EQUAL, 0, len(steps), call[column]), *steps]

    allow, refuse = (_RETURN, 0, 0, _ALLOW), (_RETURN, 0, 0, _REFUSE)
    steps = [
        (_LOAD, 0, 0, 4),
        (_EQUAL, 1, 0, architecture),
        (_RETURN, 0, 0, _KILL),
        (_LOAD, 0, 0, 0),
    ]
    for call in _REFUSED.strip().splitlines():
        number = call.split()[1 + column]
        if number != "-":
            steps += ends(_EQUAL, int(number), _REFUSE)
    steps += argument(_OPEN, 1, *ends(_ANY_BIT, _WRITING, _REFUSE), allow)
    steps += argument(_OPENAT, 2, *ends(_ANY_BIT, _WRITING, _REFUSE), allow)
    steps += argument(
        _FCNTL, 1, *(s for command in _OWNERS for s in ends(_EQUAL, command, _REFUSE)), allow
    )
    steps += argument(
        _IOCTL, 1, *(s for request in _IOCTLS for s in ends(_EQUAL, request, _ALLOW)), refuse
    )
    steps += argument(_PRLIMIT, 0, *ends(_EQUAL, 0, _ALLOW), refuse)  # of this process only
    for number in _NEW_KEPT:
        steps += ends(_EQUAL, number, _ALLOW)
    return [*steps, *ends(_AT_LEAST, _NEW, _UNKNOWN), allow]


def install() -> bool:
    """Filter this process for ever; whether the machine and its kernel can."""
    machine = os.uname().machine
    if machine not in _MACHINES or struct.calcsize("P") != 8:
        return False
    steps = program(machine)
    code = b"".join(struct.pack("=HBBI", *step) for step in steps)
    memory = ctypes.create_string_buffer(code, len(code))
    header = ctypes.create_string_buffer(struct.pack("@HP", len(steps), ctypes.addressof(memory)))
    prctl = ctypes.CDLL(None).prctl
    prctl.argtypes = [ctypes.c_int] + [ctypes.c_ulong] * 4
    return (
        prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) == 0
        and prctl(_SECCOMP, _FILTER, ctypes.addressof(header), 0, 0) == 0
    )
