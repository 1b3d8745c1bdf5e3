"""What holds for all tests."""

import signal

# a job in the background of a script begins with SIGINT ignored, and so would every process that a test starts and interrupts
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
